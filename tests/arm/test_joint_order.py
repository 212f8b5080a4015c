"""A robot is the same in whatever order its URDF declares joints and actuators."""

import dataclasses as dc
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import BASE_JOINTS, RobotModel
from drake_mobman.robot_model.model import drawn_plant, moving_joints
from drake_mobman.robots.defaults import Start
from drake_mobman.robots.franka_tiago import POSTURE, FrankaTiago
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.spatial import Spatial
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate

SAME = 1e-9
"""Of two runs [m], [rad] and per second: links in another order round otherwise, and a
servo's solver adds up in another order."""


# Else the limits of Drake's own, such as accelerations, get another prefix.
ET.register_namespace("drake", "http://drake.mit.edu")


def backwards(urdf):
    """Returns a URDF with links, joints and actuators from the tool to the base."""
    root = ET.fromstring(urdf)
    for tag in ("link", "joint", "transmission"):
        found = root.findall(tag)
        places = [list(root).index(element) for element in found]
        for place, element in zip(places, reversed(found), strict=True):
            root[place] = element
    return ET.tostring(root, encoding="unicode")


@dc.dataclass
class BackwardsPlanar(Planar):
    def urdf(self):
        return backwards(super().urdf())


@dc.dataclass
class BackwardsSpatial(Spatial):
    def urdf(self):
        return backwards(super().urdf())


@dc.dataclass
class BackwardsFranka(FrankaTiago):
    def urdf(self):
        return backwards(super().urdf())


PAIRS = {
    "planar": (Planar, BackwardsPlanar),
    "spatial": (Spatial, BackwardsSpatial),
    "franka_tiago": (FrankaTiago, BackwardsFranka),
}


def declared(urdf, name):
    """Returns a joint's limits as its URDF says them: lower, upper, velocity."""
    (limit,) = ET.fromstring(urdf).findall(f"joint[@name='{name}']/limit")
    return [float(limit.get(key)) for key in ("lower", "upper", "velocity")]


@pytest.mark.parametrize("kinds", PAIRS.values(), ids=PAIRS)
def test_names_bodies_and_limits_are_each_joints_own(kinds):
    straight, turned = (RobotModel(kind()) for kind in kinds)
    assert turned.arm_joints == straight.arm_joints
    assert turned.arm_bodies.keys() == straight.arm_bodies.keys()
    limits = turned.joint_limits
    for i, name in enumerate(turned.arm_joints):
        found = [limits.lower[i], limits.upper[i], limits.velocity[i]]
        assert found == declared(kinds[1]().urdf(), name)
        assert limits.acceleration[i] == straight.joint_limits.acceleration[i]


@pytest.mark.parametrize("kinds", PAIRS.values(), ids=PAIRS)
def test_a_state_is_given_by_the_names_in_their_order(kinds):
    model = RobotModel(kinds[1]())
    q = np.linspace(-0.3, 0.4, BASE_JOINTS + len(model.arm_joints))
    model.plant.SetPositions(model._context, q)
    names = ["x", "y", "theta", *model.arm_joints]
    assert [joint.name() for joint in moving_joints(model.plant)] == names
    for name, angle in zip(names, q, strict=True):
        joint = model.plant.GetJointByName(name)
        assert joint.GetOnePosition(model._context) == angle


@pytest.mark.parametrize(
    ("robot", "joint", "psi"),
    [
        (BackwardsPlanar(), "shoulder", 4.5),
        (BackwardsSpatial(), "waist", 3.5),
    ],
)
def test_start_out_of_a_joints_range_names_that_joint(robot, joint, psi):
    scenario = load_scenario("kwon_arbitrary")
    turned = dc.replace(scenario, robot=robot, start=Start(l=0.8, psi=psi))
    with pytest.raises(ParameterError, match=f"keep joint {joint} within"):
        turned.check()


@pytest.mark.parametrize("name", ["kwon_arbitrary", "kwon_spatial", "kwon_franka"])
def test_start_is_the_same(name):
    scenario = load_scenario(name)
    kinds = dict(PAIRS.values())
    turned = dc.replace(scenario, robot=kinds[type(scenario.robot)]())
    found, expected = (each.start_position(each.setup()) for each in (turned, scenario))
    np.testing.assert_allclose(found, expected, rtol=0, atol=SAME)


@pytest.mark.parametrize("kinds", PAIRS.values(), ids=PAIRS)
def test_picture_is_the_same(kinds):
    places = []
    for kind in kinds:
        plant, _ = drawn_plant(kind())
        context = plant.CreateDefaultContext()
        plant.SetPositions(context, np.linspace(-0.3, 0.4, plant.num_positions()))
        links = ("base", "tee", "tool")
        places += [plant.GetFrameByName(x).CalcPoseInWorld(context) for x in links]
    for found, expected in zip(places[3:], places[:3], strict=True):
        assert found.IsNearlyEqualTo(expected, SAME)


def moved(scenario, robot):
    """Returns the log of a scenario with another robot in it."""
    run = simulate(dc.replace(scenario, robot=robot))
    assert run.died == ""
    return run.log


RUNS = {
    "planar exact": ("kwon_arbitrary", "planar", "duration=5"),
    "planar qp": ("kwon_arbitrary", "planar", "duration=5", "decomposer=!Qp {}"),
    "planar diffik": (
        "kwon_arbitrary",
        "planar",
        "duration=3",
        "decomposer=!DiffIk {}",
    ),
    "planar servo": ("kwon_arbitrary", "planar", "duration=5", "fidelity=!Servo {}"),
    "spatial qp": ("kwon_spatial", "spatial", "duration=5", "decomposer=!Qp {}"),
    "spatial servo": ("kwon_spatial", "spatial", "duration=5", "fidelity=!Servo {}"),
    "franka servo": ("kwon_franka", "franka_tiago", "duration=5"),
    "franka free": ("petric_guided", "franka_tiago", "duration=4"),
    "franka sprung": (
        "petric_guided",
        "franka_tiago",
        "duration=4",
        "fidelity=!Servo {joint_stiffness: 5.0}",
    ),
}


@pytest.mark.parametrize("case", RUNS.values(), ids=RUNS)
def test_runs_are_the_same(case):
    name, robot, *overrides = case
    scenario = load_scenario(name, overrides)
    straight, turned = (moved(scenario, kind()) for kind in PAIRS[robot])
    assert straight.keys() == turned.keys()
    for signal, values in straight.items():
        np.testing.assert_allclose(
            turned[signal], values, rtol=0, atol=SAME, err_msg=signal
        )
    travelled = straight["base_pose"][-1] - straight["base_pose"][0]
    assert np.abs(travelled).max() > 0.05


def test_posture_is_that_of_the_named_joints():
    arm = BackwardsFranka().arm()
    np.testing.assert_array_equal(arm.posture, POSTURE)
    np.testing.assert_allclose(
        arm.ee_cylindrical(POSTURE),
        FrankaTiago().arm().ee_cylindrical(POSTURE),
        atol=SAME,
    )
