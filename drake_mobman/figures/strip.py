"""A strip of pictures of the robot in 3D (Petric & Zlajpah, fig. 4)."""

import itertools
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from drake_mobman import signals
from drake_mobman.analysis.motion import holding
from drake_mobman.figures.law import law_of, name_of
from drake_mobman.figures.poses import moments, positions, while_held
from drake_mobman.figures.run_figure import RunFigure, logged
from drake_mobman.figures.solid import VIEW, Solid
from drake_mobman.figures.style import (
    BASE,
    COMMAND,
    END_EFFECTOR,
    TEXT,
    WIDTH,
    finish,
    new_figure,
)
from drake_mobman.simulation.run import Run

_COLUMNS = 4  # Of pictures in a strip.
_TILE = 0.5  # Of the floor [m].
_ARROW = 0.3  # Length that stands for the largest force [m].
_AIR = 0.08  # About the robot [m].


def draw_strip(run: Run) -> Figure:
    """Draws pictures of the robot at some moments, with hand and force [N].

    In parallel projection. The view moves along with the robot, over the tiles of the
    floor and the paths of hand and base.
    """
    log, q = run.log, positions(run)
    chosen = moments(run)
    solid = Solid(run.scenario.robot)
    pictures = [solid.seen(q[k]) for k in chosen]
    force = np.where(holding(run)[:, None], log[signals.HAND_FORCE], 0.0)
    hand = _seen(while_held(run, log[signals.HAND_POSITION]))
    tool = _seen(log[signals.TOOL_POSITION])
    largest = np.max(np.linalg.norm(force[chosen], axis=1))
    tip = _seen(log[signals.TOOL_POSITION] + _ARROW / max(largest, 1e-9) * force)
    base = _seen(q[:, :3] * [1.0, 1.0, 0.0])
    middle = (base + tool) / 2
    drawn = [
        np.vstack([faces.reshape(-1, 2), tip[k : k + 1]]) - middle[k]
        for k, (faces, _) in zip(chosen, pictures, strict=True)
    ]
    low, high = np.min(np.vstack(drawn), 0) - _AIR, np.max(np.vstack(drawn), 0) + _AIR
    width, height = high - low
    rows = -(-len(chosen) // _COLUMNS)
    figure = new_figure(0.6 + rows * WIDTH / _COLUMNS * height / width)
    panels = figure.subplots(rows, _COLUMNS, squeeze=False).ravel()
    for axes, k, picture in itertools.zip_longest(panels, chosen, pictures):
        axes.set_axis_off()
        if k is None:  # More panels than pictures.
            continue
        _draw_floor(axes, q[k, :2], np.max(high - low))
        axes.plot(*base[: k + 1].T, color=BASE, lw=1.4, label="base", zorder=1)
        _draw_faces(axes, *picture)
        axes.plot(*hand.T, color=END_EFFECTOR, lw=0.8, alpha=0.5)
        axes.plot(*hand[: k + 1].T, color=END_EFFECTOR, lw=1.4, label="hand")
        axes.plot(*hand[k], "o", color=END_EFFECTOR, mec="white", ms=5)
        axes.plot([], [], color=COMMAND, lw=1.4, label="force")
        if force[k].any():
            arrow = {"arrowstyle": "-|>", "color": COMMAND, "shrinkA": 0, "shrinkB": 0}
            arrow |= {"lw": 1.4, "mutation_scale": 7}
            axes.annotate("", tip[k], tool[k], arrowprops=arrow)
        note = f"{log['time'][k]:.1f} s,  {np.linalg.norm(force[k]):.1f} N"
        axes.set_title(note, fontsize=TEXT, loc="left", pad=2)
        axes.set_xlim(middle[k, 0] + low[0], middle[k, 0] + high[0])
        axes.set_ylim(middle[k, 1] + low[1], middle[k, 1] + high[1])
        axes.set_aspect("equal")
    name = name_of(law_of(run.scenario))
    return finish(figure, f"Guided by hand, {name}, floor in tiles of {_TILE:g} m")


def _seen(points: np.ndarray) -> np.ndarray:
    """Returns where points (..., 3) of W appear in the picture (..., 2) [m]."""
    return points @ VIEW[:2].T


def _draw_floor(axes: Axes, centre: np.ndarray, size: float) -> None:
    """Draws the floor's tiles, along W's axes, `size` [m] about `centre` (2,)."""
    marks = _TILE * np.arange(-np.ceil(size / _TILE), np.ceil(size / _TILE) + 1)
    near = _TILE * np.round(centre / _TILE)
    ends = marks[[0, -1]]
    along_x = [[(x, y, 0.0) for x in near[0] + ends] for y in near[1] + marks]
    along_y = [[(x, y, 0.0) for y in near[1] + ends] for x in near[0] + marks]
    lines = _seen(np.array(along_x + along_y))
    axes.add_collection(LineCollection(list(lines), color="0.85", lw=0.6, zorder=0))


def _draw_faces(axes: Axes, faces: np.ndarray, colours: np.ndarray) -> None:
    look: dict[str, Any] = {"edgecolors": "face", "lw": 0.2, "zorder": 1.5}
    axes.add_collection(PolyCollection(list(faces), facecolors=colours, **look))


STRIP = RunFigure("strip", draw_strip, logged(signals.HAND_FORCE))
