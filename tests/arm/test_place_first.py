"""Place before orientation: a wrist at its end turns the hand, and nothing stops."""

import dataclasses as dc
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.autodiffutils import InitializeAutoDiff

from drake_mobman.arm.damped_inverse import rates_within_limits
from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.limits import ArmStatus, JointLimits
from drake_mobman.arm.oriented_inverse import ORIENTATIONS, oriented_rates
from drake_mobman.arm.pseudo_inverse import Damping
from drake_mobman.decomposers.field import build_decomposer
from drake_mobman.decomposers.status import DecomposerStatus
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.franka_tiago import POSTURE, FrankaTiago
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.spatial import Spatial
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate
from drake_mobman.teleop.scripted import Held, Script

PERIOD = 0.01

EXACT = 1e-9
"""[m/s]: of the plant's own velocity of E, told by an inverse of a Jacobian."""

DIFFERENCE = 1e-6
"""[m/s]: of velocities by central differences, of joints that creep at 1e-7 rad/s."""

LOCKED = 2e-7
"""[rad/s]: what a joint at its end may do, by a slack of 1e-9 rad in a period."""

SLOW = 5e-3
"""[m/s]: the hand of which no direction is asked."""

CREEP = 0.01
"""[m/s]: a hand as slow as that has been slowed to a stop."""

NEAR = 0.3
"""[rad]: room of a joint in which a hand and its base may be slowed down, twice half
the way of 0.5 rad/s in the half second that the base takes to stop."""

MODEL = RobotModel(FrankaTiago())
LIMITS = MODEL.joint_limits
ARM = JacobianArm(MODEL.plant, POSTURE, Damping(level_gain=0.0))
"""Without a hand's own wish to come back level: what gives way, gives way."""

WRIST = (4, 5, 6)
AT = np.array(ARM.inverse((0.6, 0.3, -0.2)))


def test_the_wrist_is_what_does_not_move_its_centre():
    assert FrankaTiago().arm().wrist == WRIST
    assert Spatial(orientation="held").arm().wrist == (3, 4, 5)
    # In closed form the hand's orientation is given, and nothing can give way.
    assert Spatial().arm().wrist == Planar().arm().wrist == ()


def twist(q, rates, h=1e-6):
    """Returns V_BE (6,) by central differences of the plant's forward kinematics."""
    context = MODEL.plant.CreateDefaultContext()
    poses = []
    for dt in (h, -h):
        at = np.append(np.zeros(3), np.array(q) + dt * np.array(rates))
        MODEL.plant.SetPositions(context, at)
        poses.append(MODEL.plant.GetFrameByName("tool").CalcPoseInWorld(context))
    after, before = poses
    turn = (after.rotation() @ before.rotation().inverse()).ToAngleAxis()
    moved = after.translation() - before.translation()
    return np.append(turn.angle() * turn.axis(), moved) / (2 * h)


def told_velocity(q, command):
    """Returns what `arm_command` tells of E's velocity in B (3,) [m/s]."""
    l, psi, _ = ARM.ee_cylindrical(q)
    c, s = math.cos(psi), math.sin(psi)
    v_m, omega_m, v_z = command
    return [c * v_m - s * l * omega_m, s * v_m + c * l * omega_m, v_z]


def with_ends(lower, upper):
    return JointLimits(lower, upper, LIMITS.velocity, LIMITS.acceleration)


def rates_of(orientation, command, yaw_rate, limits, q=AT):
    if orientation == "reach":
        return rates_within_limits(ARM, q, command, limits, PERIOD)
    return oriented_rates(ARM, q, command, yaw_rate, 0.0, limits, PERIOD)[:2]


SPEED = st.floats(-0.1, 0.1)
COMMAND = st.tuples(SPEED, st.floats(-0.3, 0.3), SPEED)


@given(
    orientation=st.sampled_from(["reach", "apart"]),
    joint=st.sampled_from(WRIST),
    upper=st.booleans(),
    room=st.sampled_from([0.0, 1e-4, 1e-3, 0.01]),
    command=COMMAND,
    yaw_rate=st.floats(-0.4, 0.4),
)
def test_one_wrist_joint_near_its_end_does_not_slow_the_hand(
    orientation, joint, upper, room, command, yaw_rate
):
    ends = np.array(LIMITS.lower), np.array(LIMITS.upper)
    ends[upper][joint] = AT[joint] + (room if upper else -room)
    limits = with_ends(*ends)
    rates, status = rates_of(orientation, command, yaw_rate, limits)
    moved = twist(AT, rates)
    np.testing.assert_allclose(
        moved[3:], told_velocity(AT, command), rtol=0, atol=DIFFERENCE
    )
    outward = rates[joint] if upper else -rates[joint]
    assert outward * PERIOD <= room + 2e-9
    free, _ = rates_of(orientation, command, yaw_rate, LIMITS)
    gave = np.abs(np.subtract(rates, free)).max() > 1e-6
    assert gave == (ArmStatus.ORIENTATION in ArmStatus(int(status)))
    if gave:
        assert ArmStatus.JOINT_LIMIT in ArmStatus(int(status))


@given(
    orientation=st.sampled_from(["reach", "apart"]),
    ends=st.tuples(*[st.sampled_from([-1, 0, 1])] * 3),
    command=COMMAND,
    yaw_rate=st.floats(-0.4, 0.4),
)
def test_even_the_whole_wrist_at_its_ends_leaves_the_hand_its_place(
    orientation, ends, command, yaw_rate
):
    lower, upper = np.array(LIMITS.lower), np.array(LIMITS.upper)
    for joint, end in zip(WRIST, ends, strict=True):
        (lower if end < 0 else upper)[joint] = AT[joint] if end else upper[joint]
    rates, _ = rates_of(orientation, command, yaw_rate, with_ends(lower, upper))
    moved, told = twist(AT, rates)[3:], np.array(told_velocity(AT, command))
    np.testing.assert_allclose(moved, told, rtol=0, atol=DIFFERENCE)
    for joint, end in zip(WRIST, ends, strict=True):
        assert end * rates[joint] <= LOCKED


@given(command=COMMAND, upper=st.booleans())
def test_a_joint_that_place_needs_stops_the_hand_in_its_direction(command, upper):
    ends = np.array(LIMITS.lower), np.array(LIMITS.upper)
    ends[upper][3] = AT[3]  # The elbow.
    rates, status = rates_of("reach", command, 0.0, with_ends(*ends))
    moved, told = twist(AT, rates)[3:], np.array(told_velocity(AT, command))
    # Some part of it, from none to all.
    share = moved @ told / max(told @ told, 1e-12)
    assert -DIFFERENCE <= share <= 1 + DIFFERENCE or np.linalg.norm(told) < SLOW
    np.testing.assert_allclose(moved, share * told, rtol=0, atol=2e-6)
    stopped = np.linalg.norm(told) > SLOW and share < 0.9
    assert not stopped or ArmStatus.JOINT_LIMIT in ArmStatus(int(status))


@pytest.mark.parametrize("joint", WRIST)
def test_where_the_wrist_gives_way_the_derivatives_are_those_of_differences(joint):
    upper = np.array(LIMITS.upper)
    free, _ = rates_of("apart", (0.1, 0.2, 0.05), -0.3, LIMITS)
    lower = np.array(LIMITS.lower)
    (upper if free[joint] > 0 else lower)[joint] = AT[joint]
    limits = with_ends(lower, upper)

    def rates(x):
        return oriented_rates(ARM, AT, x[:3], x[3], 0.0, limits, PERIOD)[0]

    x = np.array([0.1, 0.2, 0.05, -0.3])
    found = rates(InitializeAutoDiff(x).ravel())
    slopes = [
        y.derivatives()
        if hasattr(y, "derivatives") and y.derivatives().size
        else np.zeros(4)
        for y in found
    ]
    h = 1e-6
    for i, one in enumerate(np.eye(4)):
        difference = np.subtract(rates(x + h * one), rates(x - h * one)) / (2 * h)
        np.testing.assert_allclose(np.array(slopes)[:, i], difference, atol=1e-5)


# --- The limiter ----------------------------------------------------------------------


@pytest.mark.parametrize("joint", WRIST)
def test_the_exact_law_reckons_with_a_wrist_that_gives_way(joint):
    scenario = load_scenario("kwon_franka")
    limiter = build_decomposer(scenario.decomposer, scenario.setup()).limiter
    at, command = ARM.ee_cylindrical(AT), (0.05, 0.1, 0.02)
    for sign in (1, -1):
        told = [sign * c for c in command]
        lower, upper = np.array(LIMITS.lower), np.array(LIMITS.upper)
        lower[joint] = upper[joint] = AT[joint]
        locked = dc.replace(limiter, joint_limits=with_ends(lower, upper))
        for factors in (
            locked.steady_scaling(AT, told, 0.0, 0.0),
            locked.present_scaling(AT, at, told, (0.0, 0.1), (0.0, 0.0, 0.1)),
        ):
            assert factors[DecomposerStatus.JOINT_LIMIT] == pytest.approx(1.0)
        lower[3] = upper[3] = AT[3]
        stiff = dc.replace(limiter, joint_limits=with_ends(lower, upper))
        factors = stiff.steady_scaling(AT, told, 0.0, 0.0)
        assert factors[DecomposerStatus.JOINT_LIMIT] < 1e-6


# --- The loop -------------------------------------------------------------------------


def run_of(orientation, segments, seconds, *overrides):
    kinematic = "fidelity=kinematic", f"robot.orientation={orientation}"
    wanted = [*kinematic, f"duration={seconds}", *overrides]
    scenario = load_scenario("kwon_franka", wanted)
    run = simulate(dc.replace(scenario, source=Script(segments=segments)))
    assert run.died == ""
    return run


def velocities(run):
    """Returns E's velocity in W by the plant, and as commanded, (N, 3) each [m/s]."""
    log, true, told = run.log, [], []
    model = RobotModel(run.scenario.robot)
    p_BS = run.scenario.robot.arm().p_BS
    for k in range(len(log["time"]) - 1):
        (x, y, theta), (v, _, omega) = log["base_pose"][k], log["base_velocity"][k]
        c, s = math.cos(theta), math.sin(theta)
        model.set_state(
            np.append(log["base_pose"][k], log["arm_position"][k]),
            np.append([c * v, s * v, omega], log["arm_velocity"][k]),
        )
        true.append(model.v_W("tool"))
        p_WS = [x + c * p_BS[0] - s * p_BS[1], y + s * p_BS[0] + c * p_BS[1]]
        p_x, p_y = model.p_W("tool")[:2] - p_WS
        v_c, omega_c, v_z = log["ee_command"][k]
        l = math.hypot(p_x, p_y)
        told.append([p_x / l * v_c - p_y * omega_c, p_y / l * v_c + p_x * omega_c, v_z])
    return np.array(true), np.array(told)


def check_place(run):
    """Checks that E does as told where no status says else, and else in its direction.

    And that no joint's end slows it but those of the joints that place it. Not where
    the arm is singular, and says so.
    """
    true, told = velocities(run)
    q = run.log["arm_position"]
    room = np.minimum(q - LIMITS.lower, LIMITS.upper - q)[:, : WRIST[0]].min(axis=1)
    regular = run.log["arm_status"][:, 0].astype(int) & ArmStatus.SINGULAR == 0
    slowed = run.log["decomposer_status"][:, 0].astype(int)
    slowed = slowed & DecomposerStatus.JOINT_LIMIT > 0
    # Towards a singularity, joints get fast, and brake from afar.
    fast = np.abs(run.log["arm_velocity"]).max(axis=1) > 0.5
    assert (room[slowed & regular & ~fast] < NEAR).all()
    regular = regular[:-1]
    free = run.log["decomposer_status"][:-1, 0] == 0
    error = np.linalg.norm(true - told, axis=1)
    assert error[regular & free].max() < EXACT
    cross = np.linalg.norm(np.cross(true, told), axis=1)
    along = np.sum(true * told, axis=1)
    # Slower, it is all but stopped, and goes where the last of the base's speed goes;
    # as it does while a base gets up to a speed to which the arm cannot give way.
    late = np.abs(run.log["base_command_smoothed"] - run.log["base_command"]).max(
        axis=1
    )[:-1]
    moving = regular & (np.linalg.norm(true, axis=1) > CREEP) & told.any(axis=1)
    moving &= late < SLOW
    assert (cross[moving] < 1e-6).all()
    assert (along[moving] > 0).all()


@pytest.mark.parametrize("orientation", ORIENTATIONS)
def test_one_joint_at_its_end_does_not_stop_the_robot(orientation):
    segments = [Held(12.0, v_c=0.05, omega_c=0.4), Held(3.0, v_c=0.1)]
    run = run_of(orientation, segments, 15.0)
    check_place(run)
    true, told = velocities(run)
    decomposed = run.log["decomposer_status"][:, 0].astype(int)
    assert not (decomposed & DecomposerStatus.JOINT_LIMIT).any()
    # The base takes a while to follow at each change.
    for steady in (slice(600, 1200), slice(1300, 1500)):
        np.testing.assert_allclose(true[steady], told[steady], rtol=0, atol=EXACT)
    status = run.log["arm_status"][:, 0].astype(int)
    if orientation == "held":  # Joint 7 is at its end from 5.5 s on, and is named.
        assert LIMITS.upper[6] - run.log["arm_position"][600:, 6].min() < 1e-3
        assert (status[600:-1] == ArmStatus.JOINT_LIMIT | ArmStatus.ORIENTATION).all()
    else:
        assert not status.any()


def random_history(rng, seconds):
    segments = []
    while seconds > 0:
        duration = min(seconds, float(rng.uniform(1.0, 8.0)))
        v_c, omega_c, v_z = rng.uniform(-1, 1, 3) * (0.2, 0.5, 0.1)
        v_c, omega_c = (v_c, omega_c) * rng.integers(0, 2, 2)
        v_z *= rng.integers(0, 2)
        segments.append(
            Held(duration, v_c=float(v_c), omega_c=float(omega_c), v_z=float(v_z))
        )
        seconds -= duration
    return segments


def check_never_stuck(orientation, seed, seconds):
    """Checks a random history, and that what leads inward moves the hand after it.

    It begins with a turn that brings a hand that is held in W to the wrist's end.
    """
    turn = 0.4 if seed % 2 else -0.4
    segments = [Held(8.0, v_c=0.02, omega_c=turn)]
    segments += random_history(np.random.default_rng(seed), seconds - 8.0)
    run = run_of(orientation, segments, seconds)
    check_place(run)
    # Along the coordinate that is farthest from the middle: an elbow that is low may
    # not leave the hand out and up at once.
    l, _, z = run.log["ee_cylindrical"][-1]
    out, down = 0.58 - l, -0.21 - z
    if abs(out) > abs(down):
        segments.append(Held(3.0, v_c=math.copysign(0.1, out)))
    else:
        segments.append(Held(3.0, v_z=math.copysign(0.05, down)))
    run = run_of(orientation, segments, seconds + 2.0)
    true, told = velocities(run)
    assert np.linalg.norm(true[-1]) > 0.9 * np.linalg.norm(told[-1])


@pytest.mark.parametrize("seed", [3, 6])
@pytest.mark.parametrize("orientation", ORIENTATIONS)
def test_after_any_history_what_leads_inward_moves_the_hand(orientation, seed):
    check_never_stuck(orientation, seed, 20.0)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 130))
@pytest.mark.parametrize("orientation", ORIENTATIONS)
def test_after_any_long_history_what_leads_inward_moves_the_hand(orientation, seed):
    check_never_stuck(orientation, seed, 90.0)
