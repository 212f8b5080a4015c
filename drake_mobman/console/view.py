"""The robot in 3D as it is now: what is drawn, and where it moves to.

Meshcat draws it. Where the console's page shows it, a browser is given what Meshcat has
drawn at the start, and told what moves: no Meshcat is served.
"""

import dataclasses as dc
import math
from collections.abc import Collection
from typing import Any, NamedTuple

import numpy as np
from pydrake.geometry import Meshcat, Rgba, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.tree import BodyIndex
from pydrake.visualization import VisualizationConfig

from drake_mobman import signals
from drake_mobman.console.session import Snapshot
from drake_mobman.meshcat import sealed_meshcat
from drake_mobman.robot_model.model import drawn_plant
from drake_mobman.scenario import AnyScenario, Guided

PERIOD = 1 / 30
"""Between two pictures, at least [s]."""

DRAGS = hasattr(VisualizationConfig, "mouse_interaction_stiffness")
"""Whether Meshcat knows of Ctrl + drag, as it does from Drake 1.57 on."""

# Paths begin at the root: Meshcat puts any other below what may be dragged.
_WORLD = "/world"
"""Path of all that stands in the world, but for what may be dragged."""

_DRAGGED = "/drake"
"""Path of what may be dragged there: Meshcat looks nowhere else."""

_FLOOR = "/floor"
"""Path of the floor, which goes with the base by whole cells."""

_GUIDE = f"{_WORLD}/guide"
"""Path of the hand that pulls."""

BASE_PATH, HAND_PATH = f"{_WORLD}/base_path", f"{_WORLD}/hand_path"
"""Paths of the lines along which base and hand have gone of late."""

LINES = {BASE_PATH: Rgba(0.45, 0.45, 0.45), HAND_PATH: Rgba(0.1, 0.55, 0.75)}
"""Their colors."""

_STILL = 1e-4
"""By how much a picture may be wrong [m, rad]."""

_WIDTH, _CELL = 6.0, 0.5
"""How far the floor is drawn around the base, and the width of its cells [m]."""

_STEP = 0.02
"""How far base or hand go before their line is drawn on [m]."""

_KEPT = 400
"""Points of a line that are drawn."""


class Line(NamedTuple):
    """Where something has gone of late."""

    made: int = 0  # Points that there have been, forgotten ones included.
    points: tuple[tuple[float, ...], ...] = ()  # (x, y, z) in W, the latest last [m].

    def gone_on(self, point: tuple[float, ...]) -> "Line":
        """Returns it with a point more, if that is far enough from the last one."""
        if self.points and math.dist(point, self.points[-1]) < _STEP:
            return self
        return Line(self.made + 1, (*self.points[1 - _KEPT :], point))

    def since(self, before: "Line") -> dict[str, Any]:
        """Returns how many of the last points before it keeps, and what it adds."""
        new = min(self.made - before.made, len(self.points))
        keep = len(self.points) - new
        return {"keep": keep, "add": np.round(self.points[keep:], 4).tolist()}


@dc.dataclass(frozen=True)
class Frame:
    """What moves in the picture, at one time; nothing in it changes any more."""

    # Poses (4, 4) by path, each in the frame of the path above it [m].
    poses: dict[str, Any] = dc.field(default_factory=dict)
    lines: dict[str, Line] = dc.field(default_factory=dict)  # By path; see `LINES`.

    def since(self, before: "Frame") -> "Frame":
        """Returns what is not as it was in the frame `before`."""
        poses = {
            path: X
            for path, X in self.poses.items()
            if not (path in before.poses and np.array_equal(X, before.poses[path]))
        }
        lines = {
            path: line
            for path, line in self.lines.items()
            if line is not before.lines.get(path)
        }
        return Frame(poses, lines)

    def message(self, before: "Frame") -> dict[str, Any]:
        """Returns what a browser that shows `before` is told: matrices by columns."""
        news = self.since(before)
        poses = {
            path: np.round(X, 6).ravel(order="F").tolist()
            for path, X in news.poses.items()
        }
        lines = {
            path: line.since(before.lines.get(path, Line()))
            for path, line in news.lines.items()
        }
        return {"poses": poses, "lines": lines}


class Picture:
    """A picture of the robot, outside of the simulation: it changes nothing there.

    The world moves under the robot, so that it never leaves the picture, however one
    turns and zooms that. All calls come from one thread.

    Args:
        scenario: whose robot is shown.
        draggable: names of bodies that may be dragged.
    """

    def __init__(self, scenario: AnyScenario, draggable: Collection[str] = ()) -> None:
        self._reach = scenario.workspace.l_max
        self._guided = isinstance(scenario, Guided)
        self._plant, self._scene_graph = drawn_plant(scenario.robot)
        self._context = self._plant.CreateDefaultContext()
        count = self._plant.num_bodies()
        bodies = [self._plant.get_body(BodyIndex(i)) for i in range(1, count)]
        self._paths = {
            body: f"{_DRAGGED if body.name() in draggable else _WORLD}/{body.name()}"
            for body in bodies
            if self._plant.GetVisualGeometriesForBody(body)
        }
        self._lines = {path: Line() for path in LINES}
        self._time = 0.0
        self._shown: Any = np.inf  # What the frame shows.
        self._frame = Frame()

    def draw(self, meshcat: Meshcat) -> None:
        """Draws all that a frame moves, and what stands still."""
        # Not by a `MeshcatVisualizer`: in a diagram, Python would let go of it and of
        # `meshcat` whenever it likes and in any thread, which ends the process.
        inspector = self._scene_graph.model_inspector()
        for body, path in self._paths.items():
            geometries = self._plant.GetVisualGeometriesForBody(body)
            for i, geometry in enumerate(geometries):
                _draw_geometry(inspector, geometry, meshcat, f"{path}/{i}")
        if self._guided:
            meshcat.SetObject(_GUIDE, Sphere(0.045), Rgba(0.95, 0.45, 0.1, 0.6))
        for path, color in LINES.items():
            meshcat.SetLine(path, np.zeros((3, 2)), 3, color)
        _furnish(meshcat, self._reach)

    def at(self, snapshot: Snapshot) -> Frame:
        """Returns what moves as it is in a snapshot; the last frame if nothing has."""
        pose = snapshot.signals.get(signals.BASE_POSE)
        if pose is None:
            return self._frame
        q = [*pose, *snapshot.signals[signals.ARM_POSITION]]
        guide = snapshot.signals.get(signals.HAND_POSITION, ())
        started_over = snapshot.time < self._time
        self._time = snapshot.time
        seen = np.array([*q, *guide])
        still = np.allclose(seen, self._shown, rtol=0, atol=_STILL)
        # To draw takes the browser's time, where it has no graphics card.
        if (still and not started_over) or not np.isfinite(seen).all():
            return self._frame
        self._shown = seen
        self._plant.SetPositions(self._context, q)
        poses = {
            path: self._plant.EvalBodyPoseInWorld(self._context, body)
            for body, path in self._paths.items()
        }
        if guide:
            poses[_GUIDE] = RigidTransform(guide)
        hand = self._plant.GetFrameByName("tool").CalcPoseInWorld(self._context)
        ends = {HAND_PATH: tuple(hand.translation()), BASE_PATH: (*pose[:2], 0.005)}
        for path, line in self._lines.items():
            begun = Line(line.made) if started_over else line
            self._lines[path] = begun.gone_on(ends[path])
        poses |= _scrolled(*pose[:2])
        matrices = {path: X.GetAsMatrix4() for path, X in poses.items()}
        self._frame = Frame(matrices, self._lines.copy())
        return self._frame


def picture_page(picture: Picture) -> str:
    """Returns a page, whole by itself, that shows a picture as it is drawn at first."""
    meshcat = sealed_meshcat()
    picture.draw(meshcat)
    return meshcat.StaticHtml()


def _scrolled(x: float, y: float) -> dict[str, RigidTransform]:
    """Returns poses of the world, and of the floor in it, with the base in the middle.

    The floor's lines stand still in the world, and its middle stays by the base.
    """
    world = RigidTransform([-x, -y, 0.0])
    cell = RigidTransform([-(x % _CELL), -(y % _CELL), 0.0])
    return {_WORLD: world, _DRAGGED: world, _FLOOR: cell}


def _furnish(meshcat: Meshcat, reach: float) -> None:
    """Draws the floor, and looks at where a robot of such a reach [m] will stand."""
    for path in ("/Axes", "/Grid"):
        meshcat.SetProperty(path, "visible", False)
    meshcat.SetProperty("/Background/<object>", "top_color", [0.90, 0.93, 0.97])
    meshcat.SetProperty("/Background/<object>", "bottom_color", [0.66, 0.71, 0.78])
    # In pieces of a cell: a line that goes on behind the camera is not always drawn.
    lines = np.arange(-_WIDTH, _WIDTH + _CELL / 2, _CELL)
    across, along = (x.ravel() for x in np.meshgrid(lines, lines[:-1]))
    flat = np.zeros(across.size)
    start = np.hstack([[across, along, flat], [along, across, flat]])
    end = np.hstack([[across, along + _CELL, flat], [along + _CELL, across, flat]])
    meshcat.SetLineSegments(_FLOOR, start, end, 1, Rgba(0.5, 0.55, 0.62))
    target = np.array([0.35 * reach, 0.0, 0.4])
    away = (0.7 + 0.45 * reach) * np.array([-0.5, -1.1, 0.75])
    meshcat.SetCameraPose(target + away, target)


def _draw_geometry(inspector: Any, geometry: Any, meshcat: Meshcat, path: str) -> None:
    properties = inspector.GetIllustrationProperties(geometry)
    color = properties.GetPropertyOrDefault("phong", "diffuse", Rgba(0.8, 0.8, 0.8))
    meshcat.SetObject(path, inspector.GetShape(geometry), color)
    meshcat.SetTransform(path, inspector.GetPoseInFrame(geometry))
