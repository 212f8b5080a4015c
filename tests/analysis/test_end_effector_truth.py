"""What is measured of the hand: by the robot's plant, whatever laws and sensors say."""

import dataclasses as dc
import functools
import math
import time

import numpy as np
import pytest

from drake_mobman import signals
from drake_mobman.analysis.metrics import metrics
from drake_mobman.analysis.motion import ee_motion
from drake_mobman.console.mailbox import OperatorInput
from drake_mobman.console.session import LiveSession
from drake_mobman.console.tracking_error import tracking_error
from drake_mobman.decomposers.field import build_decomposer
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.end_effector import ee_states
from drake_mobman.robots.franka_tiago import POSTURE, FrankaTiago
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.spatial import Spatial
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate

SAME = 1e-12
"""Two computations of one point: a product of a dozen rotations [m]."""

SLOPE = 1e-8
"""Of central differences: a step of 1e-5 s, squared, times jerks of up to 1e2 m/s^3;
and rounding over the step [m/s]."""

ROBOTS = {
    "planar": Planar(shoulder_ahead=0.1, shoulder_aside=-0.2),
    "spatial": Spatial(shoulder_aside=0.3),
    "franka_tiago": FrankaTiago(mount_aside=0.2, mount_yaw=2.0),
}
HAND_METRICS = ("ee_error_rms", "ee_error_max", "ee_drift_max", "workspace_excess_max")


@functools.cache
def run_of(name, *overrides):
    run = simulate(load_scenario(name, overrides))
    assert run.died == ""
    return run


def random_states(robot):
    """Returns positions and rates (50, 3 + n) of base and arm."""
    n = robot.arm().num_joints
    rng = np.random.default_rng(0)
    q = rng.uniform(-1.0, 1.0, (50, 3 + n))
    if isinstance(robot, FrankaTiago):
        q[:, 3:] = POSTURE + 0.5 * q[:, 3:]
    return q, rng.uniform(-1.0, 1.0, q.shape)


@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
def test_hand_is_on_the_arm_and_the_arm_on_the_base(robot):
    q, v = random_states(robot)
    arm, states = robot.arm(), ee_states(RobotModel(robot), q, v)
    for k, (x, y, theta) in enumerate(q[:, :3]):
        d, e, _ = arm.p_BS
        c, s = math.cos(theta), math.sin(theta)
        shoulder = x + c * d - s * e, y + s * d + c * e
        np.testing.assert_allclose(states.p_WS[k, :2], shoulder, rtol=0, atol=SAME)
        if not isinstance(robot, Spatial):  # Whose closed form is of a level hand.
            l, psi, _ = arm.ee_cylindrical(q[k, 3:])
            out = l * np.array([math.cos(theta + psi), math.sin(theta + psi)])
            np.testing.assert_allclose(states.p_SE_W[k, :2], out, rtol=0, atol=SAME)


@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
def test_velocity_is_how_the_position_changes(robot):
    (q, v), h = random_states(robot), 1e-5
    model = RobotModel(robot)
    after, before = (ee_states(model, q + t * v).p_WE for t in (h, -h))
    found = ee_states(model, q, v).v_WE
    np.testing.assert_allclose(found, (after - before) / (2 * h), rtol=0, atol=SLOPE)


@pytest.mark.parametrize("name", ["kwon_arbitrary", "kwon_spatial", "kwon_franka"])
def test_numbers_of_the_hand_do_not_hang_on_the_sensor(name):
    run = run_of(name, "duration=6")
    lies = run.log[signals.EE_CYLINDRICAL] * [0.5, 0.9, 0.0] + [0.3, 0.4, 0.2]
    misled = dc.replace(run, log=run.log | {signals.EE_CYLINDRICAL: lies})
    found, expected = metrics(misled), metrics(run)
    assert [found[key] for key in HAND_METRICS] == [
        expected[key] for key in HAND_METRICS
    ]


@pytest.mark.parametrize("fidelity", ["!Kinematic {}", "!Servo {}"])
def test_a_law_that_takes_the_arm_for_another_is_found_out(fidelity):
    """It thinks the shoulder 0.2 m nearer to the middle than it is."""
    scenario = load_scenario(
        "kwon_arbitrary", ["decomposer=exact", "duration=9", f"fidelity={fidelity}"]
    )
    scenario = dc.replace(scenario, robot=Planar(shoulder_aside=0.2))
    straight = dc.replace(scenario, robot=Planar())
    right = metrics(simulate(scenario))
    wrong = metrics(
        simulate(
            scenario,
            decomposer=lambda: build_decomposer(straight.decomposer, straight.setup()),
        )
    )
    assert wrong["ee_error_max"] > 0.02
    assert right["ee_error_max"] < wrong["ee_error_max"] / 10
    assert right["ee_drift_max"] < wrong["ee_drift_max"] / 3


@pytest.mark.parametrize("name", ["kwon_1", "kwon_arbitrary"])
def test_reach_angle_and_height_go_on_as_the_joints_do(name):
    """From l = 0 on, too, where no position tells a direction."""
    run = run_of(name, "duration=6")
    motion = ee_motion(run)
    l, psi, _ = run.log[signals.EE_CYLINDRICAL].T
    np.testing.assert_allclose(motion.reach, l, rtol=0, atol=1e-9)
    beside = l > 1e-3
    np.testing.assert_allclose(motion.psi[beside], psi[beside], rtol=0, atol=1e-9)
    assert np.abs(np.diff(motion.psi)).max() < 0.02
    np.testing.assert_allclose(motion.rise, 0.0, atol=1e-9)


def test_psi_past_half_a_turn_is_measured_as_such():
    held = "source.segments=[!Held {duration: 5, omega_c: 0.4}]"
    wide = "workspace={psi_min: 2.0, psi_max: 3.8}"
    run = run_of("kwon_arbitrary", "start.psi=2.9", "duration=4", wide, held)
    motion = ee_motion(run)
    assert motion.psi.max() > math.pi + 0.5
    np.testing.assert_allclose(
        motion.psi, run.log[signals.EE_CYLINDRICAL][:, 1], rtol=0, atol=1e-9
    )
    assert metrics(run)["workspace_excess_max"]["psi"] < 0.1


# The console.


@pytest.mark.parametrize("name", ["kwon_arbitrary", "kwon_franka"])
def test_live_error_is_the_metrics_own(name):
    run = run_of(name, "duration=6")
    errors = np.linalg.norm(ee_motion(run).error, axis=1)
    model = RobotModel(run.scenario.robot)
    for k in (1, 150, 300, 599):
        last = {signal: x[k - 1 : k + 1] for signal, x in run.log.items()}
        found = tracking_error(run.scenario, model, last)
        assert found == pytest.approx(errors[k], abs=1e-12)
    # The hand is led at 0.2 m/s and more, and follows.
    assert np.abs(run.log[signals.EE_COMMAND]).max() >= 0.2


@pytest.mark.realtime
def test_a_session_of_a_robot_with_masses_shows_a_hand_that_follows():
    scenario = load_scenario("kwon_spatial", ["fidelity=!Servo {}", "compiled=true"])
    with LiveSession(scenario) as session:
        seen = []
        start = time.monotonic()
        for sequence in range(200):
            driving = time.monotonic() - start > 0.5
            session.send(OperatorInput(sequence, v_c=0.2 * driving, dead_man=driving))
            time.sleep(0.02)
            snapshot = session.snapshot()
            moving = snapshot.signals.get(signals.EE_COMMAND, (0.0,))[0] == 0.2
            if moving:
                seen.append(snapshot.tracking_error)
    assert len(seen) > 20
    # A start from rest is a tick's lag; all that comes after is what a servo lacks.
    assert np.median(seen) < 0.01
