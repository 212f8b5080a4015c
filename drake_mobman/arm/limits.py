"""Limits of the arm's joints: the rates are scaled together, never cut one by one."""

import dataclasses as dc
import enum
from collections.abc import Sequence
from typing import Any

from drake_mobman.scalars import Scalar, larger, smaller, where

_SLACK = 1e-9
"""How far past its limit a joint may be pushed [rad]: rounding must not lock it."""

_CREEP = 1e-12
"""Stands for no room at all [rad/s], so that nothing is divided by zero."""


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
        speed = abs(rate)
        room = where(rate > 0, high - angle, angle - low) + _SLACK
        by_rate = smaller(by_rate, _factor(speed, fastest))
        by_limit = smaller(by_limit, _factor(speed, larger(room / period, _CREEP)))
    factor = smaller(by_rate, by_limit)
    status = where(by_rate < 1, float(ArmStatus.JOINT_RATE), 0.0) + where(
        by_limit < 1, float(ArmStatus.JOINT_LIMIT), 0.0
    )
    return [factor * rate for rate in rates], status


def _factor(speed: Scalar, bound: Scalar) -> Scalar:
    """Returns the largest factor in [0, 1] that brings `speed` within `bound` > 0."""
    return bound / larger(speed, bound)
