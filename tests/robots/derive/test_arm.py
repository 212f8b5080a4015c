"""What is derived of an arm, for robots whose numbers are known otherwise."""

import math

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator

from drake_mobman.arm.chain import chain_of
from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.base.smoother import Smoother
from drake_mobman.base.velocity_field import check_zones, field_velocity
from drake_mobman.robot_model import Reach, RobotModel
from drake_mobman.robots.derive.damping import damping
from drake_mobman.robots.derive.field import body_edge, field
from drake_mobman.robots.derive.hand import apparent_mass, softness
from drake_mobman.robots.derive.posture import posture
from drake_mobman.robots.derive.ranges import arm_ranges
from drake_mobman.robots.derive.reach import farthest
from drake_mobman.robots.derive.speeds import guard, smoother
from drake_mobman.robots.derive.tee import tee
from drake_mobman.robots.derive.workspace import reached, workspace
from drake_mobman.robots.franka_tiago import POSTURE, FrankaTiago, reduced_arm
from drake_mobman.robots.spatial import Spatial

FRANKA = RobotModel(FrankaTiago())
PLANT = FRANKA.plant
ARM = JacobianArm(PLANT, POSTURE)
RANGES = arm_ranges(PLANT)
ROUNDING = 1e-6
"""[m], [rad]: what a climb or a nonlinear program ends at."""


def arm_joints(plant):
    joints = map(plant.get_joint, plant.GetJointIndices())
    moving = sorted(
        (x for x in joints if x.num_positions()), key=lambda x: x.position_start()
    )
    return moving[3:]


def test_T_is_where_the_makers_wrist_centre_is():
    context = PLANT.CreateDefaultContext()
    base, tool = PLANT.GetFrameByName("base"), PLANT.GetFrameByName("tool")
    point, source = tee(arm_joints(PLANT), context, tool)
    found = point.body.body_frame().CalcPose(context, base) @ point.p
    expected = PLANT.GetFrameByName("tee").CalcPose(context, base).translation()
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert source == "where the axes of joint5 and joint6 meet"


def test_an_arm_of_five_joints_has_T_at_its_tool():
    context, tool = PLANT.CreateDefaultContext(), PLANT.GetFrameByName("tool")
    point, source = tee(arm_joints(PLANT)[:5], context, tool)
    assert point.body.index() == tool.body().index()
    assert source == "E, as there is no wrist"


def test_the_reach_is_that_of_both_links_stretched():
    found = farthest(chain_of(PLANT), RANGES).value
    assert found == pytest.approx(reduced_arm(PLANT).r_f, abs=1e-4)
    spatial = Spatial(upper_link=0.6, lower_link=0.45)
    plant = RobotModel(spatial).plant
    assert farthest(chain_of(plant), arm_ranges(plant)).value == pytest.approx(1.05)


def test_the_franka_gets_the_damping_that_was_chosen_for_it():
    found = damping(0.72, 0.21).value
    assert found.threshold == pytest.approx(0.02)
    assert found.length == pytest.approx(0.21)
    assert damping(0.72, 0.0).value.length == pytest.approx(0.144)


@pytest.fixture(scope="module")
def found_posture():
    return posture(PLANT, ARM.p_BS, reduced_arm(PLANT).r_f, 0.2, level=True)


def test_a_posture_is_level_ahead_in_the_middle_and_far_from_limits(found_posture):
    q, source = found_posture
    assert RANGES.margin(q) > 0.1
    FRANKA.set_state(np.append(np.zeros(3), q), np.zeros(10))
    x, y, _ = FRANKA.p_W("tool") - np.array(ARM.p_BS)
    assert x > 0.2
    assert y == pytest.approx(0.0, abs=ROUNDING)
    T = np.linalg.norm(FRANKA.p_W("tee") - np.array(ARM.p_BS))
    assert 0.6 < T / reduced_arm(PLANT).r_f < 0.8
    context = PLANT.CreateDefaultContext()
    PLANT.SetPositions(context, np.append(np.zeros(3), q))
    tool = PLANT.GetFrameByName("tool").CalcPoseInWorld(context).rotation().matrix()
    # The maker's tool points along its z axis.
    points = {"tool ahead": [1, 0, 0], "tool down": [0, 0, -1]}[source.split(", ")[1]]
    np.testing.assert_allclose(tool[:, 2], points, atol=1e-5)


def test_a_posture_is_the_same_each_time(found_posture):
    again = posture(PLANT, ARM.p_BS, reduced_arm(PLANT).r_f, 0.2, level=True)
    np.testing.assert_array_equal(again.value, found_posture.value)


def test_limits_of_the_workspace_are_reached_and_a_little_more_is_not_slow():
    base = smoother(FRANKA.base_limits).value
    most = guard(ARM, FRANKA.joint_limits, base).value
    far = reached(ARM, FRANKA.joint_limits, RANGES, most, 0.72).value
    limits = workspace(ARM, far).value
    l, psi, z = ARM.ee_cylindrical(POSTURE)
    assert far.l[0] < limits.l_min < l < limits.l_max < far.l[1]
    assert limits.psi_min < psi < limits.psi_max
    assert far.z[0] < z < far.z[1]
    for place in (
        (l, psi, z),
        *((x, psi, z) for x in far.l),
        *((l, psi, x) for x in far.z),
    ):
        q = ARM.inverse(place)
        np.testing.assert_allclose(ARM.ee_cylindrical(q), place, atol=1e-9)
        for command in np.diag(most.largest):
            rates = np.abs(ARM.undamped_rates(q, command)[0])
            assert (rates < np.array(FRANKA.joint_limits.velocity)).all()
    # Beyond the end, something does not hold any more.
    q = ARM.inverse((far.l[1] + 0.02, psi, z))
    fast = max(
        (np.abs(ARM.undamped_rates(q, c)[0]) / FRANKA.joint_limits.velocity).max()
        for c in np.diag(most.largest)
    )
    assert fast > 0.9 or RANGES.margin(np.array(q)) < 0.02 or ARM.is_near_singular(q)


def test_the_base_is_to_do_half_of_what_it_can():
    found = smoother(FRANKA.base_limits).value
    assert found.max_speed == FRANKA.base_limits.max_speed / 2
    assert found.max_yaw_rate == FRANKA.base_limits.max_yaw_rate / 2


@pytest.mark.parametrize(
    ("reach", "edge"),
    [
        (Reach(0.5, 0.7), 0.3),
        (Reach(0.5, 0.7, ahead=0.4), 0.0),
        (Reach(0.5, 0.7, ahead=-0.1), 0.4),
    ],
)
def test_the_bodys_edge_counts_where_the_arm_is(reach, edge):
    assert body_edge(reach, 0.3) == pytest.approx(edge)


def test_the_edge_ahead_of_a_shoulder_in_front_is_nearer_than_to_its_sides():
    # 0.6 rad to either side of a shoulder 0.1 m ahead: x + 0.1 = 0.3 sin(...).
    reach = Reach(0.5, 0.7, ahead=0.1)
    t = body_edge(reach, 0.3)
    assert math.hypot(0.1 + t * math.cos(0.6), t * math.sin(0.6)) == pytest.approx(0.3)


@pytest.mark.parametrize("radius", [0.0, 0.27, 0.5, 2.0])
@pytest.mark.parametrize("nearest", [0.0, 0.4, 1.0])
def test_a_field_fits_its_arm_whatever_the_body(radius, nearest):
    reach = Reach(0.5, 0.6)
    found = field(reach, radius, nearest, 0.0, Smoother()).value
    check_zones(found, reach)
    found.check()


def test_a_field_stays_out_of_the_body_where_the_arm_reaches_over_it():
    found = field(Reach(0.5, 0.72), 0.27, 0.0, 0.0, Smoother()).value
    assert found.b_d == pytest.approx(0.3)


@pytest.mark.parametrize("height", [-0.35, -0.1, 0.0, 0.3])
def test_the_base_is_at_rest_between_the_zones_at_the_postures_height(height):
    reach = Reach(1.0, 0.8)
    found = field(reach, 0.5, 0.7, height, Smoother()).value
    places = [(x, 0.0, 1.0 + height) for x in np.linspace(0.01, 0.8, 400)]
    speeds = np.array([field_velocity(p, found, reach)[0] for p in places])
    steepest = found.K_f * 0.8 / 399  # As T moves level, distances change no more.
    assert np.abs(np.diff(speeds)).max() <= steepest * (1 + 1e-9)
    assert (speeds == 0.0).sum() > 10


PULLED = 0.01
"""How long a force is constant [s]."""


def test_apparent_mass_is_what_a_short_pull_moves():
    """In the direction in which the tool is lightest, by the plant's own motion."""
    mass = apparent_mass(PLANT, np.array(POSTURE))
    plant = heavy_base()
    lightest = min(felt(plant, direction) for direction in directions(200))
    assert mass <= lightest * (1 + 1e-4)
    assert mass == pytest.approx(lightest, rel=0.03)


def test_a_hand_is_soft_for_a_tool_that_is_light_to_pull():
    """Of a hand and a free mass: their motion, period by period, dies away."""
    for scale in (1.0, 0.1):
        mass = scale * apparent_mass(PLANT, np.array(POSTURE))
        k, c = softness(mass)
        v_of_f, x_of_f = PULLED / mass, 0.5 * PULLED**2 / mass
        A = np.array(
            [[1 - k * x_of_f, PULLED - c * x_of_f], [-k * v_of_f, 1 - c * v_of_f]]
        )
        # In other postures, it is half as heavy.
        for heaviness in (0.5, 1.0, 3.0):
            B = np.array([[1.0, PULLED], [0.0, 1.0]])
            step = B + (A - B) / heaviness
            assert np.abs(np.linalg.eigvals(step)).max() < 0.99


def heavy_base():
    """Returns the robot's plant without gravity, its base too heavy to be moved.

    Its joints are damped, as those of a free arm are by default.
    """
    plant = MultibodyPlant(0.0)
    FrankaTiago().add_to(plant)
    heavy = SpatialInertia.SolidSphereWithMass(1e9, 1.0)
    instance = plant.AddModelInstance("ballast")
    body = plant.AddRigidBody("ballast", instance, heavy)
    plant.WeldFrames(plant.GetFrameByName("base"), body.body_frame())
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    for i in plant.GetJointActuatorIndices():
        joint = plant.get_joint_actuator(i).joint()
        if joint.name() not in {"x", "y", "theta"}:
            joint.set_default_damping(1.0)
    plant.Finalize()
    return plant


def directions(count):
    """Returns unit vectors spread over a sphere."""
    found = np.random.default_rng(0).normal(size=(count, 3))
    return found / np.linalg.norm(found, axis=1)[:, None]


def felt(plant, direction):
    """Returns the force on the tool over its mean acceleration during a pull."""
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    plant.SetPositions(context, np.append(np.zeros(3), POSTURE))
    tool = plant.GetFrameByName("tool")
    force = ExternallyAppliedSpatialForce()
    force.body_index = tool.body().index()
    force.p_BoBq_B = tool.GetFixedPoseInBodyFrame().translation()
    small = 1e-3
    force.F_Bq_W = SpatialForce([0, 0, 0], small * direction)
    port = plant.get_applied_spatial_force_input_port()
    port.FixValue(context, Value([force]))
    simulator.get_mutable_integrator().set_target_accuracy(1e-8)
    simulator.AdvanceTo(PULLED)
    velocity = tool.CalcSpatialVelocityInWorld(context).translational()
    return small * PULLED / (direction @ velocity)
