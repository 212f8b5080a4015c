"""The field in slices, from the side and from above (Petric & Zlajpah, figs. 2, 3)."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from drake_mobman.base import Smoothing
from drake_mobman.base.velocity_field import VelocityField, field_on, field_velocity
from drake_mobman.figures.field.edges import (
    BODY,
    FORWARD,
    REACH,
    RETREAT,
    distances_of,
    edges,
)
from drake_mobman.figures.field.style import COLOURS, OUT_OF_REACH, RAYS, note
from drake_mobman.figures.style import SMALL, TEXT, finish, label_axes, new_figure
from drake_mobman.robot_model import Reach

HEIGHTS = (0.8, 0.3)
"""Of the slices seen from above [m], as in the paper."""

PIXELS = 400
"""Of a slice, along either side."""

_VIEW = 1.05  # Half a slice's side, in reaches.
_ARROW = 0.09  # Length of the arrow for K_omega [m].
_RINGS = np.array([0.47, 0.61, 0.75, 0.89])  # Radii of the arrows, in reaches.
_SPOKES = np.radians(np.arange(-180, 180, 15) + 7.5)  # Their bearings; none is pi.
_NOSE = np.array([[0.09, -0.05, -0.05], [0.0, 0.06, -0.06]])  # Of the base [m].
_SLICE: dict[str, Any] = {"color": "0.35", "lw": 0.8, "ls": (0, (8, 4))}
_EDGES: dict[str, dict[str, Any]] = {
    REACH: {"color": "0.25", "lw": 1.2},
    FORWARD: {"color": "#a04000", "lw": 1.1, "ls": (0, (5, 2))},
    RETREAT: {"color": "#3b1f6b", "lw": 1.1, "ls": (0, (5, 2))},
    BODY: {"color": "#3b1f6b", "lw": 1.2},
}


def draw_side(
    params: VelocityField, reach: Reach, smoother: Smoothing, pixels: int = PIXELS
) -> Figure:
    """Draws v [m/s] over x and z in B [m], at the shoulder's y (fig. 2)."""
    figure = new_figure(4.9)
    axes = figure.subplots()
    x, z = np.meshgrid(
        _side(reach.ahead, reach, pixels), _side(reach.l_0, reach, pixels)
    )
    points = np.stack([x, reach.aside + 0 * x, z], axis=-1)
    image = _draw_speed(axes, points, (0, 2), params, reach, smoother)
    for label, edge in edges(params, reach).items():
        axes.plot(edge[:, 0], edge[:, 2], **_EDGES[label], label=label)
    for height in HEIGHTS:
        axes.axhline(height, **_SLICE)
        at_right = axes.get_yaxis_transform()
        note(axes, f"$z$ = {height:g} m", (1, height), (-4, 3), at_right, ha="right")
    axes.plot(reach.ahead, reach.l_0, "o", color="white", ms=3.5)
    shoulder = reach.ahead, reach.l_0
    note(axes, "shoulder", shoulder, (0, -11), ha="center", color="white")
    axes.set_aspect("equal", adjustable="datalim")
    label_axes(axes, "$x$ [m]", "$z$ [m]")
    axes.grid(visible=False)
    _draw_scale(figure, image, [axes], smoother)
    at = f"at $y$ = {reach.aside:g}"
    return finish(figure, f"The field from the side, {at}, {params.law} law")


def draw_top(
    params: VelocityField, reach: Reach, smoother: Smoothing, pixels: int = PIXELS
) -> Figure:
    """Draws v [m/s] and omega [rad/s] over x and y in B [m], at `HEIGHTS` (fig. 3).

    Arrows show in which direction and how fast the base turns.
    """
    figure = new_figure(3.6)
    panels = figure.subplots(1, len(HEIGHTS), sharey=True)
    x, y = np.meshgrid(
        _side(reach.ahead, reach, pixels), _side(reach.aside, reach, pixels)
    )
    for axes, height, letter in zip(panels, HEIGHTS, "ab", strict=True):
        points = np.stack([x, y, height + 0 * x], axis=-1)
        image = _draw_speed(axes, points, (0, 1), params, reach, smoother)
        for label, edge in edges(params, reach, height).items():
            axes.plot(edge[:, 0], edge[:, 1], **_EDGES[label], label=label)
        arrows = _draw_turning(axes, height, params, reach)
        axes.fill(*_NOSE, color="0.2", ec="white", lw=0.6)
        label_axes(axes, "$x$ [m]", "$y$ [m]" if letter == "a" else "", letter)
        axes.grid(visible=False)
        note(axes, f"$z$ = {height:g} m", (x.min(), y.max()), (3, -9))
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


def _side(middle: float, reach: Reach, pixels: int) -> np.ndarray:
    """Returns where the pixels of a slice are along one of its sides [m]."""
    return middle + _VIEW * reach.r_f * np.linspace(-1, 1, pixels)


def _draw_speed(
    axes: Axes,
    points: np.ndarray,
    seen: tuple[int, int],
    params: VelocityField,
    reach: Reach,
    smoother: Smoothing,
) -> Any:
    """Draws v at `points` (n, n, 3) in B, over two of their coordinates.

    Speeds beyond those that the base is sent have the same colour.
    """
    out = np.linalg.norm(points - [reach.ahead, reach.aside, reach.l_0], axis=-1)
    within = (out <= reach.r_f) & (points[..., 2] >= 0)
    v = np.full(within.shape, np.nan)
    v[within] = field_on(points[within], params, reach)[0]
    (left, bottom), (right, top) = points[0, 0, list(seen)], points[-1, -1, list(seen)]
    n = len(points)
    x, y = (right - left) / (2 * n - 2), (top - bottom) / (2 * n - 2)
    axes.set_facecolor(OUT_OF_REACH)
    return axes.imshow(
        v,
        cmap=COLOURS,
        norm=Normalize(-smoother.max_speed, smoother.max_speed),
        origin="lower",
        extent=(left - x, right + x, bottom - y, top + y),  # To the pixels' edges.
        interpolation="nearest",
    )


def _around(reach: Reach, r: Any, phi: Any, height: float) -> Any:
    """Returns points (N, 3) [m] at distances and bearings from the shoulder's axis."""
    x, y = reach.ahead + r * np.cos(phi), reach.aside + r * np.sin(phi)
    return np.stack([x, y, height + 0 * r], axis=1)


def _draw_turning(
    axes: Axes, height: float, params: VelocityField, reach: Reach
) -> Any:
    """Draws omega as arrows about B, and the bearings of the rotation zone.

    Returns the arrows.
    """
    for edge in (params.phi_min, params.phi_max):
        for side in (edge, -edge):
            s = np.linspace(params.b_d, 2 * reach.r_f, 721)
            ray = _around(reach, s, side + 0 * s, height)
            ray = ray[distances_of(ray, params, reach)[0] >= 0]
            axes.plot(ray[:, 0], ray[:, 1], **RAYS)
    r, phi = (x.ravel() for x in np.meshgrid(_RINGS * reach.r_f, _SPOKES))
    points = _around(reach, r, phi, height)
    omega = np.array([field_velocity(p, params, reach)[1] for p in points.tolist()])
    shown = (distances_of(points, params, reach)[0] > 0) & (omega != 0)
    points, omega = points[shown], omega[shown]
    x, y = points[:, 0], points[:, 1]
    out = np.hypot(x, y)
    return axes.quiver(
        x,
        y,
        -omega * y / out,
        omega * x / out,
        angles="xy",
        scale_units="xy",
        scale=(params.K_omega or 1.0) / _ARROW,
        pivot="mid",
        width=0.005,
        color="0.2",
    )


def _draw_scale(figure: Figure, image: Any, panels: Any, smoother: Smoothing) -> None:
    bar = figure.colorbar(image, ax=panels, extend="both", aspect=28, pad=0.02)
    limits = smoother.limits()
    most = "" if limits.follows_at_once else f", limited to ±{limits.max_speed:g}"
    bar.set_label(f"$v$ [m/s]{most}", fontsize=TEXT)
    bar.ax.tick_params(labelsize=SMALL)
