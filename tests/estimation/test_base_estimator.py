"""The estimator against drives worked out apart, and against robots on wheels."""

import math

import numpy as np
import pytest

from drake_mobman.analysis.metrics import metrics
from drake_mobman.estimation.base_estimator import BaseEstimator
from drake_mobman.estimation.gyro import Gyro
from drake_mobman.estimation.measured import Measured
from drake_mobman.estimation.odometry import Odometry
from drake_mobman.estimation.sent import Sent
from drake_mobman.parameters import ParameterError
from drake_mobman.scenario import ScenarioError, load_scenario
from drake_mobman.simulation.simulate import simulate
from drake_mobman.teleop.gate import (
    Arming,
    Gate,
    GateState,
    GateStatus,
    next_state,
)
from drake_mobman.teleop.guard import Guard, GuardStatus
from drake_mobman.teleop.live import NOBODY

PERIOD = 0.01
FINE = 1000
"""Steps of a drive that is integrated apart, in a period."""


class Drive:
    """A drive of delay and lag, stepped finely; and a floor on which it slips."""

    def __init__(self, delay=0, bandwidth=0.0, slip=(0.0, 0.0, 0.0)):
        self.queue = [np.zeros(2)] * delay
        self.rate = 2 * math.pi * bandwidth
        self.slip = np.array(slip)
        self.now = np.zeros(2)

    def measured(self):
        """Returns v, v_y, omega now."""
        return np.array([self.now[0], 0.0, self.now[1]]) + self.slip

    def driven(self, sent):
        """Moves on for a period; returns the mean v, v_y, omega over it."""
        self.queue.append(np.array(sent))
        told = self.queue.pop(0)
        if not self.rate:
            self.now = told
            mean = told
        else:
            left = np.exp(-self.rate * PERIOD * np.arange(FINE + 1) / FINE)[:, None]
            course = told + (self.now - told) * left
            mean, self.now = np.trapezoid(course, axis=0) / FINE, course[-1]
        return np.array([mean[0], 0.0, mean[1]]) + self.slip


def estimates(params, drive, commands, late=0):
    """Yields the estimate and the base's true mean velocity at each tick."""
    block = BaseEstimator(params, PERIOD)
    context = block.CreateDefaultContext()
    seen = [drive.measured()] * late
    for sent in commands:
        seen.append(drive.measured())
        m = seen.pop(0)
        values = {"base_odometry": m[[0, 2]], "base_gyro": m[2:], "base_measured": m}
        block.GetInputPort("base_command_smoothed").FixValue(context, sent)
        for name in params.measures:
            block.GetInputPort(name).FixValue(context, values[name])
        yield block.GetOutputPort("base_estimate").Eval(context), drive.driven(sent)
        after = block.EvalUniquePeriodicDiscreteUpdate(context).value()
        context.SetDiscreteState(after)


def commands(seed, ticks=200):
    """Returns random commands (ticks, 2), each held for some ticks."""
    rng = np.random.default_rng(seed)
    held = rng.uniform(-0.5, 0.5, (ticks, 2))
    return np.repeat(held, rng.integers(1, 12, ticks), axis=0)[:ticks]


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("delay", [0, 1, 5])
@pytest.mark.parametrize("bandwidth", [0.0, 2.0, 5.0])
def test_known_drive_is_told_without_a_sensor(seed, delay, bandwidth):
    params = Sent(delay=delay * PERIOD, bandwidth=bandwidth)
    for told, true in estimates(params, Drive(delay, bandwidth), commands(seed)):
        np.testing.assert_allclose(told, true, rtol=0, atol=1e-6)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("late", [0, 1, 3])
@pytest.mark.parametrize(("delay", "bandwidth"), [(0, 0.0), (5, 0.0), (2, 5.0)])
def test_slip_that_no_model_knows_is_told_by_what_is_measured(
    seed, late, delay, bandwidth
):
    slip = np.random.default_rng(seed).uniform(-0.05, 0.05, 3)
    params = Measured(delay=delay * PERIOD, bandwidth=bandwidth, latency=late * PERIOD)
    drive = Drive(delay, bandwidth, slip)
    pairs = list(estimates(params, drive, commands(seed), late))
    for told, true in pairs[late:]:
        np.testing.assert_allclose(told, true, rtol=0, atol=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_each_sensor_tells_what_it_sees(seed):
    slip = np.array([0.03, 0.02, -0.1])
    for kind, seen in ((Odometry, [1, 0, 1]), (Gyro, [1, 0, 1]), (Measured, [1, 1, 1])):
        for told, true in estimates(kind(), Drive(slip=slip), commands(seed)):
            np.testing.assert_allclose(told, true * seen, rtol=0, atol=1e-12)


def test_without_model_and_sensor_it_is_what_is_sent():
    block = Sent().build(PERIOD)
    context = block.CreateDefaultContext()
    block.GetInputPort("base_command_smoothed").FixValue(context, [0.3, -0.7])
    told = block.GetOutputPort("base_estimate").Eval(context)
    assert told.tolist() == [0.3, 0.0, -0.7]


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("place", range(3))
def test_measurement_that_is_not_finite_is_left_out_and_noticed(bad, place):
    params = Measured(patience=0.03)
    block = BaseEstimator(params, PERIOD)
    context = block.CreateDefaultContext()
    measured = np.array([0.2, 0.0, 0.1])
    measured[place] = bad
    block.GetInputPort("base_measured").FixValue(context, measured)
    block.GetInputPort("base_command_smoothed").FixValue(context, [0.2, 0.1])
    astray = []
    for _ in range(6):
        told = block.GetOutputPort("base_estimate").Eval(context)
        assert told.tolist() == [0.2, 0.0, 0.1]
        astray.append(block.GetOutputPort("base_astray").Eval(context)[0])
        after = block.EvalUniquePeriodicDiscreteUpdate(context).value()
        context.SetDiscreteState(after)
    assert astray == [0.0] * 4 + [1.0] * 2


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("estimate=measured", "needs base_measured, which fidelity !Servo"),
        (
            "estimate=!Sent {delay: 0.015}",
            "estimate.delay: 0.015 is not valid",
        ),
        ("estimate=!Gyro {latency: 0.015}", "estimate.latency: 0.015"),
        ("estimate=!Odometry {patience: -1}", "estimate.patience: -1"),
        ("estimate=!Sent {bandwidth: .nan}", "estimate.bandwidth: nan"),
    ],
)
def test_what_cannot_be_estimated_is_refused_in_one_line(override, message):
    with pytest.raises((ScenarioError, ParameterError)) as refused:
        load_scenario("kwon_franka", [override])
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


def run_of(*overrides):
    run = simulate(
        load_scenario("kwon_franka", ["fidelity=wheels", "duration=4", *overrides])
    )
    assert run.died == ""
    return run


@pytest.mark.parametrize(
    ("fault", "estimate"),
    [
        ("fidelity.drive.left_radius=1.03", "measured"),
        ("fidelity.drive.delay=0.05", "odometry"),
        ("fidelity.drive.delay=0.05", "!Sent {delay: 0.05}"),
        ("fidelity.drive.bandwidth=5", "gyro"),
        ("fidelity.drive.bandwidth=5", "!Sent {bandwidth: 5}"),
    ],
)
def test_on_wheels_the_estimate_makes_up_for_a_fault(fault, estimate):
    by_sent, by_estimate = (
        metrics(run_of(fault, f"estimate={one}")) for one in ("sent", estimate)
    )
    assert by_estimate["ee_error_rms"] < 2e-3
    assert by_estimate["ee_error_rms"] < 0.3 * by_sent["ee_error_rms"]
    assert by_estimate["base_jerk_rms"] < 1.5 * by_sent["base_jerk_rms"]


def test_base_that_does_not_move_as_sent_stops_the_robot_and_the_guard_says_why():
    # On ice the wheels turn on the spot.
    run = run_of("fidelity.floor.friction=0.001", "estimate=measured")
    status = run.log["guard_status"].ravel()
    stopped = status == GuardStatus.ASTRAY
    assert stopped[-1]
    assert not stopped[0]
    first = int(np.argmax(stopped))
    assert stopped[first:].all()
    # Half a second of patience, from when the two parted.
    apart = run.log["base_command_smoothed"][:, 0] - run.log["base_velocity"][:, 0]
    assert first - int(np.argmax(apart > 0.15)) == pytest.approx(51, abs=3)
    assert not run.log["ee_command"][first + 21 :].any()
    assert metrics(run)["commands_refused"] > 0


def test_base_astray_latches_the_gate():
    held = NOBODY._replace(age=0.0, dead_man=1.0, v_c=0.1)
    armed = GateState(Arming.ARMED, GateStatus.OK)
    after = next_state(armed, held, Gate(), Guard(), astray=1.0)
    assert after == GateState(Arming.LATCHED, GateStatus.ASTRAY)
    # The base moves again as it is sent; the reason stays until the gate is armed.
    assert next_state(after, held, Gate(), Guard()) == after
