"""Limits of the arm's joints: the rates are scaled together, by one factor."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_mobman.arm.limits import ArmStatus, JointLimits, bounded_rates

PERIOD = 0.01

SLACK = 1e-9
"""How far past a limit rounding may push a joint [rad], as `limits` has it."""

CREEP = 1e-12
"""What a joint past its limit may still do [rad/s], as `limits` has it."""

ROUNDING = 1e-15
"""Relative; a division and a product."""

LIMITS = JointLimits([-1.0, -2.0, -3.0], [1.0, 0.5, 3.0], [2.0, 1.0, 6.0])

RATES = st.lists(st.floats(-20.0, 20.0), min_size=3, max_size=3)
ANGLES = st.tuples(st.floats(-1.0, 1.0), st.floats(-2.0, 0.5), st.floats(-3.0, 3.0))


@pytest.mark.parametrize(
    ("rates", "q", "factor", "status"),
    [
        ([1.0, -1.0, 6.0], [0.0, 0.0, 0.0], 1.0, ArmStatus.OK),
        # The second turns four times too fast: all go at a quarter.
        ([1.0, -4.0, 6.0], [0.0, 0.0, 0.0], 0.25, ArmStatus.JOINT_RATE),
        # The first and third too: the slowest factor, 2/16, counts.
        ([16.0, -4.0, 7.0], [0.0, 0.0, 0.0], 0.125, ArmStatus.JOINT_RATE),
        # 0.005 rad below its limit, 1 rad/s for 0.01 s is twice too much.
        ([1.0, 0.5, 0.0], [0.995, 0.0, 0.0], 0.5, ArmStatus.JOINT_LIMIT),
        ([0.2, -1.0, 0.2], [0.0, -1.995, 0.0], 0.5, ArmStatus.JOINT_LIMIT),
        # Back from the limit all may go.
        ([-1.0, -0.5, 0.0], [0.995, 0.0, 0.0], 1.0, ArmStatus.OK),
        # Both: the first may do 0.5 of 4, the second 1 of 4.
        (
            [4.0, 4.0, 0.0],
            [0.995, 0.0, 0.0],
            0.125,
            ArmStatus.JOINT_RATE | ArmStatus.JOINT_LIMIT,
        ),
        ([0.0, 0.0, 0.0], [1.0, 0.5, 3.0], 1.0, ArmStatus.OK),
    ],
)
def test_factor_and_status_are_as_worked_out_by_hand(rates, q, factor, status):
    found, flags = bounded_rates(rates, q, LIMITS, PERIOD)
    # A slack of 1e-9 rad is 1e-7 rad/s over a period.
    np.testing.assert_allclose(found, factor * np.array(rates), atol=1e-6)
    assert ArmStatus(int(flags)) == status


@given(rates=RATES, q=ANGLES)
def test_no_joint_turns_faster_than_it_can(rates, q):
    found, _ = bounded_rates(rates, q, LIMITS, PERIOD)
    assert (np.abs(found) <= np.array(LIMITS.velocity) * (1 + ROUNDING)).all()


@given(rates=RATES, q=ANGLES)
def test_no_joint_leaves_its_range(rates, q):
    found, _ = bounded_rates(rates, q, LIMITS, PERIOD)
    after = np.array(q) + PERIOD * np.array(found)
    assert (after <= np.array(LIMITS.upper) + 1.001 * SLACK).all()
    assert (after >= np.array(LIMITS.lower) - 1.001 * SLACK).all()


@given(rates=RATES, q=ANGLES)
def test_one_factor_from_0_to_1_keeps_the_direction(rates, q):
    found, flags = bounded_rates(rates, q, LIMITS, PERIOD)
    largest = int(np.argmax(np.abs(rates)))
    factor = found[largest] / rates[largest] if rates[largest] else 1.0
    assert 0 <= factor <= 1
    np.testing.assert_allclose(found, factor * np.array(rates), rtol=1e-12, atol=1e-300)
    # Nothing is slowed down without a word, nor is there a word without need.
    assert (factor < 1) == bool(flags)


@given(held=st.lists(RATES, min_size=1, max_size=4), q=ANGLES)
def test_held_rates_end_at_the_limits_and_stay_there(held, q):
    q = np.array(q)
    for rates in held:
        for _ in range(50):
            found, _ = bounded_rates(rates, q, LIMITS, PERIOD)
            q = q + PERIOD * np.array(found)
    past = np.maximum(q - LIMITS.upper, LIMITS.lower - q)
    # The slack once, not once a period; and a creep too slow to see.
    assert past.max() <= 1.001 * SLACK + 200 * PERIOD * CREEP


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_joint_past_its_limit_may_only_come_back(sign):
    limits = JointLimits([-1.0], [1.0], [2.0])
    q = [1.2 * sign]
    out, flags = bounded_rates([1.5 * sign], q, limits, PERIOD)
    assert abs(out[0]) <= CREEP
    assert flags == ArmStatus.JOINT_LIMIT
    assert bounded_rates([-1.5 * sign], q, limits, PERIOD) == ([-1.5 * sign], 0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_rounding_does_not_lock_a_joint_at_its_limit(sign):
    # The stretched elbow at 0, which an inverse asks to go on: 5e-8 rad/s for a period
    # is half the slack.
    limits = JointLimits([0.0, -3.0], [0.0, 3.0], [2.0, 2.0])
    rates = [5e-8 * sign, 0.5]
    assert bounded_rates(rates, [0.0, 0.0], limits, PERIOD) == (rates, 0)


def test_a_joint_without_limits_is_not_bound():
    limits = JointLimits([-math.inf, -1.0], [math.inf, 1.0], [math.inf, 2.0])
    rates = [1e3, -1.0]
    assert bounded_rates(rates, [1e3, 0.0], limits, PERIOD) == (rates, 0)


def test_not_a_number_does_not_come_out_as_a_number():
    limits = JointLimits([-1.0], [1.0], [2.0])
    found, _ = bounded_rates([math.nan], [0.0], limits, PERIOD)
    assert math.isnan(found[0])
