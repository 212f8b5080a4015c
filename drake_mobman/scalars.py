"""Functions for laws that are written once for float, AutoDiffXd and Expression."""

import functools
import operator
import sys
from collections.abc import Iterable, Sequence
from typing import Any

import numpy.typing as npt
from pydrake.math import atan2, cos, sin
from pydrake.symbolic import Expression, ExpressionKind, Formula, Variable, if_then_else
from pydrake.symbolic import max as symbolic_max
from pydrake.symbolic import min as symbolic_min

Scalar = Any
"""A float, an `AutoDiffXd` or an `Expression`; a law takes any of them.

Distinguish them by `type(x) is ...`: `isinstance` takes longer than the law itself.
"""

Matrix = npt.NDArray[Any]
"""An array of scalars, of any shape: the docstring says which."""

Vector = Sequence[Scalar] | Matrix
"""Scalars in a row: a list, a tuple or an array."""

Rows = Sequence[Vector] | Matrix
"""A matrix by its rows: a list of lists, or an array."""


def where(condition: Any, if_true: Scalar, if_false: Scalar) -> Scalar:
    """Returns one of two values; both are evaluated, so neither may fail."""
    if type(condition) is Formula:
        return if_then_else(condition, if_true, if_false)
    return if_true if condition else if_false


def known(condition: Any) -> bool:
    """Returns whether a condition holds for sure: that of an Expression never does."""
    return type(condition) is not Formula and bool(condition)


def smaller(a: Scalar, b: Scalar) -> Scalar:
    """Returns the smaller of `a` and `b`; of equals, `a`; NaN where either is NaN."""
    less = b < a
    if type(less) is Formula:
        return _chosen(symbolic_min, (a, b))
    if less:
        return b
    return a if a <= b else a + b  # All comparisons with NaN are false.


def larger(a: Scalar, b: Scalar) -> Scalar:
    """Returns the larger of `a` and `b`; of equals, `a`; NaN where either is NaN."""
    more = b > a
    if type(more) is Formula:
        return _chosen(symbolic_max, (a, b))
    if more:
        return b
    return a if a >= b else a + b


def smallest(*values: Scalar, made_of: Sequence[Scalar] | None = None) -> Scalar:
    """Returns the smallest of several; NaN where any is NaN.

    Args:
        values: of which one is chosen.
        made_of: for Expressions, shorter ones that are NaN where a value is NaN; they
            are checked for NaN in place of the values.
    """
    total = sum(values)
    if type(total) is Expression:
        return _chosen(symbolic_min, values, made_of)
    # Python's `min` is faster, but misses NaN; the sum does not.
    no_nan = total == total  # noqa: PLR0124 - only NaN differs from itself.
    return min(values) if no_nan else functools.reduce(smaller, values)


def largest(*values: Scalar, made_of: Sequence[Scalar] | None = None) -> Scalar:
    """Returns the largest of several; as `smallest`."""
    total = sum(values)
    if type(total) is Expression:
        return _chosen(symbolic_max, values, made_of)
    no_nan = total == total  # noqa: PLR0124
    return max(values) if no_nan else functools.reduce(larger, values)


def _chosen(
    choice: Any, values: Sequence[Scalar], made_of: Sequence[Scalar] | None = None
) -> Scalar:
    """Returns Drake's `min` or `max` of several Expressions, NaN where any is NaN.

    Drake's returns its first argument where either is NaN, and so does a chain of them.
    So the first argument is NaN where any of the values is, and is never chosen
    otherwise: a sum of magnitudes. An `if_then_else` would contain all values twice.

    Args:
        choice: `symbolic_min` or `symbolic_max`.
        values: of which one is chosen.
        made_of: as for `smallest`.
    """
    constant = [value for value in values if _is_constant(value)]
    free = [value for value in values if not _is_constant(value)]
    chain = [*free, *constant]
    if made_of is not None:
        summands = [chain[-1], *made_of] if made_of else []
    else:
        summands = free if len(free) > 1 else []
    if summands:  # One of the values is among them, so their sum is never chosen.
        total = functools.reduce(operator.add, map(abs, summands))
        chain.insert(0, total if choice is symbolic_min else -total)
    return functools.reduce(choice, chain)


def _is_constant(value: Scalar) -> bool:
    if isinstance(value, Expression):
        return value.get_kind() == ExpressionKind.Constant
    return not isinstance(value, Variable)


def saturated(x: Scalar, limit: Scalar) -> Scalar:
    """Returns `x` clamped to `[-limit, limit]` (Petric & Zlajpah, eq. 11)."""
    return larger(smaller(x, limit), -limit)


def is_finite(x: Scalar) -> Any:
    """Returns whether `x` is neither infinite nor NaN; a formula for an `Expression`.

    Drake does not simplify this comparison away, unlike that of `x` with itself.
    """
    return abs(x) <= sys.float_info.max


def all_finite(values: Iterable[Scalar]) -> Scalar:
    """Returns 1 where all values are neither infinite nor NaN, else 0."""
    found: Scalar = 1.0
    for x in values:
        found = where(is_finite(x), found, 0.0)
    return found


def finite_or_zero(x: Scalar) -> Scalar:
    """Returns `x`, or 0 where it is infinite or not a number."""
    return where(is_finite(x), x, type(x)(0.0))


_ROUNDING = 1e-9
"""Rounding error of a sum of steps, as a share of one step."""


def nearer_to_rest(x: Scalar, step: float) -> Scalar:
    """Returns `x` one `step` nearer to 0, and 0 where at most one step is left.

    Rounding does not count: a whole number of steps from 0 takes exactly that many.
    """
    left = x - saturated(x, step)
    return where(abs(left) <= _ROUNDING * step, 0.0 * left, left)


def smoothstep(x: Scalar, lower: Scalar, upper: Scalar) -> Scalar:
    """Returns 0 up to `lower`, 1 from `upper` on, and a smooth cubic between."""
    s = larger(smaller((x - lower) / (upper - lower), 1.0), 0.0)
    return s * s * (3.0 - 2.0 * s)


def wrapped_angle(angle: Scalar) -> Scalar:
    """Returns the same angle [rad] between -pi and pi."""
    return atan2(sin(angle), cos(angle))
