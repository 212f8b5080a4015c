"""psi of an arm that is mounted turned on its base, or pulled across its back."""

import dataclasses as dc
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_mobman.analysis.metrics import metrics
from drake_mobman.arm.end_effector_sensor import unwrapped
from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.decomposers.blending import Blending
from drake_mobman.parameters import checked
from drake_mobman.robot_model import RobotModel, WorkspaceLimits
from drake_mobman.robots.defaults import Start
from drake_mobman.robots.franka_tiago import POSTURE, FrankaTiago, reduced_arm
from drake_mobman.robots.kinematic import Kinematic
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate
from drake_mobman.teleop.scripted import Held, Script

SAME = 1e-12
"""Two computations of one angle or point: a product of a dozen rotations."""

YAWS = (math.pi, -math.pi, 0.5 * math.pi, -2.0, 0.3)


def arms(yaw):
    """Returns the arm with and without its closed form."""
    robot = FrankaTiago(mount_ahead=0.05, mount_aside=-0.1, mount_yaw=yaw)
    return robot.arm(), JacobianArm(RobotModel(robot).plant, POSTURE)


ARMS = {yaw: arms(yaw) for yaw in YAWS}
MODELS = {yaw: RobotModel(FrankaTiago(0.1, 0.05, -0.1, yaw)) for yaw in YAWS}


@pytest.mark.parametrize("yaw", YAWS)
@pytest.mark.parametrize("form", [0, 1], ids=["closed form", "model"])
def test_psi_goes_on_wherever_the_first_joint_turns_the_arm(yaw, form):
    arm = ARMS[yaw][form]
    q = np.add(POSTURE, [0, 0.1, 0.2, 0, 0.1, 0, 0])
    at_zero = arm.ee_cylindrical(q)[1]
    for q[0] in np.linspace(-2.89, 2.89, 41):
        assert arm.ee_cylindrical(q)[1] == pytest.approx(at_zero + q[0], abs=SAME)


@given(off=st.lists(st.floats(-0.7, 0.7), min_size=6, max_size=6))
def test_psi_has_no_jump_at_the_back_of_an_arm_mounted_backwards(off):
    """It is near pi there, not now pi and now -pi, whatever the joints make of it."""
    for arm in ARMS[math.pi]:
        q = np.array(POSTURE)
        q[1:] += off
        l, psi, _ = arm.ee_cylindrical(q)
        if l > 0.3:
            assert abs(psi - math.pi) < 1.5


@pytest.mark.parametrize("yaw", YAWS)
@given(q=st.lists(st.floats(-2.0, 2.0), min_size=7, max_size=7))
def test_hand_and_wrist_are_where_the_plant_has_them(yaw, q):
    model = MODELS[yaw]
    model.set_state([0.0, 0.0, 0.0, *q], np.zeros(10))
    for arm in ARMS[yaw]:
        l, psi, z = arm.ee_cylindrical(q)
        d, e, l_0 = arm.p_BS
        found = d + l * math.cos(psi), e + l * math.sin(psi), l_0 + z
        np.testing.assert_allclose(found, model.p_W("tool"), rtol=0, atol=SAME)
        np.testing.assert_allclose(arm.p_BT(q), model.p_W("tee"), rtol=0, atol=SAME)


@pytest.mark.parametrize("yaw", YAWS)
def test_lengths_are_the_same_however_it_is_mounted(yaw):
    found, plain = (
        reduced_arm(m.plant) for m in (MODELS[yaw], RobotModel(FrankaTiago()))
    )
    for name in ("elbow", "wrist", "tool"):
        np.testing.assert_allclose(
            getattr(found, name), getattr(plain, name), atol=SAME
        )
    assert found.r_f == pytest.approx(plain.r_f)


@pytest.mark.parametrize("yaw", YAWS)
@pytest.mark.parametrize("form", [0, 1], ids=["closed form", "model"])
def test_inverse_brings_the_hand_to_the_psi_that_is_told(yaw, form):
    arm = ARMS[yaw][form]
    middle = arm.ee_cylindrical(POSTURE)[1]
    for psi in middle + np.linspace(-2.5, 2.5, 7):
        hand = (0.55, psi, -0.2)
        assert arm.ee_cylindrical(arm.inverse(hand)) == pytest.approx(hand, abs=1e-8)


def backwards(fidelity):
    """Returns a run with the arm mounted backwards, its hand led past the back."""
    scenario = load_scenario("kwon_franka")
    turn = [(0.5, 0.0), (2.0, 0.15), (4.0, -0.15), (2.0, 0.15)]
    scenario = dc.replace(
        scenario,
        duration=8.0,
        fidelity=fidelity or scenario.fidelity,
        robot=FrankaTiago(mount_yaw=math.pi),
        start=Start(l=0.58, psi=math.pi, z=-0.21),
        workspace=WorkspaceLimits(0.48, 0.66, math.pi - 0.5, math.pi + 0.5),
        decomposer=Blending(alpha=60.0),
        source=Script(segments=[Held(t, omega_c=omega_c) for t, omega_c in turn]),
    )
    run = simulate(checked(scenario))
    assert run.died == ""
    return run


@pytest.mark.parametrize("fidelity", [None, Kinematic()], ids=["servo", "kinematic"])
def test_hand_led_past_the_back_of_the_base_makes_no_jump(fidelity):
    run = backwards(fidelity)
    psi = run.log["ee_cylindrical"][:, 1]
    assert psi.min() < math.pi - 0.2 < math.pi + 0.2 < psi.max()
    assert np.abs(np.diff(psi)).max() < 0.01
    found = metrics(run)
    assert found["workspace_excess_max"]["psi"] == 0.0
    # Swept at 0.15 rad/s, base at rest, the hand has no error but a step's and a lag's.
    assert found["ee_error_rms"] < 3e-3


# An arm that is free, and pulled.


@given(
    steps=st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=30),
    start=st.floats(-6.0, 6.0),
)
def test_an_angle_that_is_told_by_direction_alone_goes_on(steps, start):
    angles = start + np.cumsum(steps)
    last = start
    for angle in angles:
        last = unwrapped(math.atan2(math.sin(angle), math.cos(angle)), last)
        assert last == pytest.approx(angle, abs=1e-9)


@pytest.mark.parametrize("compiled", ["compiled=false", "compiled=true"])
def test_free_arm_pulled_over_its_back_has_a_psi_without_a_jump(compiled):
    """Over the shoulder, then to and fro behind it, with the base at rest."""
    places = [
        (0.0, 0.58, 0.0, 0.523),
        (2.0, 0.3, 0.05, 1.1),
        (4.0, -0.2, 0.06, 1.2),
        (5.5, -0.4, 0.05, 1.1),
        (7.0, -0.4, -0.2, 1.1),
        (9.0, -0.4, 0.2, 1.1),
        (11.0, -0.4, -0.2, 1.1),
    ]
    path = [dict(zip(("time", "x", "y", "z"), at, strict=True)) for at in places]
    still = "field={K_f: 0.0, K_r: 0.0, K_omega: 0.0}"
    scenario = load_scenario(
        "petric_guided",
        [f"hand.path={path}", "hand.releases=[]", still, "duration=11", compiled],
    )
    run = simulate(scenario)
    assert run.died == ""
    psi = run.log["ee_cylindrical"][:, 1]
    arm = scenario.robot.arm()
    by_joints = np.array([arm.ee_cylindrical(q)[1] for q in run.log["arm_position"]])
    # The joints alone tell a turn more or less, and nothing else.
    assert np.abs(np.diff(by_joints)).max() > 6.0
    off = (psi - by_joints) / (2 * math.pi)
    np.testing.assert_allclose(off, np.round(off), atol=SAME)
    assert np.abs(np.diff(psi)).max() < 0.3
    assert psi.min() == pytest.approx(0.0, abs=0.01)
    assert psi.max() > math.pi + 0.3


@pytest.mark.parametrize("yaw", [math.pi, -math.pi, 2.5])
@pytest.mark.parametrize("turned", [-2.8, -1.0, 1.0, 2.8])
def test_psi_at_the_posture_is_the_hands_bearing_however_far_its_joint_is_turned(
    yaw, turned
):
    """By a turn more, the base would turn towards a hand that is ahead of it."""
    model = RobotModel(FrankaTiago(mount_yaw=yaw))
    posture = [turned, *POSTURE[1:]]
    arm = JacobianArm(model.plant, posture)
    model.set_state([0.0, 0.0, 0.0, *posture], np.zeros(10))
    x, y, _ = np.subtract(model.p_W("tool"), arm.p_BS)
    assert arm.ee_cylindrical(posture)[1] == pytest.approx(math.atan2(y, x), abs=1e-9)
    for q0 in np.linspace(-2.89, 2.89, 21):
        psi = arm.ee_cylindrical([q0, *POSTURE[1:]])[1]
        assert psi == pytest.approx(math.atan2(y, x) + q0 - turned, abs=1e-9)
