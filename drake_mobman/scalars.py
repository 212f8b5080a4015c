"""What a law needs to be written once for float, AutoDiffXd and Expression."""

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


def smoothstep(x: Scalar, lower: Scalar, upper: Scalar) -> Scalar:
    """Returns 0 up to `lower`, 1 from `upper` on, and a smooth cubic between."""
    s = larger(smaller((x - lower) / (upper - lower), 1.0), 0.0)
    return s * s * (3.0 - 2.0 * s)
