"""Two links in a plane, in closed form (Kwon et al., eqs. 4-9)."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from drake_mobman.arm import two_link

EPS = np.finfo(float).eps

ROUNDING = 1e-14
"""A dozen operations on angles and lengths of up to 4."""

NEAR_SINGULAR = 0.05
"""|sin theta_2| below which rates are damped, as `two_link` documents it."""

LINKS = [(1.0, 1.0), (1.1, 0.7), (0.4, 0.9)]
"""Upper and lower, equal and not."""

any_links = pytest.mark.parametrize(("upper", "lower"), LINKS)

SHOULDER = st.floats(-3.1, 3.1)
ELBOW = st.floats(-math.pi, 0.0)
BENT = st.floats(-3.0, -0.1)
"""Elbows away from both singularities: |sin theta_2| > 0.09."""
SPEED = st.floats(-0.4, 0.4)


@pytest.mark.parametrize(
    ("l", "z", "theta_1", "theta_2"),
    [
        (1.0, 1.0, math.pi / 2, -math.pi / 2),  # Up, then level.
        (math.sqrt(2), 0.0, math.pi / 4, -math.pi / 2),  # A right angle on its tip.
        (1.0, 0.0, math.pi / 3, -2 * math.pi / 3),  # An equilateral triangle.
        (2.0, 0.0, 0.0, 0.0),  # Stretched.
        (0.0, 1.0, 5 * math.pi / 6, -2 * math.pi / 3),  # The triangle, upright.
    ],
)
def test_inverse_is_as_worked_out_by_hand(l, z, theta_1, theta_2):
    found = two_link.inverse(l, z, 1.0, 1.0)
    # The stretched arm: a rounding of the reach turns the elbow by its root.
    assert found == pytest.approx((theta_1, theta_2), abs=3e-8)


def eqs_4_and_5(l, z, upper, lower):
    """As printed: the branch with theta_2 < 0."""
    squared = l * l + z * z - upper**2 - lower**2
    theta_2 = -math.acos(squared / (2 * upper * lower))
    ahead = math.atan2(lower * math.sin(theta_2), upper + lower * math.cos(theta_2))
    return math.atan2(z, l) - ahead, theta_2


@any_links
@given(theta_1=SHOULDER, theta_2=BENT)
def test_inverse_agrees_with_eqs_4_and_5(upper, lower, theta_1, theta_2):
    l, z = two_link.forward(theta_1, theta_2, upper, lower)
    found = two_link.inverse(l, z, upper, lower)
    # arccos has slope 1 / sin theta_2, up to 10 here.
    assert found == pytest.approx(eqs_4_and_5(l, z, upper, lower), abs=10 * ROUNDING)


@any_links
@given(theta_1=SHOULDER, theta_2=ELBOW)
def test_tip_comes_back_where_the_inverse_puts_it(upper, lower, theta_1, theta_2):
    l, z = two_link.forward(theta_1, theta_2, upper, lower)
    angles = two_link.inverse(l, z, upper, lower)
    found = two_link.forward(*angles, upper, lower)
    # Stretched or folded, rounding may put l, z out of reach by as much.
    assert found == pytest.approx((l, z), abs=ROUNDING)
    assert -math.pi <= angles[1] <= 0


@any_links
@given(theta_2=ELBOW)
def test_reach_and_direction_are_those_of_the_tip(upper, lower, theta_2):
    l, z = two_link.forward(0.0, theta_2, upper, lower)
    reach = two_link.reach(theta_2, upper, lower)
    assert reach == pytest.approx(math.hypot(l, z), abs=ROUNDING)
    assume(reach > 1e-6)  # Folded up, a point has no direction.
    direction = two_link.direction(theta_2, upper, lower)
    assert direction == pytest.approx(math.atan2(z, l), abs=EPS / 1e-6)


@pytest.mark.parametrize("reach", [1e-3, 1e-5, 1e-8, 1e-12])
def test_elbow_of_a_folded_arm_keeps_its_digits(reach):
    # Equal links of 1 m: l = 2 sin(x / 2) with x = theta_2 + pi. arccos of -1 + l^2/2
    # has nothing left of it at l = 1e-8.
    theta_2 = two_link.elbow_angle(reach, 1.0, 1.0)
    expected = 2 * math.asin(reach / 2) - math.pi
    assert theta_2 == pytest.approx(expected, abs=2 * EPS * math.pi)
    # Back, an angle near pi is told to 2.2e-16, and so is the reach.
    found = two_link.reach(theta_2, 1.0, 1.0)
    assert found == pytest.approx(reach, abs=2 * EPS * math.pi)


@any_links
@pytest.mark.parametrize("bend", [1e-3, 1e-5, 1e-7])
def test_elbow_of_a_stretched_arm_loses_no_more_than_the_reach_tells(
    upper, lower, bend
):
    # l falls short of the stretch by k x^2 / 2, k = L1 L2 / (L1 + L2): a rounding of
    # l by EPS (L1 + L2) is one of x by EPS (L1 + L2) / (k x).
    reach = two_link.reach(-bend, upper, lower)
    theta_2 = two_link.elbow_angle(reach, upper, lower)
    k = upper * lower / (upper + lower)
    assert theta_2 == pytest.approx(-bend, abs=4 * EPS * (upper + lower) / (k * bend))


def test_elbow_of_a_stretched_arm_is_better_than_arccos():
    bend = 1e-7
    reach = two_link.reach(-bend, 1.0, 1.0)
    by_half_angle = two_link.elbow_angle(reach, 1.0, 1.0)
    assert two_link.elbow_angle(2.0, 1.0, 1.0) == 0.0
    assert abs(by_half_angle + bend) <= abs(eqs_4_and_5(reach, 0.0, 1.0, 1.0)[1] + bend)


@any_links
@given(l=st.floats(-3.0, 3.0), z=st.floats(-3.0, 3.0))
def test_out_of_reach_gives_the_nearest_in_the_same_direction(upper, lower, l, z):
    distance = math.hypot(l, z)
    assume(distance > 1e-3)
    nearest = min(max(distance, abs(upper - lower)), upper + lower)
    found = two_link.forward(*two_link.inverse(l, z, upper, lower), upper, lower)
    expected = (l * nearest / distance, z * nearest / distance)
    # The direction of a point 1e-3 away is told to 1e-13.
    assert found == pytest.approx(expected, abs=10 * ROUNDING)
    inside = nearest == distance
    if abs(nearest - abs(upper - lower)) > 1e-9 < upper + lower - nearest:
        assert (two_link.reach_margin(l, z, upper, lower) >= 0) == inside


def test_border_of_the_reach_is_in_reach():
    assert two_link.reach_margin(1.8, 0.0, 1.1, 0.7) >= 0
    assert two_link.reach_margin(0.4, 0.0, 1.1, 0.7) >= 0


def jacobian(theta_1, theta_2, upper, lower):
    """Eq. 7, with the signs that the derivatives of l and z have."""
    both = theta_1 + theta_2
    return np.array(
        [
            [
                -upper * math.sin(theta_1) - lower * math.sin(both),
                -lower * math.sin(both),
            ],
            [
                upper * math.cos(theta_1) + lower * math.cos(both),
                lower * math.cos(both),
            ],
        ]
    )


@any_links
@given(theta_1=SHOULDER, theta_2=BENT, v_l=SPEED, v_z=SPEED)
def test_rates_are_the_jacobians_inverse_away_from_singularities(
    upper, lower, theta_1, theta_2, v_l, v_z
):
    found = two_link.rates(theta_1, theta_2, v_l, v_z, upper, lower)
    J = jacobian(theta_1, theta_2, upper, lower)
    expected = np.linalg.solve(J, [v_l, v_z])
    # The condition of J, up to 5 / (0.28 x 0.1), times rounding of rates of up to 30.
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
    assert two_link.is_near_singular(theta_2) == 0


@any_links
@given(theta_1=SHOULDER, theta_2=BENT, v_l=SPEED, v_z=SPEED)
def test_rates_are_those_of_the_inverse_moved_along(
    upper, lower, theta_1, theta_2, v_l, v_z
):
    h = 1e-6
    l, z = two_link.forward(theta_1, theta_2, upper, lower)
    after = two_link.inverse(l + h * v_l, z + h * v_z, upper, lower)
    before = two_link.inverse(l - h * v_l, z - h * v_z, upper, lower)
    # atan2(z, l) has a border at pi, where the shoulder jumps by a turn.
    moved = (np.subtract(after, before) + math.pi) % (2 * math.pi) - math.pi
    found = two_link.rates(theta_1, theta_2, v_l, v_z, upper, lower)
    # Central differences: rounding 1e-14 / sin theta_2 over h, and h^2 of the third
    # derivative, up to (v / (0.28 x 0.1))^3.
    np.testing.assert_allclose(found, moved / (2 * h), rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    ("theta_1", "theta_2", "v", "expected"),
    [
        # Eq. 9 by hand. Up, then level: v_l turns the first link by -v_l, and the
        # second stays level; v_z turns the second by v_z.
        (math.pi / 2, -math.pi / 2, (0.3, 0.0), (-0.3, 0.3)),
        (math.pi / 2, -math.pi / 2, (0.0, 0.3), (0.0, 0.3)),
        # The right angle on its tip: pushed out by v, each link turns by v / sqrt(2).
        (math.pi / 4, -math.pi / 2, (0.3, 0.0), (-0.3 / 2**0.5, 0.6 / 2**0.5)),
    ],
)
def test_rates_are_as_worked_out_by_hand(theta_1, theta_2, v, expected):
    found = two_link.rates(theta_1, theta_2, *v, 1.0, 1.0)
    assert found == pytest.approx(expected, abs=ROUNDING)


LARGEST_SCALE = 1.0665 / NEAR_SINGULAR
"""Of the damped 1 / sin theta_2: with u = sin(theta_2) / 0.05 it is 20 times
u / (u^2 + (1 - u^2)^2), largest at u^2 = (1 + sqrt(13)) / 6, where it is 1.0664."""


@any_links
@given(theta_1=SHOULDER, theta_2=ELBOW, v_l=SPEED, v_z=SPEED)
def test_rates_are_bounded_everywhere(upper, lower, theta_1, theta_2, v_l, v_z):
    first, second = two_link.rates(theta_1, theta_2, v_l, v_z, upper, lower)
    speed = math.hypot(v_l, v_z) * (1 + ROUNDING)
    assert abs(first) <= LARGEST_SCALE * speed / upper
    assert abs(second) <= LARGEST_SCALE * speed * (upper + lower) / (upper * lower)


@any_links
@pytest.mark.parametrize("theta_2", [0.0, -math.pi])
def test_a_stretched_or_folded_arm_is_not_torn(upper, lower, theta_2):
    found = two_link.rates(0.3, theta_2, 0.4, -0.4, upper, lower)
    # sin(-pi) is -1.2e-16, over 0.05^2.
    np.testing.assert_allclose(found, 0.0, atol=1e-12)
    assert two_link.is_near_singular(theta_2) == 1


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("theta_2", [-math.asin(0.05), math.asin(0.05) - math.pi])
def test_damping_sets_in_without_a_jump(theta_2, side):
    x = 1e-9
    here = two_link.rates(0.3, theta_2, 0.4, -0.2, 1.0, 0.7)
    there = two_link.rates(0.3, theta_2 + side * x, 0.4, -0.2, 1.0, 0.7)
    # Rates of up to 25 rad/s, that change by their 20-fold each rad.
    np.testing.assert_allclose(there, here, atol=1000 * x)


@given(theta_1=SHOULDER, theta_2=ELBOW, v_l=SPEED, v_z=SPEED)
def test_damped_or_not_the_tip_is_never_driven_backwards(theta_1, theta_2, v_l, v_z):
    J = jacobian(theta_1, theta_2, 1.0, 0.7)
    made = J @ two_link.rates(theta_1, theta_2, v_l, v_z, 1.0, 0.7)
    # One factor on both: J rates = s scale v, with s scale in [0, 1].
    v = np.array([v_l, v_z])
    assert made @ v >= -1e-12
    assert np.linalg.norm(made) <= np.linalg.norm(v) + 1e-12
    assert abs(made[0] * v_z - made[1] * v_l) <= 1e-12
