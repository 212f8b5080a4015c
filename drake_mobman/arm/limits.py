"""Limits of the arm's joints: the rates are scaled together, never cut one by one."""

import dataclasses as dc
import enum
import math
from collections.abc import Sequence

from pydrake.math import sqrt

from drake_mobman.scalars import Scalar, Vector, larger, largest, smaller, where
from drake_mobman.tracing import also_named

_SLACK = 1e-9
"""How far past its limit a joint may go [rad]: rounding must not lock it."""

_CREEP = 1e-15
"""Least rate towards a limit [rad/s], so that nothing is divided by zero."""


class ArmStatus(enum.IntFlag):
    """What keeps the arm from making the rates commanded."""

    OK = 0
    JOINT_RATE = 1
    """A joint would turn faster than it can."""
    JOINT_LIMIT = 2
    """A joint would near the end of its range faster than it can brake."""
    OUT_OF_REACH = 4
    """The end effector would go where the arm does not reach."""
    SINGULAR = 8
    """The arm is nearly stretched or folded, and the rates are damped."""
    ORIENTATION = 16
    """The end effector is not oriented as commanded, so that it moves as commanded."""


@dc.dataclass(frozen=True)
class JointLimits:
    """Limits of n joints, as the robot's model gives them."""

    lower: Sequence[float]  # Smallest angles [rad].
    upper: Sequence[float]  # Largest angles [rad].
    velocity: Sequence[float]  # Largest rates [rad/s].
    # Largest accelerations [rad/s^2], infinite where the model states none.
    acceleration: Sequence[float] = ()

    def __post_init__(self) -> None:
        """Sets accelerations that are not given to infinite."""
        if not len(self.acceleration):
            unlimited = [math.inf] * len(self.velocity)
            object.__setattr__(self, "acceleration", unlimited)


def bounded_rates(
    rates: Vector, q: Vector, limits: JointLimits, period: float
) -> tuple[list[Scalar], Scalar]:
    """Returns joint rates within the limits, and the `ArmStatus` flags of what bound.

    All rates are scaled by one factor in [0, 1], so that the end effector slows down
    and keeps its direction. The limit on acceleration bounds how a
    joint nears the end of its range, not how its rate changes otherwise.

    Args:
        rates: joint rates wanted (n,) [rad/s].
        q: joint angles (n,) [rad].
        limits: of these joints.
        period: for which the rates are held [s].
    """
    speeds = [abs(rate) for rate in rates]
    by_rate, by_limit = (
        factor_within(speeds, bounds)
        for bounds in (limits.velocity, end_rates(rates, q, limits, period))
    )
    factor = also_named(smaller(by_rate, by_limit))
    status = where(by_rate < 1, float(ArmStatus.JOINT_RATE), 0.0) + where(
        by_limit < 1, float(ArmStatus.JOINT_LIMIT), 0.0
    )
    return [also_named(factor * rate) for rate in rates], status


def filled_rates(
    rates: Vector,
    extra: Vector,
    q: Vector,
    limits: JointLimits,
    period: float,
) -> list[Scalar]:
    """Returns `rates` and as much of `extra` as the limits leave room for.

    All of `extra` is scaled by one factor in [0, 1], so that what is in the arm's null
    space stays in it; `rates` pass as they are.

    Args:
        rates: joint rates within the limits (n,) [rad/s].
        extra: joint rates to be added where there is room (n,) [rad/s].
        q: joint angles (n,) [rad].
        limits: of these joints.
        period: for which the rates are held [s].
    """
    left = []
    bounds = zip(limits.velocity, end_rates(extra, q, limits, period), strict=True)
    for rate, more, (fastest, towards_end) in zip(rates, extra, bounds, strict=True):
        room = smaller(fastest, towards_end) - where(more > 0, rate, -rate)
        left.append(also_named(larger(room, _CREEP)))
    factor = factor_within([abs(more) for more in extra], left)
    return [
        also_named(rate + factor * more)
        for rate, more in zip(rates, extra, strict=True)
    ]


def braking_rate(room: Scalar, acceleration: float, period: float) -> Scalar:
    """Returns the largest rate [rad/s] towards a limit that leaves room to brake.

    Held for a period h, then brought down by at most a h in each, it must not use up
    the room r: h (v + (v - a h) + ...) <= r. Linear between whole v = k a h, where the
    sum is v (v + a h) / 2 a, it exceeds that by a h^2 / 8 at most; so v <= sqrt(2 a r)
    - a h / 2 will do. That falls by just a h a period where it is followed, down to its
    tangent v = r / h, the last step, at r = a h^2 / 2.

    Args:
        room: angle left to the limit [rad]; below 0, past it.
        acceleration: a that the joint brakes with [rad/s^2]; may be infinite.
        period: h for which a rate is held [s].
    """
    room = also_named(room)
    last = larger(room / period, _CREEP)
    if math.isinf(acceleration):
        return last
    step = acceleration * period
    braking = sqrt(2 * acceleration * larger(room, 0.0)) - 0.5 * step
    return also_named(where(2 * room > step * period, braking, last))


def end_rates(
    rates: Vector, q: Vector, limits: JointLimits, period: float
) -> list[Scalar]:
    """Returns how fast each joint may near the limit ahead of it (n,) [rad/s].

    Args:
        rates: joint rates (n,), whose signs tell which limit is ahead [rad/s].
        q: joint angles (n,) [rad].
        limits: of these joints.
        period: for which the rates are held [s].
    """
    return [
        braking_rate(where(rate > 0, high - angle, angle - low) + _SLACK, most, period)
        for rate, angle, low, high, most in zip(
            rates, q, limits.lower, limits.upper, limits.acceleration, strict=True
        )
    ]


def factor_within(speeds: Vector, bounds: Vector) -> Scalar:
    """Returns the largest factor in [0, 1] that brings all within their bounds > 0.

    A bound may be infinite.
    """
    excess = [
        also_named(speed / bound) for speed, bound in zip(speeds, bounds, strict=True)
    ]
    return also_named(1.0 / largest(1.0, *excess))
