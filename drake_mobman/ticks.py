"""Time counted in whole periods.

Sums and multiples of decimal fractions are rounded, counts are not: 0.1 + 0.2 is more
than 30 periods of 0.01, and 70 of these are more than 0.7. So times are compared as
numbers of ticks; tick k is at k times the period, rounded once, as in Drake's clock.
"""

import math

TOLERANCE = 1e-7
"""Largest distance between a time and its tick, in periods: more than the rounding
error of a month of periods of 0.01 s."""


def last_tick(time: float, period: float) -> int:
    """Returns the number of the last tick that is not after `time` [s]."""
    return math.floor(time / period + TOLERANCE)


def at_tick(time: float, period: float) -> float:
    """Returns the exact time [s] of the tick at `time`.

    A time between two ticks is returned unchanged.
    """
    k = round(time / period)
    return k * period if abs(time / period - k) <= TOLERANCE else time


def whole_steps(period: float, step: float) -> int | None:
    """Returns how many steps [s] a period [s] has, or None if not a whole number."""
    count = round(period / step)
    return count if count and math.isclose(period / step, count) else None


def aligned(period: float, step: float) -> tuple[float, float]:
    """Returns a period [s] that is an exact multiple of the step, and that step [s].

    Tick k is at k times the period, step j at j times the step. Unless the period is an
    exact multiple of the step, a tick and a step that should be at the same time come
    in varying order. So the period becomes the nearest float below that the number of
    steps divides without a remainder.

    Args:
        period: of the slower clock, `whole_steps` of the faster.
        step: of the faster clock.
    """
    count = round(period / step)
    odd = count // (count & -count)  # A float can always be divided by 2.
    fraction, exponent = math.frexp(period)
    digits = round(fraction * 2**53)
    exact = math.ldexp(digits - digits % odd, exponent - 53)
    return exact, exact / count
