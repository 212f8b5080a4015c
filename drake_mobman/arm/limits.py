"""Limits of the arm's joints: the rates are scaled together, never cut one by one."""

import dataclasses as dc
import enum
from collections.abc import Sequence
from typing import Any

from drake_mobman.scalars import Scalar, larger, smaller, where

_SLACK = 1e-9
"""How far past its limit a joint may be pushed [rad]: rounding must not lock it."""


class ArmStatus(enum.IntFlag):
    """What keeps the arm from making the rates it is asked for."""

    OK = 0
    JOINT_RATE = 1
    """A joint would turn faster than it can."""
    JOINT_LIMIT = 2
    """A joint would leave its range within the period."""
    OUT_OF_REACH = 4
    """The hand would go where the arm does not reach."""
    SINGULAR = 8
    """The arm is nearly stretched or folded, and the rates are damped."""


@dc.dataclass(frozen=True)
class JointLimits:
    """Limits of n joints, as the robot's model gives them."""

    lower: Sequence[float]  # Smallest angles [rad].
    upper: Sequence[float]  # Largest angles [rad].
    velocity: Sequence[float]  # Largest rates [rad/s].


def bounded_rates(
    rates: Sequence[Scalar], q: Any, limits: JointLimits, period: float
) -> tuple[list[Scalar], Scalar]:
    """Returns joint rates within the limits, and the `ArmStatus` flags of what bound.

    All rates are scaled by one factor in [0, 1], so that the hand slows down in its
    direction instead of turning out of it.

    Args:
        rates: joint rates asked for (n,) [rad/s].
        q: joint angles (n,) [rad].
        limits: of these joints.
        period: for which the rates are held [s].
    """
    by_rate: Scalar = 1.0
    by_limit: Scalar = 1.0
    for rate, angle, low, high, fastest in zip(
        rates, q, limits.lower, limits.upper, limits.velocity, strict=True
    ):
        by_rate = smaller(by_rate, _factor(rate, -fastest, fastest))
        room_up = larger((high + _SLACK - angle) / period, 0.0)
        room_down = smaller((low - _SLACK - angle) / period, 0.0)
        by_limit = smaller(by_limit, _factor(rate, room_down, room_up))
    factor = smaller(by_rate, by_limit)
    status = where(by_rate < 1, float(ArmStatus.JOINT_RATE), 0.0) + where(
        by_limit < 1, float(ArmStatus.JOINT_LIMIT), 0.0
    )
    return [factor * rate for rate in rates], status


def _factor(rate: Scalar, low: Scalar, high: Scalar) -> Scalar:
    """Returns the largest factor in [0, 1] that brings `rate` into [low, high]."""
    over, under = rate > high, rate < low
    # A rate that is not over its bound divides nothing: 1 stands in for it.
    return where(
        over,
        high / where(over, rate, 1.0),
        where(under, low / where(under, rate, 1.0), 1.0),
    )
