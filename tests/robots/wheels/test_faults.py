"""Faults of drive and sensors do what their parameters say."""

import math

import numpy as np
import pytest

from drake_mobman.parameters import ParameterError
from drake_mobman.robots.wheels import Wheels
from drake_mobman.robots.wheels.drive import Drive
from drake_mobman.robots.wheels.sensors import Noise, Sensors
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate

TRACK = 0.4044
"""Of the TIAGo base [m]."""

SPEED = 3e-4
"""[m/s], [rad/s]: by which a base with faults may miss what its geometry says."""


def speeds(robot, command, ticks):
    """Returns the base's velocity (ticks, 3) after a step of its command."""
    robot.command("base_command_smoothed", command)
    taken = []
    for _ in range(ticks):
        robot.advance()
        taken.append(robot.read("base_velocity"))
    return np.array(taken)


def test_a_delay_shifts_all_that_the_base_does(bench):
    prompt = speeds(bench(), [0.02, 0.05], 20)
    late = speeds(bench(Wheels(drive=Drive(delay=0.05))), [0.02, 0.05], 25)
    np.testing.assert_allclose(late[5:], prompt, atol=1e-5)
    assert np.abs(late[:5]).max() < 1e-5


def test_a_lag_is_of_first_order_and_of_its_bandwidth(bench):
    lagging = speeds(bench(Wheels(drive=Drive(bandwidth=5.0))), [0.02, 0.0], 10)
    time = 0.01 * np.arange(1, 11) - 0.004  # Two steps of the plant late.
    expected = 0.02 * (1 - np.exp(-2 * math.pi * 5.0 * time))
    np.testing.assert_allclose(lagging[:, 0], expected, atol=2e-4)


def test_a_large_left_wheel_drives_a_base_to_the_right(bench):
    robot = bench(Wheels(drive=Drive(left_radius=1.03)))
    robot.ramp(0.3, 0.0)
    v, _, omega = robot.read("base_velocity")
    assert v == pytest.approx(0.3 * 1.015, abs=SPEED)
    assert omega == pytest.approx(-0.3 * 0.03 / TRACK, abs=2 * SPEED)
    # The encoders do not know.
    assert robot.read("base_odometry") == pytest.approx((0.3, 0.0), abs=SPEED)


def test_a_wide_track_turns_a_base_by_less(bench):
    robot = bench(Wheels(drive=Drive(track=1.1)))
    robot.ramp(0.0, 0.5)
    assert robot.read("base_velocity")[2] == pytest.approx(0.5 / 1.1, abs=SPEED)
    assert robot.read("base_odometry")[1] == pytest.approx(0.5, abs=SPEED)


def test_encoders_count(bench):
    counts = 1000
    robot = bench(Wheels(sensors=Sensors(encoder_resolution=counts)))
    robot.ramp(0.1, 0.0, 0.1, 0.0)
    seen, true = [], []
    for _ in range(100):
        robot.advance()
        seen.append(robot.read("base_odometry")[0])
        true.append(robot.read("base_velocity")[0])
    # The rates are those of whole counts in a tick; the way is right to one count.
    count = 2 * math.pi * 0.0985 / counts
    whole = np.array(seen) * 0.01 / (count / 2)
    np.testing.assert_allclose(whole, np.round(whole), atol=1e-6)
    assert len({round(x) for x in whole}) > 1
    assert np.mean(seen) == pytest.approx(np.mean(true), abs=2 * count / 1.0)


def test_a_gyroscope_has_its_bias(bench):
    robot = bench(Wheels(sensors=Sensors(gyro_bias=0.01)))
    turn = speeds(robot, [0.05, 0.1], 20)[-1, 2]
    assert robot.read("base_gyro")[0] == pytest.approx(turn + 0.01, abs=1e-12)


def test_a_tracker_measures_what_was_its_latency_ago():
    # As logged, and read by other blocks, at the ticks.
    given = ["fidelity=wheels", "fidelity.sensors.measured_latency=0.02", "duration=2"]
    run = simulate(load_scenario("kwon_franka", given))
    measured, true = run["base_measured"], run["base_velocity"]
    assert np.abs(true).max() > 0.01
    np.testing.assert_array_equal(measured[2:], true[:-2])
    assert not measured[:2].any()


def test_noise_is_as_large_as_told_and_the_same_each_time():
    noise = Noise([0.01, 0.0], [0.1, 0.002], 7, 0.01)
    drawn = np.array([noise.drawn(k) for k in range(4000)])
    np.testing.assert_allclose(drawn.mean(axis=0), [0.01, 0.0], atol=0.005)
    np.testing.assert_allclose(drawn.std(axis=0), [0.1, 0.002], rtol=0.05)
    # White: one tick says nothing of the next.
    x = (drawn - drawn.mean(axis=0)) / drawn.std(axis=0)
    assert np.abs((x[1:] * x[:-1]).mean(axis=0)).max() < 0.06
    again = Noise([0.01, 0.0], [0.1, 0.002], 7, 0.01)
    np.testing.assert_array_equal(drawn[:50], [again.drawn(k) for k in range(50)])
    other = Noise([0.01, 0.0], [0.1, 0.002], 8, 0.01)
    assert np.abs(other.drawn(3) - drawn[3]).max() > 0.0


def test_noise_is_renewed_at_each_tick_and_held_between(bench):
    robot = bench(Wheels(sensors=Sensors(measured_noise=0.002)))
    seen = []
    for _ in range(5):
        robot.advance()
        seen.append(robot.read("base_measured") - robot.read("base_velocity"))
    seen = np.array(seen)
    assert len(np.unique(seen[:, 0])) == 5
    assert not seen[:, 2].any()  # The yaw rate has none.
    again = bench(Wheels(sensors=Sensors(measured_noise=0.002)))
    again.advance(5)
    np.testing.assert_array_equal(
        again.read("base_measured"), robot.read("base_measured")
    )


def test_a_torque_limit_bounds_what_the_wheels_can_do(bench):
    robot = bench()
    robot.command("base_command_smoothed", [1.0, 0.0])  # At once.
    robot.advance(20)
    v = robot.read("base_velocity")[0]
    mass = robot.plant.CalcTotalMass(robot.plant_context)
    # Some of the torque turns the wheels themselves.
    most = 2 * 6.0 / 0.0985 / mass * 0.2
    assert 0.8 * most < v < most


@pytest.mark.parametrize(
    ("wheels", "says"),
    [
        (Wheels(drive=Drive(delay=0.003)), "drive.delay: 0.003 is not valid; must be"),
        (
            Wheels(sensors=Sensors(measured_latency=0.015)),
            "sensors.measured_latency: 0.015 is not valid; must be whole control",
        ),
        (Wheels(drive=Drive(left_radius=0.1)), "drive.left_radius: 0.1 is not valid"),
        (Wheels(step=0.003), "step: 0.003 is not valid; must divide the control"),
        (Wheels(stiffness=math.inf), "stiffness: inf is not valid; must be a finite"),
    ],
)
def test_faults_that_are_none_are_refused(bench, wheels, says):
    with pytest.raises(ParameterError) as refusal:
        bench(wheels)
    assert says in str(refusal.value)
