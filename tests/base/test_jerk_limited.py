"""The base command with limits of speed, acceleration and jerk."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_mobman.base.jerk_limited import JerkLimited, JerkLimiter
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate

PERIOD = 0.01

ROUNDING = 1e-9
"""Relative; of differences of a command, twice over a period of 0.01 s."""

held_for = st.tuples(st.floats(-2.0, 2.0), st.integers(1, 120))


def sent(params, segments):
    """Returns v_b as it is sent (N,), of commands held for some periods each."""
    block = JerkLimiter(params, PERIOD)
    context = block.CreateDefaultContext()
    found = []
    for v, periods in segments:
        block.get_input_port().FixValue(context, [v, 0.0])
        for _ in range(periods):
            found.append(block.get_output_port().Eval(context)[0])
            state = block.EvalUniquePeriodicDiscreteUpdate(context)
            context.SetDiscreteState(state.get_vector().CopyToVector())
    return np.array(found)


@given(
    segments=st.lists(held_for, min_size=1, max_size=5),
    speed=st.floats(0.1, 2.0),
    acceleration=st.floats(0.2, 10.0),
    jerk=st.floats(1.0, 500.0),
)
def test_speed_acceleration_and_jerk_stay_within_their_limits(
    segments, speed, acceleration, jerk
):
    params = JerkLimited(max_speed=speed, max_acceleration=acceleration, max_jerk=jerk)
    command = np.concatenate([[0.0, 0.0], sent(params, segments)])
    slope = np.diff(command) / PERIOD
    assert np.abs(command).max() <= speed * (1 + ROUNDING)
    assert np.abs(slope).max() <= acceleration * (1 + ROUNDING) + ROUNDING
    assert np.abs(np.diff(slope)).max() / PERIOD <= jerk * (1 + 1e-6) + 1e-6


@given(v=st.floats(-0.5, 0.5), jerk=st.floats(1.0, 500.0))
def test_a_held_command_is_reached_without_overshoot(v, jerk):
    command = sent(JerkLimited(max_jerk=jerk), [(v, 400)])
    # 0.5 m/s at 1 m/s^2, and the time that jerk takes to get there and back.
    assert command[-1] == pytest.approx(v, abs=1e-6)
    assert (np.abs(command) <= abs(v) + ROUNDING).all()
    assert (np.diff(np.abs(command)) >= -ROUNDING).all()


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_a_stop(bad):
    params = JerkLimited()
    stopped = sent(params, [(0.4, 100), (bad, 200)])
    assert (stopped == sent(params, [(0.4, 100), (0.0, 200)])).all()
    assert stopped[-1] == pytest.approx(0.0, abs=1e-6)


def test_a_jump_takes_as_long_as_the_limits_say():
    # 0.5 m/s: up to 1 m/s^2 at 10 m/s^3 and down again takes 0.1 s twice, 0.05 m/s
    # each; 0.4 s at 1 m/s^2 make up the other 0.4 m/s. In whole periods, some more.
    command = sent(JerkLimited(), [(0.5, 200)])
    there = np.argmax(command >= 0.5 - 1e-3) * PERIOD
    assert 0.6 - 0.05 <= there <= 0.6 + 0.05


def test_it_runs_in_a_scenario_and_keeps_jerk_low():
    scenario = load_scenario(
        "kwon_arbitrary", ["smoother=jerklimited", "duration=20", "decomposer=exact"]
    )
    run = simulate(scenario)
    assert not run.died
    v = run.log["base_command_smoothed"][:, 0]
    jerk = np.diff(v, 2, prepend=[0.0, 0.0]) / PERIOD**2
    assert np.abs(jerk).max() <= 10.0 * (1 + 1e-6)
