"""The share that keeps the workspace: smoothstep instead of tanh."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_mobman.analysis.metrics import metrics
from drake_mobman.decomposers.blending import Blending
from drake_mobman.decomposers.share import blended_share, strict_share
from drake_mobman.parameters import ParameterError, checked
from drake_mobman.robot_model import WorkspaceLimits
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate

ROUNDING = 1e-12
PERIOD = 0.01
LIMITS = WorkspaceLimits()


def test_share_is_as_worked_out_by_hand():
    # Sharpness 15 has it rise from 1.4 to 1.6: half way up is 1/2, a quarter 5/32.
    for x, share in ((1.3, 0), (1.4, 0), (1.45, 5 / 32), (1.5, 0.5), (1.6, 1), (2, 1)):
        assert strict_share(0.1, x, 0.4, 1.6, 15.0) == pytest.approx(share)
    for x, share in ((0.7, 0), (0.6, 0), (0.55, 5 / 32), (0.5, 0.5), (0.4, 1), (0, 1)):
        assert strict_share(-0.1, x, 0.4, 1.6, 15.0) == pytest.approx(share)


@given(sharpness=st.floats(1.0, 100.0))
def test_it_is_as_steep_as_the_tanh_share_at_most(sharpness):
    def steepest(law):
        x = np.linspace(1.6 - 4 / sharpness, 1.6 + 4 / sharpness, 4001)
        return np.max(np.diff([law(1.0, y, 0.0, 1.6, sharpness) for y in x])) / (
            x[1] - x[0]
        )

    assert steepest(strict_share) == pytest.approx(steepest(blended_share), rel=1e-3)
    assert steepest(strict_share) == pytest.approx(sharpness / 2, rel=1e-3)


held = st.lists(st.tuples(st.floats(-0.4, 0.4), st.integers(1, 4000)), max_size=12)


@given(start=st.floats(0.0, 1.0), sharpness=st.floats(5.0, 200.0), commands=held)
def test_what_is_inside_the_limits_stays_inside_under_any_held_command(
    start, sharpness, commands
):
    low, high = LIMITS.l_min, LIMITS.l_max
    x = low + start * (high - low)
    for command, periods in commands:
        for _ in range(periods):
            before = x
            x += PERIOD * (1 - strict_share(command, x, low, high, sharpness)) * command
            if x == before:
                break  # At rest for as long as the command is held.
        assert low - ROUNDING <= x <= high + ROUNDING


def test_a_minute_of_operator_input_never_leaves_the_workspace():
    quick = "compiled=true"
    overrides = ["decomposer=!Blending {share: smoothstep}", quick]
    for name in ("kwon_arbitrary", "kwon_spatial"):
        run = simulate(load_scenario(name, overrides))
        excess = metrics(run)["workspace_excess_max"]
        assert max(excess.values()) < ROUNDING
        tanh = simulate(load_scenario(name, ["decomposer=blending", quick]))
        assert min(metrics(tanh)["workspace_excess_max"].values()) > 0.05


def test_the_tanh_share_creeps_by_the_logarithm():
    run = simulate(load_scenario("kwon_1", ["start.l=1.6"]))
    creep = math.log(1 + 2 * 21 * 0.35 * 14) / (2 * 21)
    end = run.log["ee_cylindrical"][-1, 0] - 1.6
    assert end == pytest.approx(creep, rel=0.01)
    strict = load_scenario("kwon_1", ["start.l=1.6", "decomposer.share=smoothstep"])
    assert simulate(strict).log["ee_cylindrical"][-1, 0] == pytest.approx(
        1.6, abs=1e-12
    )


def test_unknown_share_is_refused():
    with pytest.raises(ParameterError, match="must be one of tanh, smoothstep"):
        checked(Blending(share="step"))
