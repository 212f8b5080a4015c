"""What a law needs to be written once for float, AutoDiffXd and Expression."""

import sys
from typing import Any

from pydrake.symbolic import Formula, if_then_else
from pydrake.symbolic import max as symbolic_max
from pydrake.symbolic import min as symbolic_min

Scalar = Any
"""A float, an `AutoDiffXd` or an `Expression`; a law takes any of them."""


def where(condition: Any, if_true: Scalar, if_false: Scalar) -> Scalar:
    """Returns one of two values; both are evaluated, so neither may fail."""
    if isinstance(condition, Formula):
        return if_then_else(condition, if_true, if_false)
    return if_true if condition else if_false


def smaller(a: Scalar, b: Scalar) -> Scalar:
    """Returns the smaller of `a` and `b`; of equals, `a`."""
    less = b < a
    if isinstance(less, Formula):
        return symbolic_min(a, b)  # To choose by a formula would double what is chosen.
    return b if less else a


def larger(a: Scalar, b: Scalar) -> Scalar:
    """Returns the larger of `a` and `b`; of equals, `a`."""
    more = b > a
    if isinstance(more, Formula):
        return symbolic_max(a, b)
    return b if more else a


def saturated(x: Scalar, limit: Scalar) -> Scalar:
    """Returns `x` held within `[-limit, limit]` (Petric & Zlajpah, eq. 11)."""
    return larger(smaller(x, limit), -limit)


def is_finite(x: Scalar) -> Any:
    """Returns whether `x` is neither infinite nor NaN; of an `Expression`, a formula.

    By a comparison that no simplification takes away, unlike that of `x` with itself.
    """
    return abs(x) <= sys.float_info.max


def finite_or_zero(x: Scalar) -> Scalar:
    """Returns `x`, or 0 where it is infinite or not a number."""
    return where(is_finite(x), x, type(x)(0.0))


_ROUNDING = 1e-9
"""Share of a step that its sums may be off by rounding."""


def nearer_to_rest(x: Scalar, step: float) -> Scalar:
    """Returns `x` one `step` nearer to 0, and 0 itself where no more than that is left.

    But for rounding: what is a whole number of steps from 0 takes that many.
    """
    left = x - saturated(x, step)
    return where(abs(left) <= _ROUNDING * step, 0.0 * left, left)


def smoothstep(x: Scalar, lower: Scalar, upper: Scalar) -> Scalar:
    """Returns 0 up to `lower`, 1 from `upper` on, and a smooth cubic between."""
    s = larger(smaller((x - lower) / (upper - lower), 1.0), 0.0)
    return s * s * (3.0 - 2.0 * s)
