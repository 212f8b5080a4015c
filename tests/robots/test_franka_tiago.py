"""The Franka arm on the TIAGo base: kinematics, dynamics, lengths and limits."""

import xml.etree.ElementTree as ET

import numpy as np
import pinocchio
import pytest

from drake_mobman.parameters import ParameterError, checked
from drake_mobman.robot_model import BASE_JOINTS, RobotModel
from drake_mobman.robots.franka_tiago import POSTURE, FrankaTiago, reduced_arm

SAME = 1e-9
"""Two implementations, one URDF: about ten products of rotations, and 40 kg."""

LINKS = ["base", "left_wheel", "right_wheel", "tee", "hand", "tool"]
LINKS += [f"link{i}" for i in range(8)] + ["left_finger", "right_finger"]


@pytest.fixture(scope="module")
def robot():
    return RobotModel(FrankaTiago())


@pytest.fixture(scope="module")
def other():
    """The same URDF as Pinocchio reads it, its wheels held."""
    robot = ET.fromstring(FrankaTiago().urdf())
    for side in ("left", "right"):
        robot.find(f"joint[@name='{side}_wheel']").set("type", "fixed")
    return pinocchio.buildModelFromXML(ET.tostring(robot, encoding="unicode"))


def random_states(model, count=50):
    """Yields base and joint positions; the arm's stay within their limits."""
    rng = np.random.default_rng(0)
    low = np.append([-5.0, -5.0, -7.0], model.joint_limits.lower)
    high = np.append([5.0, 5.0, 7.0], model.joint_limits.upper)
    yield from rng.uniform(low, high, (count, len(low)))


def as_pinocchio(q):
    """A joint without limits is a point on the circle there."""
    x, y, theta, *arm = q
    return np.array([x, y, np.cos(theta), np.sin(theta), *arm])


def p_ST(model, q):
    model.set_state(q, 0 * q)
    return model.p_W("tee") - model.p_W("link2")


def test_its_links_stand_where_pinocchio_puts_them(robot, other):
    data = other.createData()
    context = robot.plant.CreateDefaultContext()
    for q in random_states(robot):
        robot.plant.SetPositions(context, q)
        pinocchio.framesForwardKinematics(other, data, as_pinocchio(q))
        for link in LINKS:
            X_WL = robot.plant.GetFrameByName(link).CalcPoseInWorld(context)
            frame = other.getFrameId(link, pinocchio.FrameType.BODY)
            expected = data.oMf[frame].homogeneous
            np.testing.assert_allclose(X_WL.GetAsMatrix4(), expected, atol=SAME)


def test_its_mass_matrix_is_pinocchios(robot, other):
    data = other.createData()
    context = robot.plant.CreateDefaultContext()
    for q in random_states(robot):
        robot.plant.SetPositions(context, q)
        M = robot.plant.CalcMassMatrix(context)
        expected = pinocchio.crba(other, data, as_pinocchio(q))
        expected = np.triu(expected) + np.triu(expected, 1).T
        np.testing.assert_allclose(M, expected, atol=SAME)


def test_its_flange_is_where_the_makers_table_puts_it(robot):
    a = [0, 0, 0, 0.0825, -0.0825, 0, 0.088, 0]
    d = [0.333, 0, 0.316, 0, 0.384, 0, 0, 0.107]
    alpha = np.pi / 2 * np.array([0, -1, 1, 1, -1, 1, 1, 0])
    for q in random_states(robot):
        X = pinocchio.SE3.Identity()
        for a_i, d_i, alpha_i, theta in zip(a, d, alpha, [*q[-7:], 0.0], strict=True):
            across = np.array([a_i, 0, 0])
            X *= pinocchio.SE3(pinocchio.utils.rotate("x", alpha_i), across)
            along = np.array([0, 0, d_i])
            X *= pinocchio.SE3(pinocchio.utils.rotate("z", theta), along)
        q[:BASE_JOINTS] = 0.0
        robot.set_state(q, 0 * q)
        p_FH = robot.p_W("hand") - robot.p_W("link0")
        np.testing.assert_allclose(p_FH, X.translation, atol=SAME)


def test_its_mass_is_what_the_makers_say(robot):
    base = 28.26649 + 2 * 1.82362
    arm = 2.3966 + 2.7907 + 2.5420 + 2.2513 + 2.2037 + 2.2855 + 1.353 + 0.35973
    hand = 0.6544 + 2 * 0.0291
    mass = robot.plant.CalcTotalMass(robot.plant.CreateDefaultContext())
    assert mass == pytest.approx(base + arm + hand)


def test_every_body_could_exist(robot):
    plant = robot.plant
    context = plant.CreateDefaultContext()
    for i in plant.GetBodyIndices(plant.GetModelInstanceByName("franka_tiago")):
        M = plant.get_body(i).CalcSpatialInertiaInBodyFrame(context)
        assert M.IsPhysicallyValid()


def test_its_joints_have_the_makers_limits(robot, other):
    limits = robot.joint_limits
    lower = [-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973]
    upper = [2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973]
    acceleration = robot.plant.GetAccelerationUpperLimits()[BASE_JOINTS:]
    assert robot.arm_joints == [f"joint{i}" for i in range(1, 8)]
    np.testing.assert_array_equal(limits.lower, lower)
    np.testing.assert_array_equal(limits.upper, upper)
    np.testing.assert_array_equal(limits.velocity, [2.175] * 4 + [2.61] * 3)
    np.testing.assert_array_equal(acceleration, [15, 7.5, 10, 12.5, 15, 20, 20])
    # Drake keeps torque limits with actuators, and the URDF has none.
    torque = other.effortLimit[BASE_JOINTS:]
    np.testing.assert_array_equal(torque, [87] * 4 + [12] * 3)


def test_its_base_has_the_makers_numbers(robot):
    base = robot.base_limits
    assert base.max_speed == 1.0
    assert base.max_acceleration == 1.0
    assert base.max_yaw_rate == pytest.approx(np.deg2rad(120))
    assert base.max_yaw_acceleration == pytest.approx(np.deg2rad(120))


def test_its_lengths_follow_from_the_makers_table(robot):
    arm = reduced_arm(robot.plant)
    assert arm.l_1 == pytest.approx(np.hypot(0.316, 0.0825))
    assert arm.l_2 == pytest.approx(np.hypot(0.384, 0.0825))
    assert arm.p_BS == pytest.approx((0, 0, 0.3 + FrankaTiago().mount + 0.333))


def test_a_taller_mount_lifts_the_shoulder_alone():
    low, high = (reduced_arm(RobotModel(FrankaTiago(h)).plant) for h in (0.05, 0.3))
    assert high.l_0 - low.l_0 == pytest.approx(0.25)
    assert (high.l_1, high.l_2) == pytest.approx((low.l_1, low.l_2))


def test_tee_never_gets_farther_than_both_lengths(robot):
    r_f = reduced_arm(robot.plant).r_f
    for q in random_states(robot, 500):
        assert np.linalg.norm(p_ST(robot, q)) <= r_f + SAME


def test_tee_gets_as_far_as_both_lengths_within_the_limits(robot):
    # The elbow sits beside the straight line by 0.0825 m: it stretches when bent by
    # what it is seen under from shoulder and wrist.
    q = np.array([0.3, -0.2, 1.0, *POSTURE])
    q[BASE_JOINTS + 3] = -np.arctan(0.0825 / 0.316) - np.arctan(0.0825 / 0.384)
    assert (
        robot.joint_limits.lower[3] < q[BASE_JOINTS + 3] < robot.joint_limits.upper[3]
    )
    r_f = reduced_arm(robot.plant).r_f
    assert np.linalg.norm(p_ST(robot, q)) == pytest.approx(r_f, abs=SAME)


def test_shoulder_stays_put_whatever_the_arm_does(robot):
    p_BS = np.array(reduced_arm(robot.plant).p_BS)
    for q in random_states(robot):
        q[:BASE_JOINTS] = 0.0
        robot.set_state(q, 0 * q)
        np.testing.assert_allclose(robot.p_W("link2"), p_BS, atol=SAME)


def test_the_wrists_joints_do_not_move_tee(robot):
    for q in random_states(robot):
        before = p_ST(robot, q)
        q[-3:] = np.array(POSTURE)[-3:]
        np.testing.assert_allclose(p_ST(robot, q), before, atol=SAME)
        robot.set_state(q, np.append(np.zeros(7), [1.0, -2.0, 3.0]))
        np.testing.assert_allclose(robot.v_W("tee"), 0.0, atol=SAME)


def test_in_its_posture_it_is_far_from_every_border(robot):
    robot.set_state([0, 0, 0, *POSTURE], np.zeros(10))
    arm = reduced_arm(robot.plant)
    x, y, z = robot.p_W("tee")
    assert (x, y, z) == pytest.approx((0.5, 0.0, arm.l_0), abs=0.01)
    assert arm.r_f - x > 0.2
    assert (np.array(POSTURE) - robot.joint_limits.lower > 0.5).all()
    assert (robot.joint_limits.upper - np.array(POSTURE) > 0.5).all()
    assert robot.manipulability() > 0.05
    straight_down = robot.p_W("tool") - robot.p_W("link7")
    np.testing.assert_allclose(straight_down[:2], 0.0, atol=SAME)


def test_a_mount_without_height_is_refused():
    with pytest.raises(ParameterError, match=r"mount: 0\.0 is not valid"):
        checked(FrankaTiago(mount=0.0))


@pytest.mark.parametrize("seed", range(20))
def test_hand_in_closed_form_is_where_the_model_has_it(seed):
    model = RobotModel(FrankaTiago())
    arm = reduced_arm(model.plant)
    q = np.random.default_rng(seed).uniform(-2, 2, 7)
    model.set_state([0, 0, 0, *q], np.zeros(10))
    x, y, z = model.p_W("tool") - arm.p_BS
    c, s = np.cos(q[0]), np.sin(q[0])
    expected = (c * x + s * y, c * y - s * x, z)
    assert arm.p_SE(q.tolist()) == pytest.approx(expected, abs=1e-12)
