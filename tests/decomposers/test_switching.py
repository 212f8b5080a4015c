"""Authority switched at the workspace's limits (Kwon et al., eqs. 12 and 13)."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_mobman.decomposers.switching import (
    Switching,
    SwitchingDecomposer,
    switched_share,
)
from drake_mobman.robot_model import WorkspaceLimits

L_MIN, L_MAX, PSI_MIN, PSI_MAX = 0.4, 1.6, -0.7, 0.7

ALONE = {
    "arm_position": [0.0, 0.0],
    "base_command_smoothed": [0.0, 0.0],
    "base_estimate": [0.0, 0.0, 0.0],
}
"""Inputs that a law of shares does not look at."""

SPEED = st.floats(-0.4, 0.4)
REACH = st.floats(0.0, 2.0)
ANGLE = st.floats(-3.2, 3.2)


@pytest.mark.parametrize(
    ("v_c", "l", "v_bm", "v_m"),
    [
        (-0.3, 0.39, -0.3, 0.0),  # Eq. 12a, l < L_min: the base retreats.
        (-0.3, 0.4, 0.0, -0.3),  # 12a, else.
        (-0.3, 1.0, 0.0, -0.3),
        (-0.3, 1.9, 0.0, -0.3),  # 12a, else: the arm turns back from outside.
        (0.3, 0.1, 0.0, 0.3),  # 12b, l < L_max: the arm turns back from inside.
        (0.3, 1.59, 0.0, 0.3),
        (0.3, 1.6, 0.3, 0.0),  # 12b, else: the base follows.
        (0.3, 1.9, 0.3, 0.0),
        (0.0, 1.9, 0.0, 0.0),
    ],
)
def test_linear_command_goes_where_eq_12_sends_it(fed, outputs, v_c, l, v_bm, v_m):
    block = SwitchingDecomposer(Switching())
    context = fed(block, **ALONE, ee_command=[v_c, 0, 0], ee_cylindrical=[l, 0, 0])
    sent = outputs(block, context)
    assert list(sent["base_contribution"]) == [v_bm, 0]
    assert list(sent["arm_command"]) == [v_m, 0, 0]


@pytest.mark.parametrize(
    ("omega_c", "psi", "omega_b", "omega_m"),
    [
        (-0.3, -0.71, -0.3, 0.0),  # Eq. 13a, psi < Psi_min.
        (-0.3, -0.7, 0.0, -0.3),  # 13a, else.
        (-0.3, 0.9, 0.0, -0.3),  # The arm turns back from the left.
        (0.3, -0.9, 0.0, 0.3),  # The arm turns back from the right.
        (0.3, 0.69, 0.0, 0.3),  # 13b, psi < Psi_max.
        (0.3, 0.7, 0.3, 0.0),  # 13b, else.
        (0.0, -0.9, 0.0, 0.0),
    ],
)
def test_angular_command_goes_where_eq_13_sends_it(
    fed, outputs, omega_c, psi, omega_b, omega_m
):
    block = SwitchingDecomposer(Switching())
    context = fed(
        block, **ALONE, ee_command=[0, omega_c, 0.1], ee_cylindrical=[1, psi, 0]
    )
    sent = outputs(block, context)
    assert list(sent["base_command"]) == [0, omega_b]
    assert list(sent["arm_command"]) == [0, omega_m, 0.1]


def plain_eq_12(v_c, l):
    """Returns v_bm, v_m as eq. 12 is printed, branch by branch."""
    if v_c < 0:
        return (v_c, 0.0) if l < L_MIN else (0.0, v_c)
    return (0.0, v_c) if l < L_MAX else (v_c, 0.0)


@given(v_c=SPEED, omega_c=SPEED, l=REACH, psi=ANGLE)
def test_it_agrees_with_the_printed_branches(v_c, omega_c, l, psi):
    mu, nu = Switching().shares(WorkspaceLimits(), (v_c, omega_c, 0.0), (l, psi, 0.0))
    assert (mu * v_c, (1 - mu) * v_c) == plain_eq_12(v_c, l)
    # Eq. 13 is eq. 12 with other names: psi stands for l about other limits.
    if omega_c < 0:
        assert nu == (psi < PSI_MIN)
    else:
        assert nu == (not psi < PSI_MAX)


@given(v_c=SPEED, omega_c=SPEED, v_z=SPEED, l=REACH, psi=ANGLE)
def test_base_and_arm_sum_to_the_command(fed, outputs, v_c, omega_c, v_z, l, psi):
    block = SwitchingDecomposer(Switching())
    command = [v_c, omega_c, v_z]
    sent = outputs(
        block, fed(block, **ALONE, ee_command=command, ee_cylindrical=[l, psi, 0])
    )
    v_bm, omega_b = sent["base_contribution"]
    v_m, omega_m, arm_v_z = sent["arm_command"]
    # All or nothing: not even rounding.
    assert [v_bm + v_m, omega_b + omega_m, arm_v_z] == command
    assert 0 in (v_bm, v_m)
    assert 0 in (omega_b, omega_m)


@pytest.mark.parametrize(
    ("command", "x"), [(-0.3, L_MAX + 0.2), (0.3, L_MIN - 0.3), (0.3, -5.0)]
)
def test_arm_turns_back_from_outside(command, x):
    assert switched_share(command, x, L_MIN, L_MAX) == 0


def test_held_at_a_limit_authority_flips_with_each_sign_of_the_command():
    # What the paper calls chattering: the hand at L_max, a command that dithers.
    l = L_MAX + 1e-3
    shares = [switched_share(0.1 * (-1) ** k, l, L_MIN, L_MAX) for k in range(6)]
    assert shares == [1, 0, 1, 0, 1, 0]


def test_other_limits_are_taken():
    limits = WorkspaceLimits(l_min=0.2, l_max=0.5, psi_min=-1.5, psi_max=0.1)
    shares = Switching().shares(limits, (0.1, 0.1, 0), (0.6, 0.2, 0))
    assert shares == (1, 1)
    shares = Switching().shares(limits, (-0.1, -0.1, 0), (0.3, -1.4, 0))
    assert shares == (0, 0)


def test_not_a_number_is_not_taken_for_a_command(fed):
    # The guard lets none in; the law does not turn one into a number.
    block = SwitchingDecomposer(Switching())
    context = fed(block, ee_command=[math.nan, 0, 0], ee_cylindrical=[1, 0, 0])
    assert math.isnan(block.GetOutputPort("base_contribution").Eval(context)[0])
