"""Two links in a plane: forward, inverse and rates in closed form.

Kwon et al., eqs. 4-9. `theta_1` is the first link's angle above the plane's first
axis, `theta_2` the second link's angle from the first; the branch with
`theta_2 <= 0` is taken throughout, which the paper calls elbow-down.
"""

from collections.abc import Callable

from pydrake.math import atan2, cos, sin, sqrt

from drake_mobman.scalars import Scalar, larger, smaller, where

Reciprocal = Callable[[Scalar], Scalar]
"""Returns 1/s for s = sin(theta_2), as `damped_reciprocal` does."""

_NEAR_SINGULAR = 0.05
"""|sin theta_2| below which the rates are damped; outside, they are exact."""

_LEAST_SINE = 0.01
"""Least -sin theta_2 for the rates that are not damped."""

_ROUNDING = 1e-15
"""Tolerance at the border of the reach, as a share of the reach squared."""


def direction(theta_2: Scalar, upper: float, lower: float) -> Scalar:
    """Returns the angle [rad] of the tip's direction from the first link."""
    return atan2(lower * sin(theta_2), upper + lower * cos(theta_2))


def reach(theta_2: Scalar, upper: float, lower: float) -> Scalar:
    """Returns the distance [m] from the shoulder to the tip.

    By the half angle: exact to rounding also where the arm is folded up.
    """
    half = cos(0.5 * theta_2)
    return sqrt((upper - lower) ** 2 + 4 * upper * lower * half * half)


def elbow_angle(distance: Scalar, upper: float, lower: float) -> Scalar:
    """Returns theta_2 in [-pi, 0] for a tip `distance` [m] from the shoulder (eq. 4).

    By the half angle rather than by arccos, which loses half the digits where the
    arm is stretched or folded. A distance out of reach gives the nearest in reach.
    """
    squared = distance * distance
    beyond_fold = larger(squared - (upper - lower) ** 2, 0.0)
    short_of_stretch = larger((upper + lower) ** 2 - squared, 0.0)
    return -2 * atan2(sqrt(short_of_stretch), sqrt(beyond_fold))


def inverse(
    l: Scalar,
    z: Scalar,
    upper: float,
    lower: float,
) -> tuple[Scalar, Scalar]:
    """Returns theta_1, theta_2 that put the tip at `l` along, `z` up (eqs. 4, 5).

    A point out of reach gives the nearest in reach in the same direction.
    """
    theta_2 = elbow_angle(sqrt(l * l + z * z), upper, lower)
    return atan2(z, l) - direction(theta_2, upper, lower), theta_2


def forward(
    theta_1: Scalar, theta_2: Scalar, upper: float, lower: float
) -> tuple[Scalar, Scalar]:
    """Returns the tip's `l` along and `z` up [m]."""
    both = theta_1 + theta_2
    return (
        upper * cos(theta_1) + lower * cos(both),
        upper * sin(theta_1) + lower * sin(both),
    )


def damped_reciprocal(s: Scalar) -> Scalar:
    """Returns 1/s for s = sin(theta_2), damped where that is small."""
    damping = _NEAR_SINGULAR * larger(1 - (s / _NEAR_SINGULAR) ** 2, 0.0)
    return s / (s * s + damping * damping)


def undamped_reciprocal(s: Scalar) -> Scalar:
    """Returns 1/s for s = sin(theta_2) <= 0: 100 in magnitude at most."""
    return -1.0 / larger(-s, _LEAST_SINE)


def rates(
    theta_1: Scalar,
    theta_2: Scalar,
    v_l: Scalar,
    v_z: Scalar,
    upper: float,
    lower: float,
    reciprocal: Reciprocal = damped_reciprocal,
) -> tuple[Scalar, Scalar]:
    """Returns the rates of theta_1, theta_2 [rad/s] for a tip velocity [m/s] (eq. 9).

    Where the arm is nearly stretched or folded, 1/sin(theta_2) is damped: the rates
    stay finite, and the tip falls short of its command. `undamped_reciprocal` shows how
    fast they would be.
    """
    scale = reciprocal(sin(theta_2)) / (upper * lower)
    both = theta_1 + theta_2
    c_b, s_b = lower * cos(both), lower * sin(both)
    c, s = upper * cos(theta_1) + c_b, upper * sin(theta_1) + s_b
    return scale * (c_b * v_l + s_b * v_z), -scale * (c * v_l + s * v_z)


def is_near_singular(theta_2: Scalar) -> Scalar:
    """Returns 1 where `rates` is damped, else 0."""
    s = sin(theta_2)
    return where(s * s < _NEAR_SINGULAR**2, 1.0, 0.0)


def reach_margin(l: Scalar, z: Scalar, upper: float, lower: float) -> Scalar:
    """Returns how far the tip is inside the arm's reach [m^2], below 0 if outside."""
    squared = l * l + z * z
    fold, stretch = (upper - lower) ** 2, (upper + lower) ** 2
    return smaller(squared - fold, stretch - squared) + _ROUNDING * stretch
