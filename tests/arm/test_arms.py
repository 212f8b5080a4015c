"""Arms in closed form against `MultibodyPlant`'s kinematics of their URDFs."""

import functools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.math import RollPitchYaw

from drake_mobman.arm.planar import PlanarArm
from drake_mobman.arm.spatial import SpatialArm
from drake_mobman.parameters import ParameterError, checked
from drake_mobman.robot_model import BASE_JOINTS, RobotModel
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.spatial import Spatial

SAME = 1e-12
"""Two computations of one point: a product of ten rotations, lengths of up to 5 m."""

ROUNDING = 1e-13
"""A dozen operations on angles and lengths of up to 5, with the reach inverted."""

ROBOTS = {
    "planar": Planar(),
    "planar, unequal": Planar(
        upper_link=0.9, lower_link=0.55, shoulder_ahead=0.2, shoulder_height=0.8
    ),
    "planar, long forearm": Planar(upper_link=0.5, lower_link=0.75, shoulder_aside=0.3),
    "spatial": Spatial(),
    "spatial, unequal": Spatial(
        upper_link=0.6,
        lower_link=0.45,
        hand=0.2,
        shoulder_ahead=-0.1,
        shoulder_aside=-0.2,
    ),
    "spatial, long forearm": Spatial(
        upper_link=0.4, lower_link=0.7, hand=0.05, shoulder_height=0.3
    ),
}
PLANARS = [name for name, robot in ROBOTS.items() if isinstance(robot, Planar)]
SPATIALS = [name for name, robot in ROBOTS.items() if isinstance(robot, Spatial)]

every_robot = pytest.mark.parametrize("name", ROBOTS)
every_planar = pytest.mark.parametrize("name", PLANARS)
every_spatial = pytest.mark.parametrize("name", SPATIALS)


@functools.cache
def loaded(name):
    """Returns a robot, its model and its arm's closed form."""
    robot = ROBOTS[name]
    return robot, RobotModel(robot), robot.arm()


def random_states(model, *, is_level=False, elbow=None, count=50):
    """Yields positions of base and arm, the arm's within its limits.

    Args:
        model: the robot's.
        is_level: whether the spatial robot's hand is to be level and along the reach.
        elbow: range of the elbow's angle, where it is not to be all of it.
        count: how many.
    """
    rng = np.random.default_rng(1)
    low = np.append([-5.0, -5.0, -7.0], model.joint_limits.lower)
    high = np.append([5.0, 5.0, 7.0], model.joint_limits.upper)
    if elbow:
        index = BASE_JOINTS + model.arm_joints.index("elbow")
        low[index], high[index] = elbow
    for q in rng.uniform(low, high, (count, len(low))):
        if is_level:
            q[-3:] = [0.0, -(q[4] + q[5]), 0.0]
        yield q


def in_world(q, p_B):
    """Returns a point of B in W, for a base at `q[:3]` on the floor."""
    x, y, theta = q[:BASE_JOINTS]
    c, s = math.cos(theta), math.sin(theta)
    return [x + c * p_B[0] - s * p_B[1], y + s * p_B[0] + c * p_B[1], p_B[2]]


def p_BE(robot, workspace):
    """Returns E in B from the cylindrical coordinates, as the contract has them."""
    l, psi, z = workspace
    return [
        robot.shoulder_ahead + l * math.cos(psi),
        robot.shoulder_aside + l * math.sin(psi),
        robot.shoulder_height + z,
    ]


@every_robot
def test_wrist_centre_is_where_the_urdf_has_it(name):
    _, model, arm = loaded(name)
    for q in random_states(model):
        model.set_state(q, 0 * q)
        expected = in_world(q, arm.p_BT(q[BASE_JOINTS:]))
        np.testing.assert_allclose(model.p_W("tee"), expected, atol=SAME)


@every_robot
def test_tool_is_where_the_workspace_says(name):
    robot, model, arm = loaded(name)
    for q in random_states(model, is_level=name in SPATIALS):
        model.set_state(q, 0 * q)
        expected = in_world(q, p_BE(robot, arm.ee_cylindrical(q[BASE_JOINTS:])))
        np.testing.assert_allclose(model.p_W("tool"), expected, atol=SAME)


@every_robot
def test_it_is_as_long_as_its_links(name):
    robot, model, arm = loaded(name)
    q = np.zeros(BASE_JOINTS + arm.num_joints)
    model.set_state(q, q)
    stretch = robot.upper_link + robot.lower_link
    tee = [robot.shoulder_ahead + stretch, robot.shoulder_aside, robot.shoulder_height]
    np.testing.assert_allclose(model.p_W("tee"), tee, atol=SAME)
    tool = np.add(tee, [getattr(robot, "hand", 0.0), 0.0, 0.0])
    np.testing.assert_allclose(model.p_W("tool"), tool, atol=SAME)
    np.testing.assert_allclose(arm.p_BS, tee - np.array([stretch, 0, 0]))


@every_robot
def test_rates_are_those_by_which_the_hand_moves(name):
    """The tool's velocity along the reach, across it and up, as v_m, omega_m, v_z."""
    _, model, arm = loaded(name)
    rng = np.random.default_rng(2)
    bent = (-2.9, -0.2)  # Away from both singularities.
    for q in random_states(model, is_level=name in SPATIALS, elbow=bent):
        q[:BASE_JOINTS] = 0.0
        v_m, omega_m, v_z = rng.uniform(-0.4, 0.4, 3)
        if name in PLANARS:
            v_z = 0.0
        joints = q[BASE_JOINTS:]
        l, psi, _ = arm.ee_cylindrical(joints)
        rates = arm.rates(joints, (v_m, omega_m, v_z))
        model.set_state(q, np.append(np.zeros(BASE_JOINTS), rates))
        c, s = math.cos(psi), math.sin(psi)
        expected = [
            v_m * c - l * omega_m * s,
            v_m * s + l * omega_m * c,
            v_z,
        ]
        np.testing.assert_allclose(model.v_W("tool"), expected, atol=SAME)


@every_planar
@given(data=st.data())
def test_planar_inverse_comes_back_over_the_whole_workspace(name, data):
    robot, _, arm = loaded(name)
    fold = abs(robot.upper_link - robot.lower_link)
    stretch = robot.upper_link + robot.lower_link
    l = data.draw(st.floats(fold, stretch), label="l")
    psi = data.draw(st.floats(-1.8, 4.8), label="psi")
    q = arm.inverse((l, psi, 0.0))
    assert arm.ee_cylindrical(q) == pytest.approx((l, psi, 0.0), abs=ROUNDING)
    assert -math.pi <= q[1] <= 0


@every_spatial
@given(data=st.data())
def test_spatial_inverse_comes_back_over_the_whole_workspace(name, data):
    robot, _, arm = loaded(name)
    fold = abs(robot.upper_link - robot.lower_link)
    stretch = robot.upper_link + robot.lower_link
    distance = data.draw(st.floats(fold + 1e-6, stretch - 1e-6), label="distance")
    up = data.draw(st.floats(-1.57, 1.57), label="angle above the shoulder")
    psi = data.draw(st.floats(-2.9, 2.9), label="psi")
    hand = (robot.hand + distance * math.cos(up), psi, distance * math.sin(up))
    q = arm.inverse(hand)
    assert arm.ee_cylindrical(q) == pytest.approx(hand, abs=ROUNDING)
    assert -math.pi <= q[2] <= 0
    # Level, and along the reach: no roll, no yaw, pitch against shoulder and elbow.
    assert q[3] == q[5] == 0
    assert q[1] + q[2] + q[4] == pytest.approx(0.0, abs=ROUNDING)


@every_robot
def test_inverse_puts_the_urdfs_tool_there(name):
    robot, model, arm = loaded(name)
    rng = np.random.default_rng(3)
    fold = abs(robot.upper_link - robot.lower_link)
    stretch = robot.upper_link + robot.lower_link
    for _ in range(50):
        l = rng.uniform(fold + 0.01, stretch - 0.01) + getattr(robot, "hand", 0.0)
        hand = (l, rng.uniform(-1.5, 1.5), 0.0)
        q = np.append(rng.uniform(-3.0, 3.0, BASE_JOINTS), arm.inverse(hand))
        model.set_state(q, 0 * q)
        expected = in_world(q, p_BE(robot, hand))
        np.testing.assert_allclose(model.p_W("tool"), expected, atol=SAME)


@every_planar
@given(l=st.floats(0.0, 3.0), psi=st.floats(-1.8, 1.8))
def test_planar_out_of_reach_gives_the_nearest_at_the_same_psi(name, l, psi):
    robot, _, arm = loaded(name)
    fold = abs(robot.upper_link - robot.lower_link)
    stretch = robot.upper_link + robot.lower_link
    nearest = min(max(l, fold), stretch)
    found = arm.ee_cylindrical(arm.inverse((l, psi, 0.0)))
    # At the fold of equal links, 2.2e-16 of the elbow is as much of the reach.
    assert found == pytest.approx((nearest, psi, 0.0), abs=ROUNDING)


@pytest.mark.parametrize("psi", [-0.85, 0.0, 0.85, 2.0])
def test_psi_is_held_where_the_arm_is_folded_up(psi):
    arm = Planar().arm()
    q = arm.inverse((0.0, psi, 0.0))
    l, found, _ = arm.ee_cylindrical(q)
    assert l == pytest.approx(0.0, abs=ROUNDING)
    assert found == pytest.approx(psi, abs=ROUNDING)
    assert q[1] == -math.pi
    # And when it turns there: table 2, scenarios 3 and 4.
    turned = arm.inverse((l, found + 0.0035, 0.0))
    assert turned == pytest.approx([q[0] + 0.0035, -math.pi], abs=ROUNDING)


@every_spatial
def test_hand_stays_level_and_along_the_reach(name):
    robot, model, arm = loaded(name)
    tool, context = (
        model.plant.GetFrameByName("tool"),
        model.plant.CreateDefaultContext(),
    )
    rng = np.random.default_rng(4)
    stretch = robot.upper_link + robot.lower_link
    for _ in range(50):
        theta, psi = rng.uniform(-3.0, 3.0), rng.uniform(-2.9, 2.9)
        l = robot.hand + rng.uniform(0.5, 0.9) * stretch
        q = np.append([1.0, 2.0, theta], arm.inverse((l, psi, 0.2 * stretch)))
        model.set_state(q, 0 * q)
        model.plant.SetPositions(context, q)
        R_WE = tool.CalcPoseInWorld(context).rotation().matrix()
        expected = RollPitchYaw(0.0, 0.0, theta + psi).ToRotationMatrix().matrix()
        np.testing.assert_allclose(R_WE, expected, atol=SAME)
        # The tool's x axis goes from the shoulder's axis through the tool.
        shoulder = in_world(q, arm.p_BS)
        reach = (model.p_W("tool") - shoulder) * [1, 1, 0]
        np.testing.assert_allclose(R_WE[:, 0], reach / l, atol=SAME)


@every_spatial
def test_hand_turns_with_arm_and_base_together(name):
    """omega_eps = omega_m + omega_b (eq. 3), about z alone, whatever l and z do."""
    robot, model, arm = loaded(name)
    tool, context = (
        model.plant.GetFrameByName("tool"),
        model.plant.CreateDefaultContext(),
    )
    rng = np.random.default_rng(5)
    stretch = robot.upper_link + robot.lower_link
    for _ in range(50):
        l = robot.hand + rng.uniform(0.5, 0.9) * stretch
        q = np.append(
            rng.uniform(-3.0, 3.0, BASE_JOINTS),
            arm.inverse((l, rng.uniform(-1.0, 1.0), 0.2 * stretch)),
        )
        v_m, omega_m, v_z, omega_b = rng.uniform(-0.4, 0.4, 4)
        rates = arm.rates(q[BASE_JOINTS:], (v_m, omega_m, v_z))
        model.plant.SetPositions(context, q)
        model.plant.SetVelocities(context, np.array([0.1, -0.2, omega_b, *rates]))
        V_WE = tool.CalcSpatialVelocityInWorld(context)
        np.testing.assert_allclose(
            V_WE.rotational(), [0, 0, omega_m + omega_b], atol=SAME
        )


@pytest.mark.parametrize(
    ("robot", "names"),
    [
        (Planar(), ["shoulder", "elbow"]),
        (
            Spatial(),
            ["waist", "shoulder", "elbow", "wrist_roll", "wrist_pitch", "wrist_yaw"],
        ),
    ],
    ids=["planar", "spatial"],
)
def test_joints_stand_in_the_order_of_the_arms(robot, names):
    model = RobotModel(robot)
    assert model.arm_joints == names
    assert robot.arm().num_joints == len(names)
    assert model.plant.num_positions() == BASE_JOINTS + len(names)
    for limits in (
        model.joint_limits.lower,
        model.joint_limits.upper,
        model.joint_limits.velocity,
    ):
        assert len(limits) == len(names)
        assert np.isfinite(limits).all()


def test_manipulability_is_that_of_two_links():
    # det J of two links is L1 L2 sin theta_2 (eq. 7): here 0.9 x 0.55 x sin(1.2).
    _, model, _ = loaded("planar, unequal")
    q = np.array([1.0, 2.0, 0.5, 0.3, -1.2])
    model.set_state(q, 0 * q)
    expected = 0.9 * 0.55 * math.sin(1.2)
    assert model.manipulability() == pytest.approx(expected, abs=SAME)


def test_manipulability_of_three_axes_is_that_of_two_times_the_reach():
    # The waist moves T sideways by l_T, square to what shoulder and elbow do.
    _, model, _ = loaded("spatial, unequal")
    q = np.array([1.0, 2.0, 0.5, 0.3, 0.8, -1.2, 0.0, 0.4, 0.0])
    model.set_state(q, 0 * q)
    l_T = 0.6 * math.cos(0.8) + 0.45 * math.cos(-0.4)
    expected = 0.6 * 0.45 * math.sin(1.2) * l_T
    assert model.manipulability() == pytest.approx(expected, abs=SAME)


@pytest.mark.parametrize("robot", [Planar, Spatial])
@pytest.mark.parametrize(
    ("key", "value"),
    [("upper_link", -1.0), ("lower_link", 0.0), ("upper_link", math.nan)],
)
def test_a_link_without_length_is_refused(robot, key, value):
    with pytest.raises(ParameterError, match=f"^{key}: "):
        checked(robot(**{key: value}))


def test_arms_are_those_of_their_robots():
    assert Planar(upper_link=0.9).arm() == PlanarArm(0.9, 1.0, (0.0, 0.0, 0.5))
    expected = SpatialArm(1.0, 1.0, 0.3, (0.15, 0.0, 0.7))
    assert Spatial(hand=0.3).arm() == expected
