"""The robot in 3D at some moments, a strip of pictures (Petric & Zlajpah, fig. 4).

In parallel projection: the shapes of its URDF, shaded, on the tiles of the floor.
"""

import itertools
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from pydrake.geometry import Box, Cylinder, SceneGraph, Shape, Sphere
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from drake_mobman import signals
from drake_mobman.analysis.motion import holding
from drake_mobman.figures.end_effector import moments, positions, while_held
from drake_mobman.figures.style import (
    BASE,
    COMMAND,
    HAND,
    TEXT,
    WIDTH,
    finish,
    law_of,
    name_of,
    new_figure,
)
from drake_mobman.robot_model import RobotDescription
from drake_mobman.simulation.simulate import Run

_COLUMNS = 4  # Of pictures in a strip.
_TILE = 0.5  # Of the floor [m].
_ARROW = 0.3  # Length that stands for the largest force [m].
_AIR = 0.08  # About the robot [m].


def _view(azimuth: float, elevation: float) -> np.ndarray:
    """Returns unit vectors to one's right, up and towards one (3, 3) in W.

    Args:
        azimuth: whence one looks [rad].
        elevation: how far down [rad].
    """
    c, s = np.cos(azimuth), np.sin(azimuth)
    right = np.array([-s, c, 0.0])
    towards = np.array(
        [np.cos(elevation) * c, np.cos(elevation) * s, np.sin(elevation)]
    )
    return np.array([right, np.cross(towards, right), towards])


_VIEW = _view(*np.radians([-60.0, 22.0]))
_LIGHT = np.array([-0.4, 0.75, 0.53])  # Whence it shines, as one sees it.


def draw_strip(run: Run) -> Figure:
    """Draws pictures of the robot at some moments, with hand and force [N] (fig. 4).

    In parallel projection. One who looks goes along with the robot; the floor's tiles
    and the paths of hand and base stand still.
    """
    log, q = run.log, positions(run)
    chosen = moments(run)
    solid = _Solid(run.scenario.robot)
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
        axes.plot(*hand.T, color=HAND, lw=0.8, alpha=0.5)
        axes.plot(*hand[: k + 1].T, color=HAND, lw=1.4, label="hand")
        axes.plot(*hand[k], "o", color=HAND, mec="white", ms=5)
        axes.plot([], [], color=COMMAND, lw=1.4, label="its force")
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
    """Returns how far right and up (..., 2) one sees points (..., 3) of W [m]."""
    return points @ _VIEW[:2].T


def _draw_floor(axes: Axes, centre: np.ndarray, size: float) -> None:
    """Draws the floor's tiles as far as `size` [m] from `centre` (2,), by W's axes."""
    marks = _TILE * np.arange(-np.ceil(size / _TILE), np.ceil(size / _TILE) + 1)
    near = _TILE * np.round(centre / _TILE)
    ends = marks[[0, -1]]
    along_x = [[(x, y, 0.0) for x in near[0] + ends] for y in near[1] + marks]
    along_y = [[(x, y, 0.0) for y in near[1] + ends] for x in near[0] + marks]
    lines = _seen(np.array(along_x + along_y))
    axes.add_collection(LineCollection(list(lines), color="0.85", lw=0.6, zorder=0))


class _Solid:
    """A robot's shapes as its URDF draws them."""

    def __init__(self, robot: RobotDescription) -> None:
        scene_graph = SceneGraph()
        self.plant = MultibodyPlant(0.0)
        self.plant.RegisterAsSourceForSceneGraph(scene_graph)
        (it,) = Parser(self.plant).AddModelsFromString(robot.urdf(), "urdf")
        self.plant.Finalize()
        self._context = self.plant.CreateDefaultContext()
        inspector = scene_graph.model_inspector()
        self._parts: list[tuple[Any, np.ndarray, list[float]]] = []
        for body in map(self.plant.get_body, self.plant.GetBodyIndices(it)):
            for shape in self.plant.GetVisualGeometriesForBody(body):
                faces = _faces(inspector.GetShape(shape))
                X_BG = inspector.GetPoseInFrame(shape)
                looks = inspector.GetIllustrationProperties(shape)
                rgba = looks.GetProperty("phong", "diffuse")
                colour = [rgba.r(), rgba.g(), rgba.b()]
                self._parts.append((body, _moved(X_BG, faces), colour))

    def seen(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns the faces (m, 4, 2) [m] that one sees at `q`, and their colours.

        Those behind come first, to be painted over.
        """
        self.plant.SetPositions(self._context, q)
        parts, paints = [], []
        for body, part, paint in self._parts:
            X_WB = self.plant.EvalBodyPoseInWorld(self._context, body)
            parts.append(_moved(X_WB, part) @ _VIEW.T)
            paints.append(np.tile(paint, (len(part), 1)))
        faces, colours = np.concatenate(parts), np.concatenate(paints)
        normals = np.cross(faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        light = 0.55 + 0.45 * np.clip(normals @ _LIGHT, 0.0, 1.0)
        order = np.argsort(faces[:, :, 2].mean(axis=1))
        order = order[normals[order, 2] > 0]
        return faces[order, :, :2], (light[:, None] * colours)[order]


def _draw_faces(axes: Axes, faces: np.ndarray, colours: np.ndarray) -> None:
    look: dict[str, Any] = {"edgecolors": "face", "lw": 0.2, "zorder": 1.5}
    axes.add_collection(PolyCollection(list(faces), facecolors=colours, **look))


def _moved(X: Any, faces: np.ndarray) -> np.ndarray:
    return faces @ X.rotation().matrix().T + X.translation()


def _faces(shape: Shape) -> np.ndarray:
    """Returns the faces (m, 4, 3) [m] of a box, a cylinder or a sphere.

    A ring about z goes from the bottom to the top, as wide as the shape is there. Seen
    from outside, a face's corners go counterclockwise.
    """
    corners, across, along = 32, np.array([0, 1, 1, 0]), np.array([-1, -1, 1, 1])
    if isinstance(shape, Box):
        corners = 4
        size = np.array([shape.width(), shape.depth(), shape.height()]) / 2
        size[:2] *= np.sqrt(2.0)  # A square's corners are that far out.
    elif isinstance(shape, Cylinder):
        size = np.array([shape.radius(), shape.radius(), shape.length() / 2])
    elif isinstance(shape, Sphere):
        size = np.full(3, shape.radius())
        rise = np.linspace(-np.pi / 2, np.pi / 2, 9)
        across, along = np.cos(rise), np.sin(rise)
    else:
        raise TypeError(f"cannot draw {shape}")
    turn = np.pi / corners + np.linspace(0.0, 2 * np.pi, corners + 1)
    ring = np.stack([np.cos(turn), np.sin(turn), np.ones_like(turn)], -1)
    rings = size * ring * np.stack([across, across, along], -1)[:, None]
    low, high = rings[:-1], rings[1:]
    quads = [low[:, :-1], low[:, 1:], high[:, 1:], high[:, :-1]]
    return np.stack(quads, axis=2).reshape(-1, 4, 3)
