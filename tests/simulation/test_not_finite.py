"""What is not finite anywhere in the loop is a stop, or ends the run and is named."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.autodiffutils import AutoDiffXd
from pydrake.symbolic import MakeVectorVariable
from pydrake.systems.framework import LeafSystem

from drake_mobman.base.smoother import CommandSmoother, Smoother
from drake_mobman.base.unsmoothed import CommandPassThrough
from drake_mobman.compiled import compiled
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate
from drake_mobman.teleop.guard import CommandGuard, Guard, GuardStatus

PERIOD = 0.01

BAD = [math.nan, -math.nan, math.inf, -math.inf]


# --- Blocks in the way of a command, in each scalar type -----------------------------


def as_floats(block, name, state, told):
    """What a block of floats, or one that is compiled, puts out."""
    context = block.CreateDefaultContext()
    if len(state):
        context.SetDiscreteState(state)
    block.get_input_port().FixValue(context, told)
    return block.GetOutputPort(name).Eval(context)


def as_compiled(block, name, state, told):
    made = compiled(block)
    assert type(made) is not type(block)
    context = made.CreateDefaultContext()
    for i in range(context.num_discrete_state_groups()):
        context.SetDiscreteState(i, state)
    made.get_input_port().FixValue(context, told)
    return made.GetOutputPort(name).Eval(context)


def as_expressions(block, name, state, told):
    symbolic = block.ToSymbolic()
    context = symbolic.CreateDefaultContext()
    u = MakeVectorVariable(len(told), "u")
    if len(state):
        context.SetDiscreteState([1 * x for x in map(type(u[0] + 0), state)])
    symbolic.get_input_port().FixValue(context, 1 * u)
    laws = symbolic.GetOutputPort(name).Eval(context)
    # Drake takes no NaN into an environment by hand; a Substitute does.
    return [e.Substitute(dict(zip(u, told, strict=True))).Evaluate() for e in laws]


def as_duals(block, name, state, told):
    dual = block.ToAutoDiffXd()
    context = dual.CreateDefaultContext()
    if len(state):
        context.SetDiscreteState(np.array([AutoDiffXd(x) for x in state]))
    dual.get_input_port().FixValue(context, np.array([AutoDiffXd(x) for x in told]))
    return [x.value() for x in dual.GetOutputPort(name).Eval(context)]


KINDS = [as_floats, as_compiled, as_expressions, as_duals]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("bad", BAD)
def test_smoother_brakes_at_once_where_a_command_is_not_finite(kind, bad):
    if kind is as_expressions and math.isnan(bad):
        pytest.skip("an Expression that is NaN cannot be made")
    block = CommandSmoother(Smoother(), PERIOD)
    # 1 m/s^2 and 2 rad/s^2 for 0.01 s.
    sent = kind(block, "base_command_smoothed", [0.4, -0.5], [bad, -0.5])
    assert sent == pytest.approx([0.39, -0.5], abs=1e-12)
    sent = kind(block, "base_command_smoothed", [0.4, -0.5], [0.4, bad])
    assert sent == pytest.approx([0.4, -0.48], abs=1e-12)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("bad", BAD)
def test_smoother_that_is_off_lets_nothing_pass_that_is_not_finite(kind, bad):
    if kind is as_expressions and math.isnan(bad):
        pytest.skip("an Expression that is NaN cannot be made")
    block = CommandPassThrough()
    assert list(kind(block, "base_command_smoothed", [], [bad, 9.0])) == [0.0, 9.0]


@pytest.mark.parametrize("kind", [as_floats, as_compiled, as_duals])
@pytest.mark.parametrize("bad", BAD)
def test_guard_brakes_and_says_why_compiled_too(kind, bad):
    block = CommandGuard(Guard(), PERIOD)
    told = [0.1, bad, 0.1]
    passed = kind(block, "ee_command", [0.4, 0.2, 0.0], told)
    assert passed == pytest.approx([0.38, 0.18, 0.0], abs=1e-12)
    status = kind(block, "guard_status", [0.4, 0.2, 0.0], told)
    assert list(status) == [GuardStatus.NOT_FINITE]


@given(
    told=st.lists(st.one_of(st.sampled_from(BAD), st.floats(-2, 2)), min_size=2),
    periods=st.integers(1, 40),
)
def test_smoother_and_its_compiled_twin_agree_on_whatever_they_are_told(told, periods):
    block = CommandSmoother(Smoother(), PERIOD)
    twin = compiled(block)
    contexts = block.CreateDefaultContext(), twin.CreateDefaultContext()
    for raw in told:
        for _ in range(periods):
            sent = []
            for system, context in zip((block, twin), contexts, strict=True):
                system.get_input_port().FixValue(context, [raw, -raw])
                sent.append(system.get_output_port().Eval(context).copy())
                after = system.EvalUniquePeriodicDiscreteUpdate(context)
                context.SetDiscreteState(after.value().copy())
            assert np.isfinite(sent).all()
            np.testing.assert_allclose(sent[0], sent[1], rtol=0, atol=1e-12)


# --- A whole run ---------------------------------------------------------------------


class Breaking(LeafSystem):
    """A decomposer that keeps still, and puts out `value` on a port for a time."""

    def __init__(self, port, value, start, end=math.inf):
        super().__init__()
        for name, size in (
            ("ee_command", 3),
            ("ee_cylindrical", 3),
            ("arm_position", 2),
            ("base_command_smoothed", 2),
        ):
            self.DeclareVectorInputPort(name, size)

        def calc(name, size):
            def put_out(context, output):
                wrong = name == port and start < context.get_time() < end
                output.SetFromVector(np.full(size, value if wrong else 0.0))

            return put_out

        for name, size in (
            ("base_command", 2),
            ("base_contribution", 2),
            ("arm_command", 3),
        ):
            self.DeclareVectorOutputPort(
                name, size, calc(name, size), prerequisites_of_calc={self.time_ticket()}
            )


@pytest.mark.parametrize(
    ("smoothed", "made"), [("smoother", "false"), ("unsmoothed", "true")]
)
@pytest.mark.parametrize("value", [math.inf, math.nan])
@pytest.mark.parametrize("port", ["base_command", "base_contribution", "arm_command"])
def test_run_with_a_signal_that_is_not_finite_dies_then_and_names_it(
    port, value, made, smoothed
):
    overrides = [f"smoother={smoothed}", f"compiled={made}", "duration=6"]
    scenario = load_scenario("kwon_1", [*overrides, "start.l=1"])
    run = simulate(scenario, decomposer=lambda: Breaking(port, value, 2.135))
    why = f"died at t = 2.14 s: {port} is not finite any more"
    # What a block has raised of it, if it did, is told after that.
    assert run.died.partition(";")[0] == why
    assert run.log["time"][-1] == pytest.approx(2.13)
    assert all(np.isfinite(x).all() for x in run.log.values())


def test_run_dies_of_a_signal_that_is_not_finite_for_a_single_tick():
    scenario = load_scenario("kwon_1", ["duration=1", "start.l=1"])
    block = Breaking("base_contribution", math.inf, 0.425, 0.435)
    run = simulate(scenario, decomposer=lambda: block)
    assert run.died == "died at t = 0.43 s: base_contribution is not finite any more"
    assert len(run.log["time"]) == 43
