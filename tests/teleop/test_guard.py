"""The guard: no command that is not finite and in range gets past it."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import VectorLogSink

from drake_mobman.parameters import ParameterError
from drake_mobman.teleop.guard import CommandGuard, Guard, GuardStatus, braked

PERIOD = 0.01

BITE = 1e-15
"""What rounding leaves of a command that is braked in twenty steps to 0."""

GUARD = Guard(max_v_c=0.4, max_omega_c=0.5, max_v_z=0.2, stop_time=0.2)
LARGEST = np.array([0.4, 0.5, 0.2])

IN_RANGE = st.tuples(st.floats(-0.4, 0.4), st.floats(-0.5, 0.5), st.floats(-0.2, 0.2))
WRONG = st.one_of(
    st.sampled_from([math.nan, math.inf, -math.inf, 1e308, -1e308, 0.6, -0.6]),
    st.floats(min_value=0.51),
)
"""Of any component: not finite, huge, or a little over its range."""


@st.composite
def bad_commands(draw):
    """A command with one component wrong, or more."""
    command = list(draw(IN_RANGE))
    for i in draw(st.sets(st.integers(0, 2), min_size=1)):
        command[i] = draw(WRONG)
    return tuple(command)


HELD = st.lists(
    st.tuples(st.one_of(IN_RANGE, bad_commands()), st.integers(1, 30)),
    min_size=1,
    max_size=6,
)
"""Commands, and for how many periods each is held."""


def is_good(command):
    return bool(np.isfinite(command).all() and (np.abs(command) <= LARGEST).all())


@pytest.fixture(scope="module")
def passed(fed, step):
    """A function that returns what the guard passes of commands, and its status."""

    def outputs_over_time(commands, params=GUARD):
        block = CommandGuard(params, PERIOD)
        context = fed(block, ee_command=[0.0, 0.0, 0.0])
        out, why = [], []
        for command in commands:
            block.GetInputPort("ee_command").FixValue(context, np.array(command))
            out.append(block.GetOutputPort("ee_command").Eval(context))
            why.append(int(block.GetOutputPort("guard_status").Eval(context)[0]))
            step(block, context)
        return np.array(out), why

    return outputs_over_time


def over_time(held):
    return [command for command, periods in held for _ in range(periods)]


@given(held=HELD)
def test_what_passes_is_always_finite_and_in_range(passed, held):
    out, _ = passed(over_time(held))
    assert np.isfinite(out).all()
    assert (np.abs(out) <= LARGEST).all()


@given(held=HELD)
def test_a_good_command_passes_bit_for_bit(passed, held):
    commands = over_time(held)
    for command, out in zip(commands, passed(commands)[0], strict=True):
        if is_good(command):
            assert out.tobytes() == np.array(command).tobytes()


@given(held=HELD)
def test_status_says_why(passed, held):
    commands = over_time(held)
    for command, why in zip(commands, passed(commands)[1], strict=True):
        if not np.isfinite(command).all():
            assert why == GuardStatus.NOT_FINITE
        else:
            assert (why == GuardStatus.OK) == is_good(command)
            assert why in (GuardStatus.OK, GuardStatus.OVER_RANGE)


@given(held=HELD)
def test_a_bad_command_brakes_at_once_and_never_the_other_way(passed, held):
    commands = over_time(held)
    out, _ = passed(commands)
    brake = LARGEST * PERIOD / GUARD.stop_time
    before = np.zeros(3)
    for command, now in zip(commands, out, strict=True):
        if not is_good(command):
            # From the first bad command on, by the whole brake or down to 0: what
            # was passed before is never passed again, unless it was rest.
            slower = np.maximum(np.abs(before) - brake, 0.0)
            np.testing.assert_allclose(np.abs(now), slower, rtol=0, atol=BITE)
            assert (now * before >= 0).all()
        before = now


@given(held=HELD, bad=bad_commands())
def test_a_bad_command_held_ends_at_rest_within_the_stop_time(passed, held, bad):
    periods = round(GUARD.stop_time / PERIOD)
    out, _ = passed([*over_time(held), *[bad] * (periods + 1)])
    np.testing.assert_allclose(out[-2], 0.0, rtol=0, atol=BITE)
    assert (out[-1] == 0).all()


@given(bad=st.lists(bad_commands(), min_size=21, max_size=21))
def test_changing_bad_commands_end_at_rest_too(passed, bad):
    out, _ = passed([(0.4, -0.5, 0.2), *bad])
    assert (out[-1] == 0).all()


@given(held=HELD, good=IN_RANGE)
def test_it_recovers_with_the_next_good_command(passed, held, good):
    out, why = passed([*over_time(held), good])
    assert tuple(out[-1]) == good
    assert why[-1] == GuardStatus.OK


def test_brake_is_as_worked_out_by_hand(passed):
    # The largest command, 0.4, goes to rest in 0.2 s: by 0.02 each 0.01 s; 0.5 by
    # 0.025, 0.2 by 0.01. Half of each is at rest after half the time.
    out, why = passed([(0.4, -0.25, 0.05), *[(math.nan, 0.0, 0.0)] * 20, (9.0, 0, 0)])
    np.testing.assert_allclose(out[1], [0.38, -0.225, 0.04], atol=BITE)
    np.testing.assert_allclose(out[5], [0.30, -0.125, 0.0], atol=BITE)
    np.testing.assert_allclose(out[10], [0.20, 0.0, 0.0], atol=BITE)
    np.testing.assert_allclose(out[20], [0.0, 0.0, 0.0], atol=BITE)
    assert why == [0, *[GuardStatus.NOT_FINITE] * 20, GuardStatus.OVER_RANGE]


def test_a_command_bad_from_the_start_is_rest(passed):
    out, why = passed([(math.nan, math.nan, math.nan)] * 3)
    assert (out == 0).all()
    assert why == [GuardStatus.NOT_FINITE] * 3


def test_the_border_of_the_range_is_in_range(passed):
    for signs in itertools.product([1, -1], repeat=3):
        out, why = passed([LARGEST * signs])
        assert tuple(out[0]) == tuple(LARGEST * signs)
        assert why == [GuardStatus.OK]
    # Rounding is not over range, and does not get out of it either.
    rounded = (math.nextafter(0.4, 1.0), 0.0, 0.0)
    out, why = passed([rounded, (0.4 * (1 + 2e-9), 0.0, 0.0)])
    assert out[0].tolist() == [0.4, 0.0, 0.0]
    assert why == [GuardStatus.OK, GuardStatus.OVER_RANGE]


@pytest.mark.parametrize("stop_time", [0.0, 0.005, PERIOD])
def test_a_stop_time_within_a_period_stops_at_once(passed, stop_time):
    params = Guard(stop_time=stop_time)
    out, _ = passed([(0.4, 0.4, 0.4), (math.inf, 0.0, 0.0)], params)
    assert (out[1] == 0).all()


@given(command=IN_RANGE, period=st.floats(1e-4, 0.3))
def test_braking_never_overshoots_rest(command, period):
    now = np.array(braked(command, GUARD, period))
    assert (now * np.array(command) >= 0).all()
    assert (np.abs(now) <= np.abs(command)).all()


def test_in_a_simulation_it_brakes_by_the_periods_not_by_the_steps(fed):
    # Advanced in quarters of a period, with a NaN from the start of the tenth on.
    builder = DiagramBuilder()
    guard = builder.AddSystem(CommandGuard(GUARD, PERIOD))
    sink = builder.AddSystem(VectorLogSink(3, PERIOD))
    builder.Connect(guard.GetOutputPort("ee_command"), sink.get_input_port())
    builder.ExportInput(guard.get_input_port(), "ee_command")
    diagram = builder.Build()
    simulator = Simulator(diagram, fed(diagram, ee_command=[0.4, 0.0, 0.0]))
    simulator.Initialize()
    for k in range(1, 120):
        if k == 39:  # Between the periods at 0.09 s and at 0.10 s.
            nan = np.full(3, math.nan)
            diagram.get_input_port().FixValue(simulator.get_mutable_context(), nan)
        simulator.AdvanceTo(k * PERIOD / 4)
    v_c = sink.FindLog(simulator.get_context()).data()[0]
    expected = [0.4] * 10 + [0.4 - 0.02 * k for k in range(1, 20)]
    np.testing.assert_allclose(v_c[:29], expected, rtol=0, atol=BITE)


def test_two_contexts_do_not_disturb_each_other(fed, outputs, step):
    block = CommandGuard(GUARD, PERIOD)
    moving = fed(block, ee_command=[0.4, 0.0, 0.0])
    resting = fed(block, ee_command=[0.0, 0.0, 0.0])
    for context in (moving, resting):
        step(block, context)
        block.get_input_port().FixValue(context, [math.nan, 0.0, 0.0])
    assert outputs(block, moving)["ee_command"][0] == pytest.approx(0.38, abs=BITE)
    assert outputs(block, resting)["ee_command"][0] == 0


def test_ports_are_those_of_the_contract():
    block = CommandGuard(Guard(), PERIOD)
    assert block.num_input_ports() == 1
    assert block.GetInputPort("ee_command").size() == 3
    assert block.num_output_ports() == 2
    assert block.GetOutputPort("ee_command").size() == 3
    assert block.GetOutputPort("guard_status").size() == 1


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("max_v_c", 0.0),
        ("max_omega_c", -0.4),
        ("max_v_z", math.inf),
        ("stop_time", -0.1),
        ("stop_time", math.nan),
    ],
)
def test_parameters_that_guard_nothing_are_refused(key, value):
    with pytest.raises(ParameterError, match=f"^{key}: "):
        CommandGuard(Guard(**{key: value}), PERIOD)


def test_defaults_are_those_of_table_1():
    assert Guard().largest == (0.4, 0.4, 0.4)
