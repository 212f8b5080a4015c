"""An arm mounted anywhere on its base: the hand does as told all the same.

The truth is the robot's `MultibodyPlant`: the tool's velocity in W along and across the
line from the first joint's axis to the tool.
"""

import dataclasses as dc
import math

import numpy as np
import pytest

from drake_mobman import signals
from drake_mobman.base.smoother import Smoother
from drake_mobman.base.unsmoothed import Unsmoothed
from drake_mobman.console.snapshot import Snapshot
from drake_mobman.console.state import state
from drake_mobman.parameters import checked
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.defaults import Start
from drake_mobman.robots.franka_tiago import FrankaTiago
from drake_mobman.robots.spatial import Spatial
from drake_mobman.scenario import ScenarioError, load_scenario
from drake_mobman.simulation.simulate import simulate
from drake_mobman.teleop.scripted import Held, Script

EXACT = 1e-9
"""[m/s]: a chain of transforms and a Jacobian's inverse, to rounding."""

SERVO = 3e-4
"""[m/s]: twice what the servos' lag costs the same arm amid its base, rms."""

FIRST = {"planar": "shoulder", "spatial": "waist", "franka_tiago": "joint1"}
"""The joint about whose axis the arm turns, by the robot's name in its URDF."""


def velocities(run):
    """Returns the tool's velocity and the commanded one (N, 3) [m/s], by the plant.

    Along the reach, across it, and up.
    """
    log, model = run.log, RobotModel(run.scenario.robot)
    name = model.plant.GetModelInstanceName(
        model.plant.GetBodyByName("tool").model_instance()
    )
    shoulder = model.plant.GetJointByName(FIRST[name]).frame_on_parent()
    found, told = [], []
    for k in range(len(log["time"])):
        x, y, theta = log["base_pose"][k]
        forward, sideways, omega = log["base_velocity"][k]
        c, s = math.cos(theta), math.sin(theta)
        rolls = forward * c - sideways * s, forward * s + sideways * c, omega
        model.set_state(
            [x, y, theta, *log["arm_position"][k]],
            [*rolls, *log["arm_velocity"][k]],
        )
        p_WS = shoulder.CalcPoseInWorld(model._context).translation()
        reach = (model.p_W("tool") - p_WS)[:2]
        l = np.linalg.norm(reach)
        c, s = reach / l
        v = model.v_W("tool")
        found.append([c * v[0] + s * v[1], c * v[1] - s * v[0], v[2]])
        v_c, omega_c, v_z = log["ee_command"][k]
        told.append([v_c, l * omega_c, v_z])
    return np.array(found), np.array(told)


def held_commands(rng, up):
    """Returns a script of an operator who holds the stick for a time, and jumps."""
    return Script(
        segments=[
            Held(
                float(rng.uniform(0.3, 3.0)),
                v_c=float(rng.uniform(-0.35, 0.35)),
                omega_c=float(rng.uniform(-0.35, 0.35)),
                v_z=float(rng.uniform(-0.1, 0.1)) if up else 0.0,
            )
            for _ in range(5)
        ]
    )


def random_run(seed, name, decomposer):
    """Returns a run of held commands on a robot with its shoulder anywhere."""
    rng = np.random.default_rng(seed)
    scenario = load_scenario(name, [f"decomposer={decomposer}", *FAST])
    kind = type(scenario.robot)
    d, e = rng.uniform(-0.4, 0.4, 2)
    scenario = dc.replace(
        scenario,
        duration=6.0,
        robot=kind(shoulder_ahead=float(d), shoulder_aside=float(e)),
        start=Start(l=1.0, psi=float(rng.uniform(-0.6, 0.6)), theta=2.0),
        source=held_commands(rng, up=kind is Spatial),
        smoother=Smoother() if seed % 2 else Unsmoothed(),
    )
    run = simulate(checked(scenario))
    assert run.died == ""
    return run


def unhindered(run):
    """Returns whether neither decomposer nor arm say that a limit binds (N,)."""
    status = run.log[signals.ARM_STATUS][:, 0]
    if signals.DECOMPOSER_STATUS in run.log:
        status = status + run.log[signals.DECOMPOSER_STATUS][:, 0]
    return status == 0


FAST = ["compiled=true", "inverse=rates"]

DECOMPOSERS = {
    "exact": "!Exact {}",
    "field": "!VelocityField {K_f: 2.0, K_r: 2.0, Delta_f: 0.7, Delta_r: 0.3}",
}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", ["kwon_arbitrary", "kwon_spatial"])
@pytest.mark.parametrize("decomposer", DECOMPOSERS.values(), ids=DECOMPOSERS)
def test_hand_does_exactly_as_told(seed, name, decomposer):
    run = random_run(seed, name, decomposer)
    found, told = velocities(run)
    free = unhindered(run)
    assert free.mean() > 0.3
    np.testing.assert_allclose(found[free], told[free], rtol=0, atol=EXACT)
    # With the base turned meanwhile: else a shoulder aside makes no difference.
    assert np.abs(run.log["base_command_smoothed"][free][:, 1]).max() > 0.03


@pytest.mark.parametrize("aside", [0.2, -0.2])
def test_franka_with_masses_does_as_told(aside):
    scenario = load_scenario("kwon_franka", ["compiled=true", "duration=13"])
    run = simulate(dc.replace(scenario, robot=FrankaTiago(mount_aside=aside)))
    found, told = velocities(run)
    # With masses, the hand has what it was told a tick before.
    error = np.linalg.norm((found[1:] - told[:-1])[:, :2], axis=1)
    free = unhindered(run)[:-1]
    assert free.mean() > 0.9
    assert np.sqrt(np.mean(error[free] ** 2)) < SERVO
    assert np.abs(run.log["base_command_smoothed"][:, 1]).max() > 0.2


def test_hand_that_pulls_starts_where_the_tool_is():
    """The path's start is told by the plant, for an arm mounted anywhere."""
    mounted = ["robot.mount_ahead=0.05", "robot.mount_aside=0.2", "start.theta=0.5"]
    with pytest.raises(ScenarioError) as refused:
        load_scenario("petric_guided", mounted)
    scenario = load_scenario("petric_guided")
    robot = FrankaTiago(mount_ahead=0.05, mount_aside=0.2)
    model = RobotModel(robot)
    start = dc.replace(scenario.start, theta=0.5)
    q = dc.replace(scenario, robot=robot, start=start).start_position(scenario.setup())
    model.set_state(q, np.zeros(len(q)))
    x, y, z = model.p_W("tool")
    assert f"x = {x:.4f}, y = {y:.4f}, z = {z:.4f}" in str(refused.value)
    path = f"hand.path=[{{time: 0.0, x: {x:.4f}, y: {y:.4f}, z: {z:.4f}}}]"
    load_scenario("petric_guided", [*mounted, path, "hand.releases=[]"])


def test_console_shows_what_the_base_makes_of_the_hands_speed():
    """Along the reach, as the plant says of a hand that rests on a moving base."""
    robot = Spatial(shoulder_ahead=0.1, shoulder_aside=0.3)
    arm, model = robot.arm(), RobotModel(robot)
    hand = (1.1, 0.6, 0.1)
    rates = np.zeros(9)
    rates[:3] = 0.2, 0.0, -0.5
    model.set_state([0.0, 0.0, 0.0, *arm.inverse(hand)], rates)
    v = model.v_W("tool")
    shown = state(
        Snapshot(
            signals={
                signals.EE_CYLINDRICAL: hand,
                signals.BASE_COMMAND_SMOOTHED: (0.2, -0.5),
                signals.ARM_COMMAND: (0.0, 0.0, 0.0),
            }
        ),
        arm.p_BS,
    )
    along = math.cos(0.6) * v[0] + math.sin(0.6) * v[1]
    assert shown["base"] == pytest.approx(along, abs=1e-5)  # It is shown to 5 digits.
