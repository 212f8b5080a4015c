"""The examples run, and what they print holds."""

import importlib
import math
from pathlib import Path

import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.primitives import FirstOrderTaylorApproximation

from drake_mobman.base import Smoother, Unsmoothed
from drake_mobman.decomposers import Blending

EXAMPLES = Path(__file__).parent.parent.parent / "examples"

ROUNDING = 1e-14
"""Of slopes of at most 1, through a few dozen operations."""

OPTIMAL = 0.01
"""How near SNOPT comes to the best alpha: it is content with a slope of 1e-6, and J has
a curvature of 0.01."""


@pytest.fixture
def example(monkeypatch):
    """A function that imports an example by name, as running it does."""
    monkeypatch.syspath_prepend(EXAMPLES)
    return importlib.import_module


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("linearize_at_the_limit", "1 - h alpha v_c / 2: 0.9685"),  # 1 - 0.01 x 3.15.
        ("tune_alpha", "by AutoDiffXd"),
        ("poles_of_the_estimate", "measured late"),
    ],
)
def test_example_runs(example, capsys, name, says):
    example(name).main()
    assert says in capsys.readouterr().out


@pytest.mark.parametrize("smoothing", [0.2, 1.0])
@pytest.mark.parametrize(("alpha", "beta"), [(21.0, 21.0), (10.0, 1.0)])
def test_linearized_loop_is_as_worked_out_by_hand(example, alpha, beta, smoothing):
    lesson = example("linearize_at_the_limit")
    params = Blending(alpha, beta), Smoother(smoothing=smoothing)
    s, worked_out = lesson.by_hand(*params)
    found = lesson.linearized(*params, s)
    np.testing.assert_allclose(found, worked_out, rtol=0, atol=ROUNDING)


def test_linearized_loop_has_these_slopes(example):
    # With h = 0.01, alpha = 10, v_c = 0.3 and no filter: h alpha v_c / 2 = 0.015, which
    # l loses and x gains, and h / 2 of v_c to each; to x by 1 - 5e-5, which is kappa.
    lesson = example("linearize_at_the_limit")
    params = Blending(alpha=10.0), Smoother(smoothing=1.0)
    slopes = lesson.linearized(*params, lesson.by_hand(*params)[0])
    l, x, v_c = 5, 2, 7
    assert slopes[l, l] == pytest.approx(0.985, abs=ROUNDING)
    assert slopes[l, v_c] == pytest.approx(0.005, abs=ROUNDING)
    assert slopes[x, l] == pytest.approx(0.015, rel=1e-4)
    assert slopes[x, v_c] == pytest.approx(0.005, rel=1e-4)


def test_linearized_loop_agrees_with_drakes_taylor_approximation(example):
    """Without a filter: then there is one group of state, as Drake wants it."""
    lesson, made = example("linearize_at_the_limit"), example("blended_loop")
    unfiltered = Blending(), Smoother(smoothing=1.0)
    s, _ = lesson.by_hand(*unfiltered)
    found = lesson.linearized(*unfiltered, s)

    loop = made.make_blended_loop(Blending(), Unsmoothed(), s[5])
    context = loop.CreateDefaultContext()
    command = loop.GetInputPort("ee_command")
    command.FixValue(context, [lesson.V_C, 0.0, 0.0])
    workspace = loop.GetOutputPort("ee_cylindrical").get_index()

    def taylor():
        here = command.get_index(), workspace
        return FirstOrderTaylorApproximation(loop, context, *here)

    # In joint angles; C is the slope of l and psi in them, here and a step on.
    def chart(model):
        return np.block(
            [[np.eye(3), np.zeros((3, 2))], [np.zeros((2, 3)), model.C()[:2, 3:]]]
        )

    here = taylor()
    after = loop.EvalUniquePeriodicDiscreteUpdate(context).value().copy()
    context.SetDiscreteState(after)
    there = taylor()
    A = chart(there) @ here.A() @ np.linalg.inv(chart(here))
    B = chart(there) @ here.B()[:, :2]
    np.testing.assert_allclose(found[2:, 2:7], A, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(found[2:, 7:], B, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("alpha", [3.0, 12.0, 40.0])
def test_gradient_is_that_of_the_simulation(example, alpha):
    cost = example("tune_alpha").cost
    J = cost(AutoDiffXd(alpha, [1.0]))
    assert J.value() == pytest.approx(cost(alpha), rel=1e-12)
    step = 1e-3
    difference = (cost(alpha + step) - cost(alpha - step)) / (2 * step)
    # Off by J''' step^2 / 6, with J''' of about J / alpha^3.
    assert J.derivatives()[0] == pytest.approx(difference, rel=1e-6)


def worked_out_cost(lesson, alpha):
    """J of the motion in continuous time, as the docstring has it."""
    v = lesson.V_C
    first = lesson.START - lesson.L_MAX

    def time(y):  # (1 + exp(2 alpha y)) dy = v dt.
        growth = math.exp(2 * alpha * y) - math.exp(2 * alpha * first)
        return (y - first + growth / (2 * alpha)) / v

    low, high = 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if time(middle) < lesson.T else (low, middle)
    y = np.linspace(0.0, low, 2_001)
    squared = y**2 * (1 + np.exp(2 * alpha * y)) / v
    excess = np.sum((squared[1:] + squared[:-1]) / 2 * np.diff(y))

    def acceleration(y):  # 2 alpha v^3 times the integral of mu (1 - mu)^2.
        mu = 1 / (1 + math.exp(-2 * alpha * y))
        return 2 * alpha * v**3 * (mu**2 / 2 - 2 * mu**3 / 3 + mu**4 / 4)

    square = acceleration(low) - acceleration(first)
    return (excess / lesson.EXCESS**2 + square / lesson.ACCELERATION**2) / lesson.T


@pytest.mark.parametrize("alpha", [8.0, 12.0, 30.0])
def test_cost_tends_to_the_one_worked_out_by_hand(example, monkeypatch, alpha):
    lesson = example("tune_alpha")
    expected = worked_out_cost(lesson, alpha)

    def off(period):
        monkeypatch.setattr(lesson, "PERIOD", period)
        monkeypatch.setattr(example("blended_loop"), "PERIOD", period)
        return lesson.cost(alpha) / expected - 1

    coarse, fine = off(0.01), off(0.005)
    assert abs(coarse) < 0.02
    # Euler's error is in proportion to the step; what is left, to its square.
    assert 2 * fine - coarse == pytest.approx(0, abs=3e-4)


def test_tuned_alpha_is_the_best(example):
    lesson = example("tune_alpha")
    best, steps = lesson.tuned(5.0)
    costs = [J for J, _ in steps.values()]
    assert costs == sorted(costs, reverse=True)
    assert len(steps) <= 12
    assert steps[best][1] == pytest.approx(0, abs=1e-5)
    beside = lesson.cost(best - OPTIMAL), lesson.cost(best + OPTIMAL)
    assert lesson.cost(best) < min(beside)
    grid = np.arange(5.0, 30.0, 0.05)
    by_hand = grid[np.argmin([worked_out_cost(lesson, alpha) for alpha in grid])]
    # Within what the steps of 0.01 s make of it.
    assert best == pytest.approx(by_hand, rel=0.01)


def test_no_estimate_of_the_base_shakes_it(example):
    lesson = example("poles_of_the_estimate")
    for name, estimate in lesson.ESTIMATES.items():
        found = lesson.poles(estimate)
        assert np.abs(found).max() < 1.0, name
        # Those that turn are damped to a tenth within half a second.
        turning = found[np.abs(found.imag) > 1e-6]
        assert (np.abs(turning) ** 50 < 0.1).all(), name
