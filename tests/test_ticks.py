"""Time is counted in ticks: rounding of sums and multiples moves nothing by one."""

import dataclasses as dc
import itertools
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.symbolic import Variable
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import (
    SymbolicVectorSystem,
    VectorLogSink,
    ZeroOrderHold,
)

from drake_mobman.base.smoother import smoothed
from drake_mobman.decomposers.optimization import braking_factor
from drake_mobman.guidance.guiding_hand import GraspForce, Hand, Release
from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import RobotSetup
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.servo import Servo
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate
from drake_mobman.teleop.choice import Handover, next_handover
from drake_mobman.teleop.guard import CommandGuard, Guard, GuardStatus, braked
from drake_mobman.teleop.scripted import Held, Script, ScriptedSource, Smooth
from drake_mobman.teleop.stop_ramp import next_share
from drake_mobman.ticks import aligned, at_tick, last_tick, whole_steps

MILLIS = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 15, 16, 20, 25, 30, 40, 50, 70, 90, 100]
"""Periods [ms]; what is worked out from these by hand is whole."""


def sampled(system, port, period, ticks):
    """Returns what a port puts out at ticks 0, 1, ... (N, size), by Drake's clock."""
    builder = DiagramBuilder()
    builder.AddSystem(system)
    sink = builder.AddSystem(VectorLogSink(port.size(), period))
    builder.Connect(port, sink.get_input_port())
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo((ticks - 0.5) * period)
    return sink.FindLog(simulator.get_context()).data().T


# --- The count ------------------------------------------------------------------------


@pytest.mark.parametrize("millis", MILLIS)
def test_a_tick_is_found_by_any_decimal_that_means_it(millis):
    for k in [*range(1, 3000), 10**6 + 7, 2 * 10**8 + 1]:
        time = float(Fraction(k * millis, 1000))
        assert at_tick(time, millis / 1000) == k * (millis / 1000)
        assert last_tick(time, millis / 1000) == k


def test_a_time_between_ticks_stays_there():
    assert at_tick(0.705, 0.01) == 0.705
    assert last_tick(0.705, 0.01) == 70
    assert last_tick(0.7099, 0.01) == 70


# --- Scripts --------------------------------------------------------------------------


@given(
    lengths=st.lists(st.integers(1, 40), min_size=1, max_size=8),
    millis=st.sampled_from(MILLIS),
    repeat=st.integers(1, 5),
)
def test_held_commands_last_as_many_ticks_as_their_durations_say(
    lengths, millis, repeat
):
    period = millis / 1000
    segments = [
        Held(float(Fraction(n * millis, 1000)), v_c=1 + i)
        for i, n in enumerate(lengths)
    ]
    source = ScriptedSource(Script(segments, repeat), period)
    expected = [1 + i for i, n in enumerate(lengths) for _ in range(n)] * repeat
    out = sampled(source, source.get_output_port(), period, len(expected) + 2)
    assert out[:, 0].tolist() == [*expected, 0.0, 0.0]


def test_a_tenth_and_two_tenths_of_a_second_are_30_ticks():
    segments = "source.segments=[!Held {duration: 0.1, v_c: 0.1}, !Held {duration: 0.2"
    script = segments + ", v_c: 0.2}]"
    log = simulate(load_scenario("kwon_1", [script, "duration=1", "start.l=1"])).log
    assert log["ee_command"][:, 0].tolist() == [0.1] * 10 + [0.2] * 20 + [0.0] * 71


@pytest.mark.parametrize("limit", [0.3, 0.35, 0.4])
def test_smooth_commands_up_to_the_very_limit_are_never_refused(limit):
    guard = Guard(limit, limit, limit)
    tenths = [n / 10 for n in range(1, 41)]
    for first, last in itertools.product(tenths[::3], tenths):
        script = Script([Held(first), Smooth(last, limit, -limit, limit), Held(0.1)])
        source = ScriptedSource(script, 0.01)
        block = CommandGuard(guard, 0.01)
        context, told = block.CreateDefaultContext(), source.CreateDefaultContext()
        end = round(100 * (first + last))
        for k in range(end - 3, end + 1):
            told.SetTime(k * 0.01)
            block.get_input_port().FixValue(
                context, source.get_output_port().Eval(told)
            )
            status = block.GetOutputPort("guard_status").Eval(context)[0]
            assert status == GuardStatus.OK, (first, last, k)
            passed = block.GetOutputPort("ee_command").Eval(context)
            assert np.abs(passed).max() <= limit


# --- How long a run is ----------------------------------------------------------------


@pytest.mark.parametrize("duration", [0.1, 0.3, 0.6, 0.7, 1.1, 1.4, 2.3, 0.29, 0.57])
def test_run_ends_with_the_sample_at_its_duration(duration):
    overrides = [f"duration={duration}", "start.l=1"]
    log = simulate(load_scenario("kwon_1", overrides)).log
    assert len(log["time"]) == round(100 * duration) + 1
    assert log["time"][-1] == pytest.approx(duration)


def test_run_of_a_single_period_is_long_enough_whatever_rounding_makes_of_it():
    assert 0.15 < 3 * 0.05
    overrides = ["duration=0.15", f"period={3 * 0.05}", "start.l=1"]
    log = simulate(load_scenario("kwon_1", overrides)).log
    assert len(log["time"]) == 2


def test_every_duration_of_one_decimal_is_a_whole_number_of_ticks():
    for tenths in range(1, 601):
        assert last_tick(tenths / 10, 0.01) == 10 * tenths
        assert at_tick(tenths / 10, 0.01) == 10 * tenths * 0.01


# --- Two clocks -----------------------------------------------------------------------


STEPS = [*range(1, 31), 33, 49, 50, 64, 77, 99, 100, 125, 250, 333, 1000]
PAIRS = [(millis / 1000, count) for millis in MILLIS for count in STEPS]


@pytest.mark.parametrize("millis", MILLIS)
def test_period_and_step_are_multiples_to_the_last_bit(millis):
    for count in STEPS:
        period, step = aligned(millis / 1000, millis / 1000 / count)
        assert Fraction(period) == count * Fraction(step)
        assert abs(period / (millis / 1000) - 1) < 1e-12
        assert aligned(period, step) == (period, step)
        assert whole_steps(period, step) == count


def test_pairs_that_are_exact_already_stay_as_they_are():
    for pair in [(0.01, 0.002), (0.01, 0.001), (0.01, 0.01), (0.02, 0.002)]:
        assert aligned(*pair) == pair


def steps_between_ticks(period, step, ticks):
    """Returns how many steps Drake takes between two ticks, for each tick."""
    count = Variable("count")
    builder = DiagramBuilder()
    counter = builder.AddSystem(
        SymbolicVectorSystem(
            state=[count], dynamics=[count + 1], output=[count], time_period=step
        )
    )
    hold = builder.AddSystem(ZeroOrderHold(period, 1))
    sink = builder.AddSystem(VectorLogSink(1, period))
    builder.Connect(counter.get_output_port(), hold.get_input_port())
    builder.Connect(hold.get_output_port(), sink.get_input_port())
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo((ticks + 0.5) * period)
    return np.diff(sink.FindLog(simulator.get_context()).data()[0][1:])


@pytest.mark.parametrize(
    ("millis", "count"),
    [
        (50, 25),
        (50, 7),
        (10, 3),
        (10, 7),
        (30, 10),
        (70, 11),
        (90, 9),
        (16, 13),
        (3, 3),
    ],
)
def test_the_simulator_takes_as_many_steps_between_any_two_ticks(millis, count):
    period, step = aligned(millis / 1000, millis / 1000 / count)
    assert set(steps_between_ticks(period, step, 2000)) == {count}


class Straight(LeafSystem):
    """A decomposer that drives the base straight on, and keeps the arm still."""

    def __init__(self):
        super().__init__()
        self.DeclareVectorInputPort("ee_command", 3)
        for name, value in (
            ("base_command", [0.2, 0.0]),
            ("base_contribution", [0.2, 0.0]),
            ("arm_command", [0.0] * 3),
        ):
            self.DeclareVectorOutputPort(
                name,
                len(value),
                lambda _, output, value=value: output.SetFromVector(value),
                prerequisites_of_calc={self.nothing_ticket()},
            )


@pytest.mark.parametrize(
    ("period", "step"), [(0.05, 0.002), (0.05, 0.005), (0.03, 0.003), (0.07, 0.01)]
)
def test_base_goes_as_far_in_each_period_at_any_period_and_step(period, step):
    overrides = [f"fidelity=!Servo {{step: {step}}}", f"period={period}"]
    scenario = load_scenario("kwon_1", [*overrides, "duration=4", "start.l=1"])
    run = simulate(scenario, decomposer=Straight)
    assert run.died == ""
    way = np.diff(run.log["base_pose"][:, 0])[2:] / period
    np.testing.assert_allclose(way, 0.2, rtol=0, atol=1e-5)


def test_servo_robot_refuses_periods_that_would_drift_from_its_steps():
    with pytest.raises(ParameterError, match=r"^step: .*, see `aligned`"):
        Servo().build(RobotSetup.of(Planar(), 0.05), [0.0] * 5)
    period, step = aligned(0.05, 0.002)
    Servo(step=step).build(RobotSetup.of(Planar(), period), [0.0] * 5)


# --- Whatever takes a time ------------------------------------------------------------


@pytest.mark.parametrize("millis", MILLIS)
def test_hand_lets_go_and_takes_hold_at_the_very_ticks(millis):
    period = millis / 1000
    for k, n in [(1, 2), (3, 4), (7, 3), (9, 10), (29, 1), (35, 6), (57, 13)]:
        start, end = (float(Fraction(i * millis, 1000)) for i in (k, k + n))
        hand = dc.replace(Hand(), releases=[Release(start, end)])
        pull = GraspForce(hand, period)
        context_of = Simulator(pull)
        context = context_of.get_mutable_context()
        away = {"hand_position": [0.01, 0.0, 0.0]}
        for name in ("tool_position", "tool_velocity", "hand_position"):
            pull.GetInputPort(name).FixValue(context, away.get(name, [0.0] * 3))
        pull.GetInputPort("hand_velocity").FixValue(context, [0.0] * 3)
        held = []
        for tick in range(k + n + 3):
            context_of.AdvanceTo((tick + 0.5) * period)
            held.append(bool(pull.get_output_port().Eval(context)[0]))
        assert held == [True] * k + [False] * n + [True] * 3


def ticks_to_rest(value, after):
    """Returns in how many ticks a value comes to 0."""
    count = 0
    while value:
        value = after(value)
        count += 1
        assert count < 10_000
    return count


STOPS = {
    "guard": lambda c, time, h: braked([c, 0, 0], Guard(1, 1, 1, time), h)[0],
    "stop ramp": lambda share, time, h: next_share(
        share, False, Guard(stop_time=time), h
    ),
    "optimiser": lambda v, time, h: v * braking_factor([v], [1.0], h / time),
    "smoother": lambda v, time, h: smoothed(v, 0.0, 0.2, h / time, 1.0),
    "transition": lambda rest, time, h: (
        1 - next_handover(Handover(0, 1, 1 - rest), 1, 2, h / time).weight
    ),
}
"""What takes 1 to 0 in a time: by value, time and period."""


@pytest.mark.parametrize("stop", STOPS)
@pytest.mark.parametrize("millis", [1, 3, 7, 10, 30, 70])
def test_whatever_stops_in_a_time_takes_that_many_ticks(millis, stop):
    for n in [*range(1, 60), 100, 333]:
        value, ticks = 1.0, 0
        while value and ticks < 2 * n:
            value = STOPS[stop](value, float(Fraction(n * millis, 1000)), millis / 1000)
            ticks += 1
        assert ticks == n
