"""Drake's differential inverse kinematics as a decomposer: map, limits and law."""

import dataclasses as dc
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.math import RotationMatrix
from scipy.optimize import linprog

from drake_mobman.analysis.metrics import metrics
from drake_mobman.analysis.motion import ee_motion
from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.limits import JointLimits
from drake_mobman.decomposers.diff_ik import (
    DiffIk,
    DiffIkDecomposer,
    EndEffectorModel,
    nonholonomic_map,
    rates_within_reach,
)
from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import RobotModel, RobotSetup
from drake_mobman.robots.franka_tiago import POSTURE, FrankaTiago
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.spatial import Spatial
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate

PERIOD = 0.01

SOLVED = 1e-5
"""[m/s], [rad/s]: the solver's tolerance, which is of gradients as large as 100."""

SLOPE = 1e-8
"""Of central differences: a step of 1e-5, squared, times third derivatives of up to
10; and rounding over the step."""

ROBOTS = {
    "planar": Planar(shoulder_ahead=0.2),
    "spatial": Spatial(shoulder_aside=0.2),
    "franka_tiago": FrankaTiago(mount_aside=0.1),
}
ARMS = {name: robot.arm() for name, robot in ROBOTS.items()}
BLOCKS = {
    name: DiffIkDecomposer(DiffIk(), RobotSetup.of(robot, PERIOD))
    for name, robot in ROBOTS.items()
}
every_robot = pytest.mark.parametrize("name", ROBOTS)

HANDS = {
    "planar": (1.1, 0.3, 0.0),
    "spatial": (1.2, 0.3, -0.2),
    "franka_tiago": (0.6, 0.2, -0.2),
}

SPEED = st.floats(-0.3, 0.3)


def at(name, hand=None):
    """Returns workspace and joint angles of a hand."""
    q = np.array(ARMS[name].inverse(hand or HANDS[name]))
    return np.array(ARMS[name].ee_cylindrical(q)), q


def solved(name, command, last, hand=None):
    """Returns rates, and the task that they are for: V and J of the rows that count."""
    block = BLOCKS[name]
    workspace, q = at(name, hand)
    V, J = block.task(np.array(command), workspace, q)
    rows = slice(3, 5) if name == "planar" else slice(0, 6)
    found = block.rates(np.array(command), workspace, q, last)
    return found, V[rows], J[rows]


def settled(name, command, ticks=60):
    """Returns rates of a command held for some time, the robot where it is."""
    last = np.zeros(BLOCKS[name].largest.size)
    for _ in range(ticks):
        (last, _), V, J = solved(name, command, last)
    return last, V, J


# The map.


@given(theta=st.floats(-7, 7), u=st.lists(SPEED, min_size=5, max_size=5))
def test_base_rolls_and_does_not_slide(theta, u):
    rates = nonholonomic_map(theta, 3) @ u
    sideways = math.cos(theta) * rates[1] - math.sin(theta) * rates[0]
    forward = math.cos(theta) * rates[0] + math.sin(theta) * rates[1]
    assert sideways == pytest.approx(0.0, abs=1e-15)
    assert forward == pytest.approx(u[0], abs=1e-15)
    np.testing.assert_array_equal(rates[2:], u[1:])


@every_robot
def test_jacobian_is_that_of_a_rolling_base(name):
    robot = ROBOTS[name]
    model = RobotModel(robot)
    n = ARMS[name].num_joints
    _, q = at(name)
    R_BE, J = EndEffectorModel(model.plant, n).pose_and_jacobian(q)
    context = model.plant.CreateDefaultContext()

    def pose(u, time):
        theta = time * u[1]
        arc = time * u[0] * np.sinc(theta / 2 / math.pi)
        base = [arc * math.cos(theta / 2), arc * math.sin(theta / 2), theta]
        model.plant.SetPositions(context, np.append(base, q + time * u[2:]))
        frame = model.plant.GetFrameByName("tool")
        return frame.CalcPoseInWorld(context)

    h = 1e-5
    np.testing.assert_allclose(R_BE, pose(np.zeros(2 + n), 0).rotation().matrix())
    for i, u in enumerate(np.eye(2 + n)):
        after, before = pose(u, h), pose(u, -h)
        v = (after.translation() - before.translation()) / (2 * h)
        turn = RotationMatrix(after.rotation() @ before.rotation().inverse())
        turn = turn.ToAngleAxis()
        w = turn.angle() * turn.axis() / (2 * h)
        expected = np.concatenate([w, v])
        np.testing.assert_allclose(J[:, i], expected, rtol=0, atol=SLOPE)


# The limits.


@st.composite
def moving_joints(draw):
    n = draw(st.integers(1, 3))
    each = {"min_size": n, "max_size": n}
    largest = np.array(
        draw(st.lists(st.floats(0.1, 3), min_size=2 + n, max_size=2 + n))
    )
    share = st.lists(st.floats(-1, 1), min_size=2 + n, max_size=2 + n)
    acceleration = st.one_of(st.floats(0.1, 20), st.just(math.inf))
    accelerations = draw(st.lists(acceleration, min_size=2 + n, max_size=2 + n))
    limits = JointLimits([-1.0] * n, [1.0] * n, largest[2:])
    q = np.array(draw(st.lists(st.floats(-1.2, 1.2), **each)))
    return draw(share) * largest, q, largest, np.array(accelerations), limits


@given(case=moving_joints())
def test_there_are_always_rates_within_reach_and_within_limits(case):
    last, q, largest, accelerations, limits = case
    lowest, highest = rates_within_reach(
        last, q, largest, accelerations, limits, PERIOD
    )
    assert (lowest <= highest).all()
    assert (np.abs(lowest) <= largest).all()
    assert (np.abs(highest) <= largest).all()
    step = accelerations * PERIOD * (1 + 1e-9) + 1e-12
    assert (highest - last <= step).all()
    assert (last - lowest <= step).all()


def test_joint_can_always_brake_before_the_end_of_its_range():
    limits = JointLimits([-1.0], [1.0], [2.0])
    largest, accelerations = np.array([1.0, 1.0, 2.0]), np.array([1.0, 1.0, 5.0])
    last, q = np.zeros(3), np.zeros(1)
    fastest = 0.0
    for _ in range(300):
        _, last = rates_within_reach(last, q, largest, accelerations, limits, PERIOD)
        q = q + PERIOD * last[2:]
        fastest = max(fastest, last[2])
        assert q[0] <= 1.0 + 1e-8
    assert q[0] == pytest.approx(1.0, abs=1e-6)
    assert fastest == pytest.approx(2.0)


@every_robot
@given(held=st.lists(st.tuples(SPEED, SPEED, SPEED), min_size=1, max_size=3))
def test_held_commands_break_no_limit(name, held):
    block = BLOCKS[name]
    n = ARMS[name].num_joints
    _, q = at(name)
    last = np.zeros(2 + n)
    for command in held:
        for _ in range(15):
            workspace = np.array(ARMS[name].ee_cylindrical(q))
            found = block.rates(np.array(command), workspace, q, last)
            if found is None:  # The command has jumped: the block would brake.
                last = 0.8 * last
                continue
            u, _ = found
            assert (np.abs(u) <= block.largest + 1e-6).all()
            assert (np.abs(u - last) <= block.accelerations * PERIOD + 1e-6).all()
            q = q + PERIOD * u[2:]
            assert (q <= np.array(block.limits.upper) + 1e-6).all()
            assert (q >= np.array(block.limits.lower) - 1e-6).all()
            last = u


# The law.


@every_robot
def test_where_no_limit_binds_the_rest_goes_to_the_posture(name):
    command = (0.1, -0.1, 0.0 if name == "planar" else 0.05)
    u, V, J = settled(name, command)
    # Worked out apart: what makes V, and in the null space of J what is wanted of u.
    arm = ARMS[name]
    _, q = at(name)
    if isinstance(arm, JacobianArm):
        posture = np.array(POSTURE)
    else:
        posture = np.array(arm.inverse((1.0, 0.0, 0.0)))
    wanted = np.append(np.zeros(2), DiffIk().centering * (posture - q))
    J_plus = np.linalg.pinv(J)
    expected = J_plus @ V + wanted - J_plus @ (J @ wanted)
    np.testing.assert_allclose(u, expected, rtol=0, atol=SOLVED)


@every_robot
def test_hand_makes_its_command_along_across_and_up_and_keeps_level(name):
    v_c, omega_c, v_z = command = (0.1, -0.1, 0.0 if name == "planar" else 0.05)
    u, _, _ = settled(name, command)
    (l, psi, _), q = at(name)
    _, J = BLOCKS[name].end_effector.pose_and_jacobian(q)
    V_WE = J @ u
    c, s = math.cos(psi), math.sin(psi)
    along, across = c * V_WE[3] + s * V_WE[4], c * V_WE[4] - s * V_WE[3]
    np.testing.assert_allclose(
        [along, across, V_WE[5]], [v_c, l * omega_c, v_z], rtol=0, atol=1e-7
    )
    if name != "planar":
        np.testing.assert_allclose(V_WE[:3], [0, 0, omega_c], rtol=0, atol=1e-7)


def test_tilted_hand_turns_back():
    name = "franka_tiago"
    block = BLOCKS[name]
    _, q = at(name)
    q[5] += 0.1  # The wrist nods.
    workspace = np.array(ARMS[name].ee_cylindrical(q))
    last = np.zeros(9)
    for _ in range(60):
        last, _ = block.rates(np.zeros(3), workspace, q, last)
    _, J = block.end_effector.pose_and_jacobian(q)
    V_WE = J @ last
    assert np.linalg.norm(V_WE[:3]) == pytest.approx(math.sin(0.1), abs=1e-4)
    np.testing.assert_allclose(V_WE[3:], 0.0, atol=1e-6)
    before, _ = block.end_effector.pose_and_jacobian(q)
    after, _ = block.end_effector.pose_and_jacobian(q + PERIOD * last[2:])
    level, _ = block.end_effector.pose_and_jacobian(at(name)[1])

    def tilt(R):
        return RotationMatrix(R @ level.T).ToAngleAxis().angle()

    assert tilt(after) < tilt(before)


@every_robot
def test_hand_that_cannot_go_so_fast_keeps_its_direction(name):
    command = (0.3, 0.2, 0.0 if name == "planar" else 0.2)
    last = np.zeros(BLOCKS[name].largest.size)
    block = BLOCKS[name]
    workspace, q = at(name)
    slow = DiffIkDecomposer(
        dc.replace(DiffIk(), max_speed=0.01, max_yaw_rate=0.01),
        RobotSetup.of(ROBOTS[name], PERIOD),
    )
    slow.largest[2:] = 0.05  # Of the joints, too.
    V, J = block.task(np.array(command), workspace, q)
    rows = slice(3, 5) if name == "planar" else slice(0, 6)
    V, J = V[rows], J[rows]
    u, _ = slow.rates(np.array(command), workspace, q, last)
    alpha = V @ (J @ u) / (V @ V)
    assert 0.01 < alpha < 0.9
    np.testing.assert_allclose(J @ u, alpha * V, rtol=0, atol=1e-6)
    # Nor could it go much faster: a linear program of another hand says how fast.
    lowest, highest = rates_within_reach(
        last, q, slow.largest, slow.accelerations, slow.limits, PERIOD
    )
    best = linprog(
        np.append(np.zeros(len(u)), -1.0),
        A_eq=np.column_stack([J, -V]),
        b_eq=np.zeros(len(V)),
        bounds=[*zip(lowest, highest, strict=True), (0, 1)],
    )
    assert alpha == pytest.approx(-best.fun, rel=0.05)


@every_robot
def test_arm_comes_back_to_its_posture_under_a_still_hand(name):
    hand = {"planar": (1.4, 0.5, 0.0), "spatial": (1.4, 0.5, 0.0)}.get(
        name, (0.65, 0.4, -0.2)
    )
    block = BLOCKS[name]
    workspace, q = at(name, hand)
    last, base = np.zeros(2 + len(q)), np.zeros(3)

    def hand_in_world():
        l, psi, z = ARMS[name].ee_cylindrical(q)
        d, e, _ = ARMS[name].p_BS
        x, y, theta = base
        c, s = math.cos(theta), math.sin(theta)
        return np.array(
            [
                x + d * c - e * s + l * math.cos(theta + psi),
                y + d * s + e * c + l * math.sin(theta + psi),
                z,
            ]
        )

    start = hand_in_world()
    for _ in range(600):
        workspace = np.array(ARMS[name].ee_cylindrical(q))
        last, _ = block.rates(np.zeros(3), workspace, q, last)
        step = PERIOD * nonholonomic_map(base[2], len(q)) @ last
        base, q = base + step[:3], q + step[3:]
    # Euler's steps of joints that turn by some tenths of a radian.
    np.testing.assert_allclose(hand_in_world(), start, rtol=0, atol=0.01)
    assert abs(workspace[1]) < 0.05
    assert base[2] > 0.3


def test_posture_of_an_arm_that_reaches_no_middle_is_the_nearest():
    DiffIkDecomposer(
        DiffIk(), RobotSetup.of(Planar(upper_link=1.0, lower_link=0.2), PERIOD)
    )


def test_jump_that_takes_more_than_can_be_had_has_no_solution():
    # The hand is not to turn out of its direction while it brakes.
    name = "franka_tiago"
    last, _, _ = settled(name, (0.2, 0.0, 0.0))
    found, _, _ = solved(name, (-0.2, 0.0, 0.0), last)
    assert found is None


@every_robot
def test_hands_that_start_from_rest_anywhere_are_solved(name):
    rng = np.random.default_rng(2)
    reach = (0.45, 0.68) if name == "franka_tiago" else (0.5, 1.7)
    last = np.zeros(BLOCKS[name].largest.size)
    for _ in range(60):
        hand = (rng.uniform(*reach), rng.uniform(-0.6, 0.6), rng.uniform(-0.3, 0.0))
        command = rng.uniform(-0.4, 0.4, 3)
        found, V, J = solved(name, command, last, hand)
        assert found is not None
        u, _ = found
        alpha = V @ (J @ u) / (V @ V)
        np.testing.assert_allclose(J @ u, alpha * V, rtol=0, atol=1e-6)


def test_solver_says_nothing(capfd):
    for name in ROBOTS:
        for command in [(0, 0, 0), (0.01, 0, 0), (0.4, 0.4, 0), (40.0, 0, 0)]:
            solved(name, command, np.zeros(BLOCKS[name].largest.size))
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("params", "says"),
    [
        (
            {"max_speed": 0.0},
            "max_speed: 0.0 is not valid; must be within [0.001, 10] m/s",
        ),
        ({"max_acceleration": -1.0}, "max_acceleration: -1.0 is not valid; must be"),
        (
            {"centering": -0.1},
            "centering: -0.1 is not valid; must be within [0, 1000] 1/s",
        ),
        ({"stop_time": -0.1}, "stop_time: -0.1 is not valid; must be within [0, 60] s"),
        (
            {"tolerance": 0.0},
            "tolerance: 0.0 is not valid; must be within [1e-12, 0.01]",
        ),
        ({"level_gain": math.nan}, "level_gain: nan is not valid; must be a finite"),
    ],
)
def test_parameters_that_are_none_are_refused(params, says):
    with pytest.raises(ParameterError) as refusal:
        DiffIkDecomposer(
            dc.replace(DiffIk(), **params), RobotSetup.of(Planar(), PERIOD)
        )
    assert says in str(refusal.value)


# In the loop.


def run_of(name, *overrides):
    scenario = load_scenario(name, overrides)
    return simulate(
        scenario,
        decomposer=lambda: DiffIkDecomposer(DiffIk(), scenario.setup()),
    )


@pytest.mark.parametrize("name", ["kwon_arbitrary", "kwon_spatial"])
def test_hand_does_as_commanded_at_kinematic(name):
    run = run_of(name)
    assert run.died == ""
    assert np.count_nonzero(run.log["decomposer_status"]) == 0
    found = metrics(run)
    assert found["ee_error_rms"] < 1e-6
    assert found["lateral_slip_max"] < 1e-9
    # Centering keeps the arm where it was told to work.
    assert found["workspace_excess_max"] == {"l": 0.0, "psi": 0.0}


def test_hand_does_as_commanded_with_masses():
    run = run_of("kwon_franka", "duration=8.0")
    assert run.died == ""
    assert np.count_nonzero(run.log["decomposer_status"]) == 0
    error = np.linalg.norm(ee_motion(run).error, axis=1)
    assert np.sqrt(np.mean(error**2)) < 0.005
    assert np.abs(run.log["base_command_smoothed"][:, 0]).max() > 0.1
