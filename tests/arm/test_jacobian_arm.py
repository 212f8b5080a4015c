"""Any arm by its Jacobian: kinematics, rates of a level hand, posture, inverse."""

import dataclasses as dc
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.autodiffutils import InitializeAutoDiff

from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.orientation import orientation_error
from drake_mobman.arm.pseudo_inverse import Damping, damped_pseudo_inverse
from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import BASE_JOINTS, RobotModel
from drake_mobman.robots.franka_tiago import POSTURE, FrankaTiago, reduced_arm
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.spatial import Spatial

SAME = 1e-12
"""A chain of eight transforms, each rounded, in another order."""

RATES = 1e-9
"""[m/s], [rad/s]: what keeps the inverse finite, 1e-14 over w^2 of 4e-4, times 0.4."""

CONVERGED = 1e-12
"""[m], [rad]: `inverse` goes on until rounding stops it."""

SLOPE = 1e-6
"""Of central differences: a step of 1e-6, squared, times a third derivative; and
rounding over the step. Relative to slopes of up to 1e2 near a singularity."""

TOP_GAIN = 1.05
"""Of damped rates times the threshold: s / (s^2 + (1 - s^2)^2) is at most 1.04."""

STRETCHED = -math.atan(0.0825 / 0.316) - math.atan(0.0825 / 0.384)
"""Joint 4 where shoulder, elbow and wrist centre are in line, by the maker's table."""

MODEL = RobotModel(FrankaTiago())
ARM = FrankaTiago().arm()
BLIND = JacobianArm(MODEL.plant, POSTURE, Damping(level_gain=0.0))
"""The same arm, which does not see that its hand is tilted."""

INSIDE = [
    (l, z)
    for l, low, high in (
        (0.3, -0.7, 0.4),
        (0.4, -0.7, 0.4),
        (0.5, -0.7, 0.3),
        (0.6, -0.6, 0.2),
        (0.7, -0.5, 0.1),
        (0.75, -0.4, 0.0),
    )
    for z in np.arange(low, high + 0.01, 0.1)
]
"""l, z that the level hand reaches, the border 5 cm away or less."""

LEVEL = st.tuples(st.sampled_from(INSIDE), st.floats(-2.8, 2.8)).map(
    lambda drawn: ARM.inverse((drawn[0][0], drawn[1], drawn[0][1]))
)
SPEED = st.floats(-0.4, 0.4)
COMMAND = st.tuples(SPEED, SPEED, SPEED)


def random_angles(count, seed=0):
    """Yields joint angles within the limits, the hand turned anyhow."""
    rng = np.random.default_rng(seed)
    yield from rng.uniform(
        MODEL.joint_limits.lower, MODEL.joint_limits.upper, (count, 7)
    )


def regular_angles(count, arm=ARM):
    """Yields such angles where nothing is damped."""
    many = random_angles(4 * count, seed=1)
    regular = [q for q in many if not arm.is_near_singular(q)]
    assert len(regular) >= count
    yield from regular[:count]


def V_BE(q, rates):
    """Returns the tool's velocity in B (6,), as the plant has it, the base at rest."""
    plant = MODEL.plant
    context = plant.CreateDefaultContext()
    still = np.zeros(BASE_JOINTS)
    plant.SetPositions(context, np.append(still, q))
    plant.SetVelocities(context, np.append(still, rates))
    E = plant.GetFrameByName("tool")
    return E.CalcSpatialVelocityInWorld(context).get_coeffs()


def R_BE(q):
    plant = MODEL.plant
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, np.append(np.zeros(BASE_JOINTS), q))
    return plant.GetFrameByName("tool").CalcPoseInWorld(context).rotation().matrix()


def commanded_V_BE(q, command):
    """Returns V_BE (6,) of a hand that makes `command` and turns with its reach."""
    l, psi, _ = ARM.ee_cylindrical(q)
    v_m, omega_m, v_z = command
    along, across = np.array([np.cos(psi), np.sin(psi)]), [-np.sin(psi), np.cos(psi)]
    level = v_m * along + l * omega_m * np.array(across)
    return np.array([0, 0, omega_m, *level, v_z])


def tilt_of(q):
    """Returns how far the hand is turned from level [rad], for small angles."""
    return np.linalg.norm(
        orientation_error(R_BE(q), R_z(ARM.ee_cylindrical(q)[1]) @ R_BE(POSTURE))
    )


def R_z(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def swivelled(angle):
    """Returns the posture with the elbow swung out, the hand where it was."""
    q = np.array(POSTURE)
    for _ in range(200):
        rates = np.linalg.svd(jacobian(q))[2][-1]
        q = q + angle / 200 * rates * np.sign(rates[2])
    return q


def jacobian(q):
    return np.transpose([V_BE(q, unit) for unit in np.eye(7)])


# Kinematics.


def test_workspace_and_tee_are_where_the_plant_has_them():
    rng = np.random.default_rng(2)
    for q in random_angles(50):
        base = rng.uniform(-3, 3, BASE_JOINTS)
        MODEL.set_state(np.append(base, q), np.zeros(BASE_JOINTS + 7))
        c, s = np.cos(base[2]), np.sin(base[2])
        R_BW = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        p_BT, p_BE = (R_BW @ (MODEL.p_W(f) - [*base[:2], 0]) for f in ("tee", "tool"))
        np.testing.assert_allclose(ARM.p_BT(q), p_BT, rtol=0, atol=SAME)
        l, psi, z = ARM.ee_cylindrical(q)
        p_BE_ARM = ARM.p_BS + np.array([l * np.cos(psi), l * np.sin(psi), z])
        np.testing.assert_allclose(p_BE_ARM, p_BE, rtol=0, atol=SAME)
        assert l >= 0


def test_shoulder_is_the_models():
    assert ARM.p_BS == pytest.approx(reduced_arm(MODEL.plant).p_BS, abs=SAME)
    spatial = Spatial()
    arm = JacobianArm(RobotModel(spatial).plant, spatial.arm().inverse((1.3, 0, 0)))
    assert arm.p_BS == pytest.approx(spatial.arm().p_BS, abs=SAME)


def test_psi_goes_on_where_the_arm_turns_past_the_back():
    # The hand is swung to the left, so that it passes pi before the first joint ends.
    q = np.add(POSTURE, [0, 0, 0.8, 0, 0, 0, 0])
    ahead = ARM.ee_cylindrical(q)[1]
    assert ahead > 0.4
    for q[0] in np.linspace(-2.89, 2.89, 20):
        assert ARM.ee_cylindrical(q)[1] == pytest.approx(q[0] + ahead, abs=SAME)


# Rates.


@given(command=COMMAND)
def test_any_hand_makes_the_rates_commanded_and_turns_with_its_reach(command):
    for q in regular_angles(5, BLIND):
        rates = BLIND.rates(q, command)
        expected = commanded_V_BE(q, command)
        np.testing.assert_allclose(V_BE(q, rates), expected, rtol=0, atol=RATES)


@given(q=LEVEL, command=COMMAND)
def test_workspace_changes_at_the_rates_commanded(q, command):
    rates, h = np.array(ARM.rates(q, command)), 1e-6
    after, before = (np.array(ARM.ee_cylindrical(q + dt * rates)) for dt in (h, -h))
    np.testing.assert_allclose((after - before) / (2 * h), command, rtol=0, atol=1e-8)


@given(q=LEVEL, command=COMMAND)
def test_a_level_hand_stays_level(q, command):
    expected = commanded_V_BE(q, command)
    found = V_BE(q, ARM.rates(q, command))
    np.testing.assert_allclose(found, expected, rtol=0, atol=RATES)


@given(
    held=st.lists(
        st.tuples(st.floats(-0.1, 0.1), st.floats(-0.4, 0.4), st.floats(-0.1, 0.1)),
        min_size=1,
        max_size=3,
    )
)
def test_euler_steps_do_not_tilt_the_hand(held):
    """The arm stays in its plane, where pitch is linear in the joints."""
    q = np.array(POSTURE)
    for command in held:
        for _ in range(50):
            q = q + 0.01 * np.array(BLIND.rates(q, command))
    assert tilt_of(q) < 1e-10


@given(q=LEVEL, omega_m=SPEED)
def test_in_its_plane_the_arm_turns_by_its_first_joint_alone(q, omega_m):
    hand, _, _ = ARM.ee_and_posture_rates(q, (0.0, omega_m, 0.0))
    np.testing.assert_allclose(hand, [omega_m] + [0.0] * 6, rtol=0, atol=RATES)


@given(command=COMMAND, turn=st.floats(-2.0, 2.0))
def test_the_arm_moves_alike_in_all_directions(command, turn):
    for q in regular_angles(5):
        there = q.copy()
        there[0] += turn
        expected = ARM.rates(q, command)
        # Near a singularity, rounding is multiplied by 1 / w^2.
        np.testing.assert_allclose(ARM.rates(there, command), expected, atol=1e-10)


def test_a_tilted_hand_is_brought_back_while_it_moves():
    q = np.add(POSTURE, [0, 0, 0, 0, 0.1, -0.1, 0.1])
    start, tilted = np.array(ARM.ee_cylindrical(q)), tilt_of(q)
    assert tilted > 0.1
    command, period = np.array([0.01, 0.05, 0.02]), 0.01
    for _ in range(500):
        q = q + period * np.array(ARM.rates(q, command))
    # By a first-order lag of 1 s, for 5 s; Euler steps of 1 % are worth 3 %.
    assert tilt_of(q) < 1.1 * math.exp(-5) * tilted
    np.testing.assert_allclose(ARM.ee_cylindrical(q), start + 5 * command, atol=1e-3)


# Turned apart from the reach.


@given(command=COMMAND, yaw=st.floats(-3.0, 3.0))
def test_a_hand_turned_apart_is_moved_and_turned_by_parts_of_its_rates(command, yaw):
    for q in regular_angles(5):
        hand, turns, by_level, posture, damped = ARM.oriented_parts(q, command, yaw)
        turn, home = np.array(turns)[:, 2], np.add(by_level, posture)
        assert not damped
        expected = commanded_V_BE(q, command)
        np.testing.assert_allclose(V_BE(q, hand), expected, rtol=0, atol=RATES)
        by_turn = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
        np.testing.assert_allclose(V_BE(q, turn), by_turn, rtol=0, atol=RATES)
        level = R_z(yaw) @ R_BE(POSTURE)
        by_home = np.append(
            ARM.damping.level_gain * orientation_error(R_BE(q), level), np.zeros(3)
        )
        np.testing.assert_allclose(V_BE(q, home), by_home, rtol=0, atol=RATES)


@given(q=LEVEL, apart=st.floats(-1.5, 1.5))
def test_yaw_is_that_of_the_reach_and_what_the_hand_is_turned_beside_it(q, apart):
    psi = ARM.ee_cylindrical(q)[1]
    assert ARM.yaw(q) == pytest.approx(psi, abs=1e-9)
    # The last joint counts downwards, as the hand points there.
    turned = np.append(q[:6], q[6] - apart)
    off = ARM.yaw(turned) - psi - apart
    assert math.remainder(off, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


# Posture.


@given(command=COMMAND)
def test_the_posture_does_not_move_the_hand(command):
    for q in regular_angles(5):
        _, posture, _ = ARM.ee_and_posture_rates(q, command)
        assert np.linalg.norm(posture) > 1e-3
        np.testing.assert_allclose(V_BE(q, posture), 0.0, rtol=0, atol=RATES)


@pytest.mark.parametrize("angle", [-0.6, 0.3, 0.9])
@pytest.mark.parametrize("psi", [0.0, 1.2])
def test_the_elbow_comes_back_to_the_posture(angle, psi):
    q, posture = swivelled(angle), np.array(POSTURE)
    q[0] += psi
    posture[0] += psi
    start, far = ARM.ee_cylindrical(q), np.linalg.norm(q - posture)
    assert far > 0.2
    for _ in range(800):
        _, rates, _ = ARM.ee_and_posture_rates(q, (0.0, 0.0, 0.0))
        assert np.linalg.norm(rates) <= ARM.damping.posture_speed * (1 + SAME)
        now = q + 0.01 * np.array(ARM.rates(q, (0.0, 0.0, 0.0)))
        # Here, the first joint's place is told from the hand, which stays.
        assert np.linalg.norm(now - posture) <= np.linalg.norm(q - posture) + 1e-6
        q = now
    assert np.linalg.norm(q - posture) < 0.02
    # What Euler steps along a curve leave: (0.5 x 0.01)^2 a step, half a metre away.
    np.testing.assert_allclose(ARM.ee_cylindrical(q), start, rtol=0, atol=5e-3)


def test_without_gains_the_arm_does_nothing_unless_told():
    damping = Damping(posture_gain=0.0, level_gain=0.0)
    arm = JacobianArm(MODEL.plant, POSTURE, damping)
    for q in random_angles(5):
        assert arm.rates(q, (0.0, 0.0, 0.0)) == [0.0] * 7


# Singularities.


def stretched():
    """Yields angles at and near singularities, within the limits or not."""
    for bend in (0.0, -1e-9, -1e-4, -0.01, -0.1):
        for shoulder in (-0.5, 0.0, 0.4):
            elbow = STRETCHED + bend
            yield np.array([0.3, shoulder, 0.0, elbow, 0.0, 2.0, 0.7])
            yield np.array([0.0, shoulder, 1.0, elbow, 0.5, 0.0, 0.0])
    yield np.zeros(7)
    yield from random_angles(100, seed=3)


@given(command=COMMAND)
def test_rates_are_bounded_everywhere(command):
    length, threshold = BLIND.damping.length, BLIND.damping.threshold
    damped = 0
    for q in stretched():
        hand, posture, near = BLIND.ee_and_posture_rates(q, command)
        asked = np.hypot(command[0], command[2])
        hand[0] -= command[1]
        # What the first joint leaves of omega_c is rounding.
        assert np.linalg.norm(hand) <= TOP_GAIN * asked / threshold + SAME
        pull = BLIND.damping.posture_speed
        assert np.linalg.norm(posture) <= pull * (1 + SAME)
        # Damped, the posture moves the hand a little.
        leak = V_BE(q, posture) * ([length] * 3 + [1.0] * 3)
        assert np.linalg.norm(leak) <= near * 0.5 * threshold * pull + RATES
        damped += near
    assert damped > 10


def test_a_stretched_elbow_is_near_singular_and_a_bent_one_is_not():
    assert ARM.is_near_singular([0.0, 0.4, 0.0, STRETCHED, 0.0, 2.0, 0.7]) == 1
    assert ARM.is_near_singular(POSTURE) == 0
    for l, z in INSIDE:
        assert ARM.is_near_singular(ARM.inverse((l, 0.0, z))) == 0


def test_rates_have_no_jump_where_damping_begins():
    q = np.array([0.2, 0.4, 0.0, 0.0, 0.0, 2.0, 0.7])
    elbow = STRETCHED + np.linspace(-0.4, 0.0, 4001)
    rates, near = [], []
    for q[3] in elbow:
        hand, _, damped = BLIND.ee_and_posture_rates(q, (0.3, 0.2, 0.1))
        rates.append(hand)
        near.append(damped)
    assert 0 < sum(near) < len(near)
    rates = np.array(rates)
    # At w of the threshold the gain changes by 1 / w per w: 1 / 0.02^2 x 0.3 m/s.
    assert np.abs(np.diff(rates, axis=0)).max() < 800 * (elbow[1] - elbow[0])


def matrices(count):
    """Yields Jacobians (6, 7) with singular values from 1e-9 to 1."""
    rng = np.random.default_rng(4)
    for _ in range(count):
        U, _, Vt = np.linalg.svd(rng.normal(size=(6, 7)))
        values = np.append(10 ** rng.uniform(-1, 0, 5), 10 ** rng.uniform(-9, 0))
        yield U @ np.diag(values) @ Vt[:6], values.min()


def test_pseudo_inverse_is_the_plain_one_away_from_singularities():
    damping, plain = Damping(length=1.0), 0
    for J, smallest in matrices(200):
        J_plus, near = damped_pseudo_inverse(J, damping)
        if smallest < damping.threshold:
            assert near
        if smallest > math.sqrt(6) * damping.threshold:
            assert not near
        if not near:
            np.testing.assert_allclose(J_plus, np.linalg.pinv(J), rtol=0, atol=1e-7)
            plain += 1
        assert np.linalg.norm(J_plus, 2) <= TOP_GAIN / damping.threshold
    assert plain > 20


def test_rows_are_weighed_where_the_inverse_is_damped_and_only_there():
    J, _ = max(matrices(50), key=lambda drawn: drawn[1])
    for length in (0.2, 1.0):
        plain, near = damped_pseudo_inverse(J, Damping(length, threshold=1e-3))
        assert not near
        np.testing.assert_allclose(plain, np.linalg.pinv(J), rtol=0, atol=1e-9)
    # A row of nothing: lambda is at its largest, and the other rows fall short.
    J[0] = 0.0
    for length in (0.2, 1.0):
        found, near = damped_pseudo_inverse(J, Damping(length, threshold=0.05))
        assert near
        W = np.diag([length] * 3 + [1.0] * 3)
        square = W @ J @ J.T @ W + 0.05**2 * np.eye(6)
        expected = J.T @ W @ np.linalg.inv(square) @ W
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6)


# Derivatives.


def slopes(f, x, h=1e-6):
    """Returns the Jacobian of `f` at `x` by central differences."""
    return np.transpose(
        [(np.array(f(x + h * e)) - f(x - h * e)) / (2 * h) for e in np.eye(len(x))]
    )


def autodiff_slopes(f, x):
    """Returns value and Jacobian of `f` at `x` by AutoDiffXd."""
    values = f(InitializeAutoDiff(x).ravel())
    return [y.value() for y in values], np.array([y.derivatives() for y in values])


@pytest.mark.parametrize(
    "f",
    [ARM.ee_cylindrical, ARM.p_BT, lambda q: ARM.rates(q, (0.2, -0.3, 0.1))],
    ids=["ee_cylindrical", "p_BT", "rates"],
)
def test_derivatives_by_the_joints_are_those_of_differences(f):
    near_stretch = np.array([0.2, 0.4, 0.1, STRETCHED - 0.05, 0.2, 2.0, 0.7])
    assert ARM.is_near_singular(near_stretch)
    for q in (*regular_angles(5), near_stretch):
        value, found = autodiff_slopes(f, q)
        expected = slopes(f, q)
        np.testing.assert_allclose(value, f(q), rtol=0, atol=1e-10)
        scale = max(1.0, np.abs(expected).max())
        np.testing.assert_allclose(found, expected, rtol=0, atol=SLOPE * scale)


def test_derivatives_by_the_command_are_those_of_differences():
    for q in regular_angles(5):
        command = np.array([0.2, -0.3, 0.1])

        def f(rates, q=q):
            return ARM.rates(q, rates)

        _, found = autodiff_slopes(f, command)
        np.testing.assert_allclose(found, slopes(f, command), rtol=0, atol=SLOPE)


# Against the closed form.


@pytest.fixture(scope="module")
def spatial():
    """Kwon's spatial arm, by its Jacobian and in closed form."""
    robot = Spatial(upper_link=0.6, lower_link=0.45)
    closed = robot.arm()
    posture = closed.inverse((0.8, 0.0, 0.1))
    return JacobianArm(RobotModel(robot).plant, posture), closed


@given(
    l=st.floats(0.5, 1.0),
    psi=st.floats(-2.8, 2.8),
    z=st.floats(-0.4, 0.4),
    command=COMMAND,
)
def test_the_spatial_arm_moves_as_in_closed_form(spatial, l, psi, z, command):
    arm, closed = spatial
    q = closed.inverse((l, psi, z))
    for f in ("ee_cylindrical", "p_BT"):
        found, expected = (getattr(a, f)(q) for a in spatial)
        np.testing.assert_allclose(found, expected, rtol=0, atol=SAME)
    if not arm.is_near_singular(q):
        found, expected = (a.rates(q, command) for a in spatial)
        np.testing.assert_allclose(found, expected, rtol=0, atol=RATES)


@pytest.mark.parametrize("l", [0.5, 0.7, 0.9, 1.0])
@pytest.mark.parametrize("z", [-0.3, 0.0, 0.3])
@pytest.mark.parametrize("psi", [-2.0, 0.0, 0.7])
def test_the_spatial_arm_is_inverted_as_in_closed_form(spatial, l, psi, z):
    arm, closed = spatial
    found, expected = arm.inverse((l, psi, z)), closed.inverse((l, psi, z))
    # Rounding of the hand's place, over the smallest singular value.
    np.testing.assert_allclose(found, expected, rtol=0, atol=100 * CONVERGED)
    assert arm.is_in_reach((l, psi, z))


# Inverse.


@pytest.mark.parametrize("psi", [-2.8, -0.3, 0.0, 1.0, 2.8])
def test_inverse_puts_the_level_hand_where_it_is_told(psi):
    for l, z in INSIDE:
        q = ARM.inverse((l, psi, z))
        np.testing.assert_allclose(ARM.ee_cylindrical(q), (l, psi, z), atol=CONVERGED)
        assert tilt_of(q) < CONVERGED
        assert (np.array(q) >= MODEL.joint_limits.lower).all()
        assert (np.array(q) <= MODEL.joint_limits.upper).all()
        assert ARM.is_in_reach((l, psi, z))
        # Turned to psi, it is the same arm; and asked again, it says the same.
        ahead = ARM.inverse((l, 0.0, z))
        np.testing.assert_allclose(q[1:], ahead[1:], atol=1e-9)
        assert ARM.inverse((l, psi, z)) == q


def test_inverse_of_the_postures_place_is_the_posture():
    np.testing.assert_allclose(
        ARM.inverse(ARM.ee_cylindrical(POSTURE)), POSTURE, atol=SAME
    )


@given(l=st.floats(-0.2, 1.5), psi=st.floats(-4.0, 4.0), z=st.floats(-1.2, 1.2))
def test_the_hand_is_where_it_is_told_just_where_that_is_in_reach(l, psi, z):
    q = ARM.inverse((l, psi, z))
    missed = np.abs(np.subtract(ARM.ee_cylindrical(q), (l, psi, z))).max()
    assert ARM.is_in_reach((l, psi, z)) == (missed < 1e-9)
    assert (np.array(q) >= MODEL.joint_limits.lower).all()
    assert (np.array(q) <= MODEL.joint_limits.upper).all()


@pytest.mark.parametrize(
    "far",
    [(1.5, 0.3, 0.0), (0.9, 0.0, -0.2), (0.6, 0.0, 0.8), (0.5, -1.0, -1.0)],
)
def test_out_of_reach_nothing_in_reach_is_nearer(far):
    def place(l, psi, z):
        return np.array([l * np.cos(psi), l * np.sin(psi), z])

    assert not ARM.is_in_reach(far)
    found = ARM.inverse(far)
    missed = np.linalg.norm(place(*ARM.ee_cylindrical(found)) - place(*far))
    assert missed > 0.01
    for l, z in INSIDE:
        assert missed < np.linalg.norm(place(l, far[1], z) - place(*far))


def test_behind_the_shoulder_is_out_of_reach():
    assert not ARM.is_in_reach((-0.3, 0.0, 0.3))
    assert ARM.is_in_reach((0.3, 0.0, 0.3))


# What is refused.


def test_an_arm_of_two_joints_is_refused():
    with pytest.raises(ValueError, match="2 joints are too few for a placed tool"):
        JacobianArm(RobotModel(Planar()).plant, [0.0, -1.0])


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("length", 0.0),
        ("threshold", -0.1),
        ("posture_gain", -1.0),
        ("posture_speed", -1.0),
        ("level_gain", math.nan),
    ],
)
def test_a_damping_that_makes_no_sense_is_refused(key, value):
    with pytest.raises(ParameterError, match=f"^{key}: "):
        JacobianArm(MODEL.plant, POSTURE, dc.replace(Damping(), **{key: value}))
