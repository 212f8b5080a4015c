"""The base from its share: kappa and the base's speed (Kwon et al., eqs. 10, 11)."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_mobman.decomposers.projection import Projection, base_speed, radial_weight
from drake_mobman.parameters import ParameterError, checked
from drake_mobman.robot_model import WorkspaceLimits

ROUNDING = 1e-15
"""A handful of operations on numbers of about 1."""

BESIDE = math.pi / 2
"""Where the arm stands square to the base."""

LARGEST_GAIN = 1.3516
"""Of kappa / |cos psi| at sigma 0.5. With x off the side it is (1 - exp(-4 x^2)) /
sin x, and its slope is 0 at x = 0.607770: (1 - 0.228199) / 0.571038 = 1.351575."""

HALF_TURN = st.floats(-math.pi, math.pi)


@pytest.mark.parametrize(
    ("psi", "sigma", "exponent"),
    [
        (0.0, 0.5, -9.869604401089358),  # -(pi/2 / 0.5)^2 = -pi^2: ahead.
        (math.pi, 0.5, -9.869604401089358),  # The same behind.
        (BESIDE - 0.25, 0.5, -0.25),  # Half a sigma from the side.
        (BESIDE + 0.5, 0.5, -1.0),  # One sigma behind it.
        (-BESIDE + 0.5, 0.5, -1.0),  # One sigma ahead of the other side.
        (0.0, 1.0, -2.4674011002723395),  # -(pi/2)^2: a wide stop reaches ahead.
    ],
)
def test_kappa_is_as_worked_out_by_hand(psi, sigma, exponent):
    expected = 1 - math.exp(exponent)
    assert radial_weight(psi, sigma) == pytest.approx(expected, abs=ROUNDING)


def test_kappa_ahead_is_short_of_1_by_5e_5():
    # exp(-pi^2) = 5.1723e-5: so much of its share the base leaves undone at psi = 0.
    assert 1 - radial_weight(0.0, 0.5) == pytest.approx(5.1723e-5, abs=1e-9)


def test_kappa_is_0_square_to_the_base():
    assert radial_weight(BESIDE, 0.5) == 0
    assert radial_weight(-BESIDE, 0.5) == 0


@given(psi=HALF_TURN, sigma=st.floats(0.05, 5.0))
def test_kappa_is_even_and_from_0_to_1(psi, sigma):
    kappa = radial_weight(psi, sigma)
    assert 0 <= kappa <= 1
    assert kappa == radial_weight(-psi, sigma)


@pytest.mark.parametrize(
    ("psi", "v_b"),
    [
        # At 60 degrees: (1 - exp(-(pi/6 / 0.5)^2)) 0.3 / cos(60 deg), which is
        # (1 - exp(-1.0966227)) 0.6 = (1 - 0.33399719) 0.6.
        (math.pi / 3, 0.39960169),
        # The arm behind the base: to push the hand out, the base reverses.
        (math.pi * 2 / 3, -0.39960169),
        (-math.pi * 2 / 3, -0.39960169),
        (0.0, 0.3 * (1 - 5.172318620e-5)),
        (math.pi, -0.3 * (1 - 5.172318620e-5)),
    ],
)
def test_base_speed_is_as_worked_out_by_hand(psi, v_b):
    # The numbers above have eight digits.
    assert base_speed(0.3, psi, Projection()) == pytest.approx(v_b, abs=1e-8)


@given(v_bm=st.floats(-0.4, 0.4, allow_subnormal=False), psi=HALF_TURN)
def test_base_never_needs_much_more_speed_than_its_projection(v_bm, psi):
    assert abs(base_speed(v_bm, psi, Projection())) <= LARGEST_GAIN * abs(v_bm)


def test_the_largest_gain_is_met():
    gain = base_speed(1.0, BESIDE - 0.607770, Projection())
    assert gain == pytest.approx(1.351575, abs=1e-6)  # Digits of the number by hand.


@given(v_bm=st.floats(-0.4, 0.4, allow_subnormal=False), psi=st.floats(-5.0, 5.0))
def test_base_speed_is_bounded_past_half_a_turn(v_bm, psi):
    # The planar robot's shoulder turns from -3.4 to 4.9 rad, and psi with it.
    assert abs(base_speed(v_bm, psi, Projection())) <= LARGEST_GAIN * abs(v_bm)


@given(v_bm=st.floats(-0.4, 0.4, allow_subnormal=False), psi=HALF_TURN)
def test_base_goes_with_its_projection(v_bm, psi):
    # v_b cos psi = kappa v_bm: what the hand gets of it has the sign of its share.
    along = base_speed(v_bm, psi, Projection()) * math.cos(psi)
    assert along == pytest.approx(radial_weight(psi, 0.5) * v_bm, abs=ROUNDING)


@pytest.mark.parametrize("side", [BESIDE, -BESIDE])
def test_base_stands_still_square_to_the_arm_to_the_last_float(side):
    near = [side, math.nextafter(side, 9.0), math.nextafter(side, -9.0)]
    # (x / sigma)^2 / x = 4 x: what is left at an angle x from the side. 1 - exp of
    # it is told to 1.2e-16, and is divided by x.
    for x in (1e-12, 1e-8, 1e-6):
        near += [side + x, side - x]
    for psi in near:
        v_b = base_speed(0.4, psi, Projection())
        x = abs(abs(psi) - BESIDE)
        assert abs(v_b) <= 0.4 * (4 * x + 1.2e-16 / max(x, 1e-16)) * 1.001
        assert abs(v_b) < 1e-4


@pytest.mark.parametrize("sigma", [0.0, -0.5, math.nan, math.inf])
def test_a_stop_without_width_is_refused(sigma):
    with pytest.raises(ParameterError, match=r"^sigma: "):
        checked(Projection(sigma=sigma))


@pytest.mark.parametrize(
    ("limits", "key"),
    [
        ({"l_min": 1.6, "l_max": 1.6}, "l_min"),
        ({"l_min": -0.1}, "l_min"),
        ({"psi_min": 0.8}, "psi_min"),
        ({"l_max": math.nan}, "l_max"),
    ],
)
def test_a_workspace_that_is_none_is_refused(limits, key):
    with pytest.raises(ParameterError, match=f"^{key}: "):
        checked(WorkspaceLimits(**limits))


def test_defaults_are_those_of_table_1():
    limits = checked(WorkspaceLimits())
    assert (limits.l_min, limits.l_max) == (0.4, 1.6)
    assert (limits.psi_min, limits.psi_max) == (-0.7, 0.7)
