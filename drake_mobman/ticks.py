"""Time counted in whole periods.

Sums and multiples of decimal fractions are rounded, counts are not: 0.1 + 0.2 is more
than 30 periods of 0.01, and 70 of these are more than 0.7. So times are compared as
numbers of ticks; tick k is at k times the period, rounded once, as in Drake's clock.
"""

import math

TOLERANCE = 1e-7
"""Share of a period by which a time may miss a tick and yet is meant to be at it: more
than rounding makes of a month of periods of 0.01 s."""


def last_tick(time: float, period: float) -> int:
    """Returns the number of the last tick that is not after `time` [s]."""
    return math.floor(time / period + TOLERANCE)


def at_tick(time: float, period: float) -> float:
    """Returns `time` [s], to the last bit that of the tick that it is meant to be at.

    A time between two ticks is returned as it is.
    """
    k = round(time / period)
    return k * period if abs(time / period - k) <= TOLERANCE else time


def whole_steps(period: float, step: float) -> int | None:
    """Returns how many steps [s] a period [s] is, or None where they are not whole."""
    count = round(period / step)
    return count if count and math.isclose(period / step, count) else None


def aligned(period: float, step: float) -> tuple[float, float]:
    """Returns period and step [s] that are in step for good, a few bits off at most.

    Both clocks multiply: tick k is at k times the period, step j at j times the step.
    Unless the period is a multiple of the step to the last bit, of two that are meant
    for one instant now the one comes first, now the other. So the period becomes the
    nearest float below that can be divided by the number of steps without a remainder.

    Args:
        period: of the slower clock, `whole_steps` of the faster.
        step: of the faster clock.
    """
    count = round(period / step)
    odd = count // (count & -count)  # By 2, a float can be divided in any case.
    fraction, exponent = math.frexp(period)
    digits = round(fraction * 2**53)
    exact = math.ldexp(digits - digits % odd, exponent - 53)
    return exact, exact / count
