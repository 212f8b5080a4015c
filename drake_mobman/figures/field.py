"""The field about the base, under both laws: Petric & Zlajpah, figs. 2 and 3.

And what the paper lacks: how far from a hand that rests the base gets to be.
"""

import dataclasses as dc
import itertools
import math
from collections.abc import Iterator, Sequence
from string import ascii_lowercase
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure

from drake_mobman.base.smoother import Smoother, smoothed
from drake_mobman.base.unicycle import unicycle_rates
from drake_mobman.base.velocity_field import (
    VelocityField,
    field_on,
    field_velocity,
    signed_distances,
    yaw_rate,
)
from drake_mobman.figures.style import (
    BASE,
    COMMAND_LINE,
    HAND,
    SMALL,
    TEXT,
    finish,
    label_axes,
    new_figure,
)
from drake_mobman.robot_model import Reach

LAWS = ("printed", "projected")

HEIGHTS = (0.8, 0.3)
"""Of the slices that are seen from above [m], as in the paper."""

PIXELS = 400
"""Of a slice, along either side."""

BEARINGS = np.linspace(-math.pi, math.pi, 73)
"""From the base to a hand that rests, at the start [rad]."""

DURATION = 15.0
"""How long the base then has [s]."""

_PERIOD = 0.01  # Of the control loop [s].
_AT_REST = 1e-4  # Speed [m/s] or [rad/s] below which nothing more is to come.
_VIEW = 1.05  # Half a slice's side, in reaches.
_ARROW = 0.09  # Length of the arrow for K_omega [m].
_RINGS = np.array([0.47, 0.61, 0.75, 0.89])  # Of arrows, in reaches.
_SPOKES = np.radians(np.arange(-180, 180, 15) + 7.5)  # Between which none is pi.
_NOSE = np.array([[0.09, -0.05, -0.05], [0.0, 0.06, -0.06]])  # Of the base [m].
_ROUNDING = 1e-9  # Of a point on the reach [m].

_ORANGE, _PURPLE = "#fdb863", "#b2abd2"
# As in the paper: purple back, white at rest, orange forward.
_COLOURS = LinearSegmentedColormap.from_list(
    "field", ["#5e3c99", _PURPLE, "white", _ORANGE, "#e66101"]
)
_OUT_OF_REACH = "0.94"
_REACH, _BODY = "reach, $r_f$", "body, $b_d$"
_FORWARD, _RETREAT = r"forward, $\Delta_f$", r"retreat, $\Delta_r$"
_ROTATION = r"rotation, $\varphi_\mathrm{min}$, $\varphi_\mathrm{max}$"
_EDGES: dict[str, dict[str, Any]] = {
    _REACH: {"color": "0.25", "lw": 1.2},
    _FORWARD: {"color": "#a04000", "lw": 1.1, "ls": (0, (5, 2))},
    _RETREAT: {"color": "#3b1f6b", "lw": 1.1, "ls": (0, (5, 2))},
    _BODY: {"color": "#3b1f6b", "lw": 1.2},
}
_RAYS: dict[str, Any] = {"color": BASE, "lw": 1.1, "ls": (0, (1, 1.2))}
_AMID: dict[str, Any] = {"ha": "center", "va": "center", "color": "0.3"}
_WAY: dict[str, Any] = {"color": HAND, "alpha": 0.3, "lw": 0}
_SLICE: dict[str, Any] = {"color": "0.35", "lw": 0.8, "ls": (0, (8, 4))}


def field_figures(
    params: VelocityField, reach: Reach, smoother: Smoother
) -> Iterator[tuple[str, Figure]]:
    """Yields the names and figures of a field under both laws, whatever its own is.

    Each is drawn when it is asked for.

    Args:
        params: of the field.
        reach: of the arm.
        smoother: what the base's commands go through.
    """
    fields = [dc.replace(params, law=law) for law in LAWS]
    for field in fields:
        yield f"field_side_{field.law}", draw_side(field, reach, smoother)
    for field in fields:
        yield f"field_top_{field.law}", draw_top(field, reach, smoother)
    yield "field_rest", draw_rest(fields, reach, smoother)


def draw_side(params: VelocityField, reach: Reach, smoother: Smoother) -> Figure:
    """Draws v [m/s] over x and z in B [m], at the shoulder's y (fig. 2)."""
    figure = new_figure(4.9)
    axes = figure.subplots()
    x, z = np.meshgrid(_side(reach.ahead, reach), _side(reach.l_0, reach))
    points = np.stack([x, reach.aside + 0 * x, z], axis=-1)
    image = _draw_speed(axes, points, (0, 2), params, reach, smoother)
    for label, edge in _edges(params, reach).items():
        axes.plot(edge[:, 0], edge[:, 2], **_EDGES[label], label=label)
    for height in HEIGHTS:
        axes.axhline(height, **_SLICE)
        at_right = axes.get_yaxis_transform()
        _note(axes, f"$z$ = {height:g} m", (1, height), (-4, 3), at_right, ha="right")
    axes.plot(reach.ahead, reach.l_0, "o", color="white", ms=3.5)
    shoulder = reach.ahead, reach.l_0
    _note(axes, "shoulder", shoulder, (0, -11), ha="center", color="white")
    axes.set_aspect("equal", adjustable="datalim")
    label_axes(axes, "$x$ [m]", "$z$ [m]")
    axes.grid(visible=False)
    _draw_scale(figure, image, [axes], smoother)
    at = f"at $y$ = {reach.aside:g}"
    return finish(figure, f"The field from the side, {at}, {params.law} law")


def draw_top(params: VelocityField, reach: Reach, smoother: Smoother) -> Figure:
    """Draws v [m/s] and omega [rad/s] over x and y in B [m], at `HEIGHTS` (fig. 3).

    An arrow shows which way and how fast the base turns.
    """
    figure = new_figure(3.6)
    panels = figure.subplots(1, len(HEIGHTS), sharey=True)
    x, y = np.meshgrid(_side(reach.ahead, reach), _side(reach.aside, reach))
    for axes, height, letter in zip(panels, HEIGHTS, "ab", strict=True):
        points = np.stack([x, y, height + 0 * x], axis=-1)
        image = _draw_speed(axes, points, (0, 1), params, reach, smoother)
        for label, edge in _edges(params, reach, height).items():
            axes.plot(edge[:, 0], edge[:, 1], **_EDGES[label], label=label)
        arrows = _draw_turning(axes, height, params, reach)
        axes.fill(*_NOSE, color="0.2", ec="white", lw=0.6)
        label_axes(axes, "$x$ [m]", "$y$ [m]" if letter == "a" else "", letter)
        axes.grid(visible=False)
        _note(axes, f"$z$ = {height:g} m", (x.min(), y.max()), (3, -9))
    panels[-1].quiverkey(
        arrows,
        0.96,
        1.05,
        params.K_omega,
        rf"$\omega$ = {params.K_omega:g} rad/s",
        labelpos="W",
        fontproperties={"size": SMALL},
    )
    _draw_scale(figure, image, panels, smoother)
    return finish(figure, f"The field from above, {params.law} law")


def draw_rest(
    fields: Sequence[VelocityField], reach: Reach, smoother: Smoother
) -> Figure:
    """Draws how far from a hand at rest the base gets, and where it ends [m].

    A row for each of `fields`, which differ in their law, and a column for each
    distance at the start, with T at the shoulder's height. Over the hand's bearing at
    the start [rad].
    """
    first = fields[0]
    retreat, forward = first.b_d + first.Delta_r, reach.r_f - first.Delta_f
    starts = {
        "retreat zone": retreat - first.Delta_r / 2,
        "forward zone": forward + first.Delta_f / 2,
        "arm stretched": reach.r_f,
    }
    figure = new_figure(4.4)
    panels = figure.subplots(len(fields), len(starts), sharex=True, sharey=True)
    cases = itertools.product(fields, starts.values())
    for axes, letter, (params, start) in zip(
        panels.flat, ascii_lowercase, cases, strict=False
    ):
        axes.set_facecolor(_OUT_OF_REACH)
        axes.axhspan(0, reach.r_f, color="white", lw=0)
        axes.axhspan(forward, reach.r_f, color=_ORANGE, alpha=0.4, lw=0)
        axes.axhspan(0, retreat, color=_PURPLE, alpha=0.4, lw=0)
        for phi in (params.phi_min, params.phi_max):
            axes.axvline(phi, **_RAYS, label=_ROTATION)
            axes.axvline(-phi, **_RAYS)
        _draw_distances(axes, start, params, reach, smoother)
        label_axes(axes, letter=letter)
    for axes, (where, start) in zip(panels[0], starts.items(), strict=True):
        axes.set_title(f"{where}, {start:.3g} m", fontsize=TEXT)
    for axes in panels[-1]:
        axes.set_xlabel(r"$\varphi$ at the start [rad]", fontsize=TEXT)
    for axes, params in zip(panels[:, 0], fields, strict=True):
        axes.set_ylabel(f"distance [m], {params.law}", fontsize=TEXT)
        for zone, height in (
            ("retreat", retreat / 2),
            ("forward", (forward + reach.r_f) / 2),
            ("out of reach", 1.3 * reach.r_f),
        ):
            _note(axes, zone, (-2.0, height), (0, 0), **_AMID)
    axes.set_xlim(-math.pi, math.pi)
    axes.set_ylim(bottom=0)
    axes.set_xticks(
        [-math.pi, -math.pi / 2, 0, math.pi / 2, math.pi],
        [r"$-\pi$", r"$-\pi/2$", "0", r"$\pi/2$", r"$\pi$"],
    )
    return finish(figure, "Distance from the shoulder to a hand that rests")


def _draw_distances(
    axes: Axes, start: float, params: VelocityField, reach: Reach, smoother: Smoother
) -> None:
    """Draws the distances [m] from `start` on, over the bearing at the start [rad]."""
    nearest, farthest, last = np.array(
        [distances(start, phi, params, reach, smoother) for phi in BEARINGS]
    ).T
    axes.axhline(start, **COMMAND_LINE, label="at the start")
    axes.fill_between(BEARINGS, nearest, farthest, label="on the way", **_WAY)
    axes.plot(BEARINGS, last, color=HAND, lw=1.4, label=f"after {DURATION:g} s")


def distances(
    start: float, phi: float, params: VelocityField, reach: Reach, smoother: Smoother
) -> tuple[float, float, float]:
    """Returns the smallest, largest and last distance [m] to a hand at rest.

    Level, from the shoulder to T at its height. The base is a unicycle in Euler steps,
    as the kinematic robot's.

    Args:
        start: distance at the start [m].
        phi: bearing of T at the start [rad].
        params: of the field.
        reach: of the arm.
        smoother: what the commands go through.
    """
    steps = (
        smoother.limits().max_acceleration * _PERIOD,
        smoother.limits().max_yaw_acceleration * _PERIOD,
    )
    limits = smoother.max_speed, smoother.max_yaw_rate
    hand = (
        reach.ahead + start * math.cos(phi),
        reach.aside + start * math.sin(phi),
    )
    x = y = theta = 0.0
    sent = [0.0, 0.0]
    nearest = farthest = start
    for _ in range(round(DURATION / _PERIOD)):
        dx, dy, c, s = hand[0] - x, hand[1] - y, math.cos(theta), math.sin(theta)
        p_BT = c * dx + s * dy, c * dy - s * dx, reach.l_0
        distance = math.hypot(p_BT[0] - reach.ahead, p_BT[1] - reach.aside)
        nearest, farthest = min(nearest, distance), max(farthest, distance)
        raw = field_velocity(p_BT, params, reach)
        if not smoother.limits().follows_at_once:
            sent = [
                smoothed(u, to, smoother.smoothing, step, limit)
                for u, to, step, limit in zip(sent, raw, steps, limits, strict=True)
            ]
        else:
            sent = list(raw)
        if max(map(abs, (*raw, *sent))) < _AT_REST:
            break
        rates = unicycle_rates(theta, *sent)
        x, y, theta = (
            at + _PERIOD * rate for at, rate in zip((x, y, theta), rates, strict=True)
        )
    return nearest, farthest, distance


def _side(middle: float, reach: Reach) -> np.ndarray:
    """Returns where the pixels of a slice are along one of its sides [m]."""
    return middle + _VIEW * reach.r_f * np.linspace(-1, 1, PIXELS)


def _draw_speed(
    axes: Axes,
    points: np.ndarray,
    seen: tuple[int, int],
    params: VelocityField,
    reach: Reach,
    smoother: Smoother,
) -> Any:
    """Draws v at `points` (PIXELS, PIXELS, 3) in reach, by two of their coordinates.

    Speeds beyond what the smoother lets pass have the same colour.
    """
    out = np.linalg.norm(points - [reach.ahead, reach.aside, reach.l_0], axis=-1)
    within = (out <= reach.r_f) & (points[..., 2] >= 0)
    v = np.full(within.shape, np.nan)
    v[within] = field_on(points[within], params, reach)[0]
    (left, bottom), (right, top) = points[0, 0, list(seen)], points[-1, -1, list(seen)]
    x, y = (right - left) / (2 * PIXELS - 2), (top - bottom) / (2 * PIXELS - 2)
    axes.set_facecolor(_OUT_OF_REACH)
    return axes.imshow(
        v,
        cmap=_COLOURS,
        norm=Normalize(-smoother.max_speed, smoother.max_speed),
        origin="lower",
        extent=(left - x, right + x, bottom - y, top + y),  # To the pixels' rims.
        interpolation="nearest",
    )


def _edges(
    params: VelocityField, reach: Reach, height: float | None = None
) -> dict[str, np.ndarray]:
    """Returns the edges' points (N, 3) in B [m], at the shoulder's y or at a height.

    They are NaN where an edge is out of reach, and where the forward zone gives way to
    the retreat zone.
    """
    edges = {}
    for label, radius, upright in (
        (_REACH, reach.r_f, False),
        (_FORWARD, reach.r_f - params.Delta_f, False),
        (_RETREAT, params.b_d + params.Delta_r, True),
        (_BODY, params.b_d, True),
    ):
        if height is None:
            points = _side_edge(radius, upright, reach)
        else:
            points = _top_edge(radius, upright, height, reach)
        d_f, d_r = _signed_distances(points, params, reach)
        hidden = (d_f < -_ROUNDING) | (points[:, 2] < 0)
        if label == _FORWARD:
            hidden |= d_r < params.Delta_r
        edges[label] = np.where(hidden[:, None], np.nan, points)
    return edges


def _side_edge(radius: float, upright: bool, reach: Reach) -> np.ndarray:
    """Returns points (N, 3) of a sphere at its y, or of an upright capsule."""
    # From below and round, so that a capsule begins and ends on the floor.
    t = np.linspace(-math.pi / 2, 3 * math.pi / 2, 721)
    x, rise = np.cos(t), np.sin(t)
    below = upright & (rise < 0)
    x = radius * np.where(below, np.sign(x), x)
    rise = np.where(below, reach.l_0, radius) * rise
    return np.stack([reach.ahead + x, reach.aside + 0 * x, reach.l_0 + rise], axis=1)


def _top_edge(radius: float, upright: bool, height: float, reach: Reach) -> np.ndarray:
    """Returns points (N, 3) of either at a height; none where it has none."""
    rise = height - reach.l_0
    if upright:
        rise = max(rise, 0.0)
    if abs(rise) > radius:
        return np.empty((0, 3))
    t, level = np.linspace(-math.pi, math.pi, 721), math.sqrt(radius**2 - rise**2)
    x, y = level * np.cos(t), level * np.sin(t)
    return np.stack([reach.ahead + x, reach.aside + y, height + 0 * x], axis=1)


def _draw_turning(
    axes: Axes, height: float, params: VelocityField, reach: Reach
) -> Any:
    """Draws omega as arrows about B, and the bearings where it begins and is full.

    Returns the arrows.
    """
    for edge in (params.phi_min, params.phi_max):
        for side in (edge, -edge):
            s = np.linspace(params.b_d, 2 * reach.r_f, 721)
            ray = np.stack([s * math.cos(side), s * math.sin(side), height + 0 * s], 1)
            ray = ray[_signed_distances(ray, params, reach)[0] >= 0]
            axes.plot(ray[:, 0], ray[:, 1], **_RAYS, label=_ROTATION)
    r, phi = (x.ravel() for x in np.meshgrid(_RINGS * reach.r_f, _SPOKES))
    points = np.stack([r * np.cos(phi), r * np.sin(phi), height + 0 * r], axis=1)
    omega = np.array([yaw_rate(x, params) for x in phi])
    shown = (_signed_distances(points, params, reach)[0] > 0) & (omega != 0)
    points, phi, omega = points[shown], phi[shown], omega[shown]
    return axes.quiver(
        points[:, 0],
        points[:, 1],
        -omega * np.sin(phi),
        omega * np.cos(phi),
        angles="xy",
        scale_units="xy",
        scale=(params.K_omega or 1.0) / _ARROW,
        pivot="mid",
        width=0.005,
        color="0.2",
    )


def _signed_distances(
    points: np.ndarray, params: VelocityField, reach: Reach
) -> np.ndarray:
    """Returns d_f and d_r (2, N) [m] at points (N, 3) in B."""
    return (
        np.array([signed_distances(p, reach, params.b_d) for p in points.tolist()])
        .reshape(-1, 2)
        .T
    )


def _note(
    axes: Axes,
    text: str,
    at: tuple[float, float],
    away: tuple[float, float],
    coordinates: Any = "data",
    **how: Any,
) -> None:
    """Writes `text`, `away` [pt] from a point."""
    axes.annotate(
        text,
        at,
        xycoords=coordinates,
        xytext=away,
        textcoords="offset points",
        fontsize=SMALL,
        **how,
    )


def _draw_scale(figure: Figure, image: Any, panels: Any, smoother: Smoother) -> None:
    bar = figure.colorbar(image, ax=panels, extend="both", aspect=28, pad=0.02)
    most = f", at most ±{smoother.max_speed:g} sent" if not smoother.limits().follows_at_once else ""
    bar.set_label(f"$v$ asked for [m/s]{most}", fontsize=TEXT)
    bar.ax.tick_params(labelsize=SMALL)
