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
    Reach,
    VelocityField,
    field_on,
    field_velocity,
    signed_distances,
    yaw_rate,
)
from drake_mobman.runs.figures.style import (
    BASE,
    COMMAND_LINE,
    HAND,
    SMALL,
    TEXT,
    finish,
    label_axes,
    new_figure,
)

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

# As in the paper: purple back, white at rest, orange forward.
_COLOURS = LinearSegmentedColormap.from_list(
    "field", ["#5e3c99", "#b2abd2", "white", "#fdb863", "#e66101"]
)
_FORWARD, _RETREAT = "#a04000", "#3b1f6b"
_OUT_OF_REACH = "0.94"
_DASHED = (0, (5, 2))
_EDGES: dict[str, dict[str, Any]] = {
    "reach, $r_f$": {"color": "0.25", "lw": 1.2},
    r"forward, $\Delta_f$": {"color": _FORWARD, "lw": 1.1, "ls": _DASHED},
    r"retreat, $\Delta_r$": {"color": _RETREAT, "lw": 1.1, "ls": _DASHED},
    "body, $b_d$": {"color": _RETREAT, "lw": 1.2},
}
"""From the outermost inwards, as `_radii` has them."""
_RAYS: dict[str, Any] = {"color": BASE, "lw": 1.1, "ls": (0, (1, 1.2))}
_ROTATION_ZONE = r"rotation, $\varphi_\mathrm{min}$, $\varphi_\mathrm{max}$"
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
    """Draws v [m/s] over x and z in B [m], at y = 0 (fig. 2)."""
    figure = new_figure(4.9)
    axes = figure.subplots()
    x, z = np.meshgrid(_side(reach.ahead, reach), _side(reach.l_0, reach))
    points = np.stack([x, 0 * x, z], axis=-1)
    image = _draw_speed(axes, points, (0, 2), params, reach, smoother)
    edges = [_side_edge(*radius, reach) for radius in _radii(params, reach)]
    _draw_edges(axes, edges, (0, 2), params, reach)
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
    return finish(figure, f"The field from the side, at $y$ = 0, {params.law} law")


def draw_top(params: VelocityField, reach: Reach, smoother: Smoother) -> Figure:
    """Draws v [m/s] and omega [rad/s] over x and y in B [m], at `HEIGHTS` (fig. 3).

    An arrow shows which way and how fast the base turns.
    """
    figure = new_figure(3.6)
    panels = figure.subplots(1, len(HEIGHTS), sharey=True)
    x, y = np.meshgrid(_side(reach.ahead, reach), _side(0.0, reach))
    for axes, height, letter in zip(panels, HEIGHTS, "ab", strict=True):
        points = np.stack([x, y, height + 0 * x], axis=-1)
        image = _draw_speed(axes, points, (0, 1), params, reach, smoother)
        edges = [_top_edge(*radius, height, reach) for radius in _radii(params, reach)]
        _draw_edges(axes, edges, (0, 1), params, reach)
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
        "amid the retreat zone": retreat - first.Delta_r / 2,
        "amid the forward zone": forward + first.Delta_f / 2,
        "with the arm stretched": reach.r_f,
    }
    figure = new_figure(4.6)
    panels = figure.subplots(len(fields), len(starts), sharex=True, sharey=True)
    for axes, letter, (params, start) in zip(
        panels.flat,
        ascii_lowercase,
        itertools.product(fields, starts.values()),
        strict=False,
    ):
        near, far, end = np.array(
            [distances(start, phi, params, reach, smoother) for phi in BEARINGS]
        ).T
        axes.axhspan(
            forward, reach.r_f, label="forward zone", color="#fdb863", alpha=0.4, lw=0
        )
        axes.axhspan(0, retreat, label="retreat zone", color="#b2abd2", alpha=0.4, lw=0)
        for phi in (params.phi_min, params.phi_max):
            axes.axvline(phi, **_RAYS, label=_ROTATION_ZONE)
            axes.axvline(-phi, **_RAYS)
        axes.axhline(start, **COMMAND_LINE, label="at the start")
        axes.fill_between(
            BEARINGS, near, far, color=HAND, alpha=0.3, lw=0, label="on the way"
        )
        axes.plot(BEARINGS, end, color=HAND, lw=1.4, label=f"after {DURATION:g} s")
        label_axes(axes, letter=letter)
    for axes, (where, start) in zip(panels[0], starts.items(), strict=True):
        axes.set_title(f"{where}, {start:.3g} m", fontsize=TEXT)
    for axes in panels[-1]:
        axes.set_xlabel(r"$\varphi$ at the start [rad]", fontsize=TEXT)
    for axes, params in zip(panels[:, 0], fields, strict=True):
        axes.set_ylabel(f"distance [m], {params.law}", fontsize=TEXT)
    axes.set_xlim(-math.pi, math.pi)
    axes.set_ylim(bottom=0)
    axes.set_xticks(
        [-math.pi, -math.pi / 2, 0, math.pi / 2, math.pi],
        [r"$-\pi$", r"$-\pi/2$", "0", r"$\pi/2$", r"$\pi$"],
    )
    return finish(figure, "Distance from the shoulder to a hand that rests")


def distances(
    start: float, phi: float, params: VelocityField, reach: Reach, smoother: Smoother
) -> tuple[float, float, float]:
    """Returns the smallest, largest and last distance [m] to a hand at rest.

    Level, from the shoulder to T at its height. The base is the unicycle that the
    kinematic robot is.

    Args:
        start: distance at the start [m].
        phi: bearing of T at the start [rad].
        params: of the field.
        reach: of the arm.
        smoother: what the commands go through.
    """
    steps = (
        smoother.max_acceleration * _PERIOD,
        smoother.max_yaw_acceleration * _PERIOD,
    )
    limits = smoother.max_speed, smoother.max_yaw_rate
    hand = reach.ahead + start * math.cos(phi), start * math.sin(phi)
    x = y = theta = 0.0
    sent = [0.0, 0.0]
    nearest = farthest = start
    for _ in range(round(DURATION / _PERIOD)):
        dx, dy, c, s = hand[0] - x, hand[1] - y, math.cos(theta), math.sin(theta)
        p_BT = c * dx + s * dy, c * dy - s * dx, reach.l_0
        distance = math.hypot(p_BT[0] - reach.ahead, p_BT[1])
        nearest, farthest = min(nearest, distance), max(farthest, distance)
        raw = field_velocity(p_BT, params, reach)
        if smoother.enabled:
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
    out = np.linalg.norm(points - [reach.ahead, 0, reach.l_0], axis=-1)
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


def _radii(params: VelocityField, reach: Reach) -> list[tuple[float, bool]]:
    """Returns each edge's distance from the shoulder, or else from the capsule's axis.

    [m], and whether it is a capsule, upright from the floor.
    """
    return [
        (reach.r_f, False),
        (reach.r_f - params.Delta_f, False),
        (params.b_d + params.Delta_r, True),
        (params.b_d, True),
    ]


def _side_edge(radius: float, upright: bool, reach: Reach) -> np.ndarray:
    """Returns an edge's points (N, 3) at y = 0 in B [m]."""
    # From below and round, so that a capsule begins and ends on the floor.
    t = np.linspace(-math.pi / 2, 3 * math.pi / 2, 721)
    x, rise = np.cos(t), np.sin(t)
    below = upright & (rise < 0)
    x = radius * np.where(below, np.sign(x), x)
    rise = np.where(below, reach.l_0, radius) * rise
    return np.stack([reach.ahead + x, 0 * x, reach.l_0 + rise], axis=1)


def _top_edge(radius: float, upright: bool, height: float, reach: Reach) -> np.ndarray:
    """Returns an edge's points (N, 3) at a height in B [m]; none where it is not."""
    rise = height - reach.l_0
    if upright:
        rise = max(rise, 0.0)
    if abs(rise) > radius:
        return np.empty((0, 3))
    t, level = np.linspace(-math.pi, math.pi, 721), math.sqrt(radius**2 - rise**2)
    x, y = level * np.cos(t), level * np.sin(t)
    return np.stack([reach.ahead + x, y, height + 0 * x], axis=1)


def _draw_edges(
    axes: Axes,
    edges: Sequence[np.ndarray],
    seen: tuple[int, int],
    params: VelocityField,
    reach: Reach,
) -> None:
    """Draws `edges`, as `_EDGES` has them, but for what is out of reach.

    And but for the forward zone's where that gives way to the retreat zone.
    """
    for i, (label, line) in enumerate(_EDGES.items()):
        d_f, d_r = _signed_distances(edges[i], params, reach)
        hidden = (d_f < -_ROUNDING) | (edges[i][:, 2] < 0)
        if i == 1:
            hidden |= d_r < params.Delta_r
        drawn = np.where(hidden[:, None], np.nan, edges[i])
        axes.plot(*drawn[:, list(seen)].T, **line, label=label)


def _draw_turning(
    axes: Axes, height: float, params: VelocityField, reach: Reach
) -> Any:
    """Draws omega as arrows about B, and the bearings from where it is up to where.

    Returns the arrows.
    """
    for phi in (params.phi_min, params.phi_max):
        for side in (phi, -phi):
            s = np.linspace(params.b_d, 2 * reach.r_f, 721)
            ray = np.stack([s * math.cos(side), s * math.sin(side), height + 0 * s], 1)
            ray = ray[_signed_distances(ray, params, reach)[0] >= 0]
            axes.plot(ray[:, 0], ray[:, 1], **_RAYS, label=_ROTATION_ZONE)
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
    most = f"at most ±{smoother.max_speed:g} sent"
    bar.set_label(f"$v$ asked for [m/s], {most}", fontsize=TEXT)
    bar.ax.tick_params(labelsize=SMALL)
