"""The edges of the field's zones, where a slice cuts them."""

import math

import numpy as np

from drake_mobman.base.velocity_field import VelocityField, signed_distances
from drake_mobman.robot_model import Reach

REACH, BODY = "reach, $r_f$", "body, $b_d$"
FORWARD, RETREAT = r"forward, $\Delta_f$", r"retreat, $\Delta_r$"

_ROUNDING = 1e-9  # Of a point on the reach [m].


def edges(
    params: VelocityField, reach: Reach, height: float | None = None
) -> dict[str, np.ndarray]:
    """Returns points (N, 3) in B [m] on the edges of the zones, by the edge's name.

    They are NaN where an edge is out of reach, and where the retreat zone overrides the
    forward zone.

    Args:
        params: of the field.
        reach: of the arm.
        height: of a horizontal slice [m]; the slice is vertical, at the shoulder's y,
            unless given.
    """
    found = {}
    for label, radius, upright in (
        (REACH, reach.r_f, False),
        (FORWARD, reach.r_f - params.Delta_f, False),
        (RETREAT, params.b_d + params.Delta_r, True),
        (BODY, params.b_d, True),
    ):
        if height is None:
            points = _side_edge(radius, upright, reach)
        else:
            points = _top_edge(radius, upright, height, reach)
        d_f, d_r = distances_of(points, params, reach)
        hidden = (d_f < -_ROUNDING) | (points[:, 2] < 0)
        if label == FORWARD:
            hidden |= d_r < params.Delta_r
        found[label] = np.where(hidden[:, None], np.nan, points)
    return found


def _side_edge(radius: float, upright: bool, reach: Reach) -> np.ndarray:
    """Returns points (N, 3) at the shoulder's y, on a sphere or an upright capsule."""
    # Starting from below, so that a capsule begins and ends on the floor.
    t = np.linspace(-math.pi / 2, 3 * math.pi / 2, 721)
    x, rise = np.cos(t), np.sin(t)
    below = upright & (rise < 0)
    x = radius * np.where(below, np.sign(x), x)
    rise = np.where(below, reach.l_0, radius) * rise
    return np.stack([reach.ahead + x, reach.aside + 0 * x, reach.l_0 + rise], axis=1)


def _top_edge(radius: float, upright: bool, height: float, reach: Reach) -> np.ndarray:
    """Returns points (N, 3) at a height, on either; none if it ends below or above."""
    rise = height - reach.l_0
    if upright:
        rise = max(rise, 0.0)
    if abs(rise) > radius:
        return np.empty((0, 3))
    t, level = np.linspace(-math.pi, math.pi, 721), math.sqrt(radius**2 - rise**2)
    x, y = level * np.cos(t), level * np.sin(t)
    return np.stack([reach.ahead + x, reach.aside + y, height + 0 * x], axis=1)


def distances_of(points: np.ndarray, params: VelocityField, reach: Reach) -> np.ndarray:
    """Returns d_f and d_r (2, N) [m] at points (N, 3) in B."""
    return (
        np.array([signed_distances(p, reach, params.b_d) for p in points.tolist()])
        .reshape(-1, 2)
        .T
    )
