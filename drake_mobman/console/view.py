"""The robot in 3D as it is now, in Meshcat."""

import logging
import threading
from collections.abc import Collection
from typing import Any

import numpy as np
from pydrake.geometry import Meshcat, MeshcatParams, Rgba, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.tree import BodyIndex
from pydrake.visualization import VisualizationConfig

from drake_mobman import signals
from drake_mobman.console.session import LiveSession, Snapshot
from drake_mobman.robots.model import drawn_plant
from drake_mobman.runs.scenario import AnyScenario

PERIOD = 1 / 30
"""Between two pictures, at least [s]."""

DRAGS = hasattr(VisualizationConfig, "mouse_interaction_stiffness")
"""Whether Meshcat knows of Ctrl + drag, as it does from Drake 1.57 on."""

_WORLD = "/world"
"""Path of all that stands in the world, but for what may be dragged."""

_DRAGGED = "/drake"
"""Path of what may be dragged there: Meshcat looks nowhere else."""

_STILL = 1e-4
"""By how much a picture may be wrong [m, rad]."""

_FLOOR, _CELL = 6.0, 0.5
"""How far the floor is drawn around the base, and the width of its cells [m]."""

_STEP = 0.02
"""How far base or hand go before their path is drawn on [m]."""

_KEPT = 400
"""Points of a path that are drawn."""


class View:
    """A picture of the robot, outside of the simulation: it changes nothing there.

    The world moves under the robot, so that it never leaves the picture, however one
    turns and zooms that. All calls come from the thread that made `meshcat`.

    Args:
        scenario: whose robot is shown.
        meshcat: where.
        draggable: names of bodies that may be dragged.
    """

    def __init__(
        self,
        scenario: AnyScenario,
        meshcat: Meshcat,
        draggable: Collection[str] = (),
    ) -> None:
        self._meshcat = meshcat
        plant, scene_graph = drawn_plant(scenario.robot)
        self._plant, self._context = plant, plant.CreateDefaultContext()
        # All but the world.
        bodies = [plant.get_body(BodyIndex(i)) for i in range(1, plant.num_bodies())]
        # Not by a `MeshcatVisualizer`: in a diagram, Python would let go of it and of
        # `meshcat` whenever it likes and in any thread, which ends the process.
        inspector = scene_graph.model_inspector()
        paths = {
            body: f"{_DRAGGED if body.name() in draggable else _WORLD}/{body.name()}"
            for body in bodies
        }
        self._drawn = {
            body: path
            for body, path in paths.items()
            if _draw_body(plant, body, inspector, meshcat, path)
        }
        self._paths = {
            "base_path": _Path(Rgba(0.45, 0.45, 0.45)),
            "hand_path": _Path(Rgba(0.1, 0.55, 0.75)),
        }
        self._time = 0.0
        self._shown: Any = np.inf  # What the picture shows.
        _furnish(meshcat, scenario.workspace.l_max)

    def show(self, snapshot: Snapshot) -> None:
        """Draws the robot as it is in a snapshot."""
        pose = snapshot.signals.get(signals.BASE_POSE)
        if pose is None:
            return
        q = np.array([*pose, *snapshot.signals[signals.ARM_POSITION]])
        guide = np.array(snapshot.signals.get(signals.HAND_POSITION, ()))
        if np.allclose([*q, *guide], self._shown, rtol=0, atol=_STILL):
            return  # To draw takes the browser's time, where it has no graphics card.
        self._shown = [*q, *guide]
        self._plant.SetPositions(self._context, q)
        for body, path in self._drawn.items():
            X_WB = self._plant.EvalBodyPoseInWorld(self._context, body)
            self._meshcat.SetTransform(path, X_WB)
        self._scroll(*pose[:2])
        if snapshot.time < self._time:  # It has been started over.
            self._forget_paths()
        self._time = snapshot.time
        hand = self._plant.GetFrameByName("tool").CalcPoseInWorld(self._context)
        self._draw_path("hand_path", list(hand.translation()))
        self._draw_path("base_path", [*pose[:2], 0.005])
        if guide.size:
            self._draw_guide(guide)

    def _scroll(self, x: float, y: float) -> None:
        """Moves the world so that the base is in the middle."""
        for path in (_WORLD, _DRAGGED):
            self._meshcat.SetTransform(path, RigidTransform([-x, -y, 0.0]))
        cell = [-(x % _CELL), -(y % _CELL), 0.0]
        self._meshcat.SetTransform("floor", RigidTransform(cell))

    def _draw_path(self, name: str, point: list[float]) -> None:
        path = self._paths[name]
        if path.goes_on(point):
            points = np.array(path.points).T
            self._meshcat.SetLine(f"{_WORLD}/{name}", points, 3, path.color)

    def _forget_paths(self) -> None:
        for name, path in self._paths.items():
            path.points.clear()
            self._meshcat.Delete(f"{_WORLD}/{name}")

    def _draw_guide(self, p_WH: Any) -> None:
        """Draws the hand that pulls."""
        path = f"{_WORLD}/guide"
        if not self._meshcat.HasPath(path):
            self._meshcat.SetObject(path, Sphere(0.045), Rgba(0.95, 0.45, 0.1, 0.6))
        self._meshcat.SetTransform(path, RigidTransform(p_WH))


def _furnish(meshcat: Meshcat, reach: float) -> None:
    """Draws the floor, and looks at where a robot of such a reach [m] will stand."""
    for path in ("/Axes", "/Grid"):
        meshcat.SetProperty(path, "visible", False)
    meshcat.SetProperty("/Background/<object>", "top_color", [0.90, 0.93, 0.97])
    meshcat.SetProperty("/Background/<object>", "bottom_color", [0.66, 0.71, 0.78])
    # In pieces of a cell: a line that goes on behind the camera is not always drawn.
    lines = np.arange(-_FLOOR, _FLOOR + _CELL / 2, _CELL)
    across, along = (x.ravel() for x in np.meshgrid(lines, lines[:-1]))
    flat = np.zeros(across.size)
    start = np.hstack([[across, along, flat], [along, across, flat]])
    end = np.hstack([[across, along + _CELL, flat], [along + _CELL, across, flat]])
    meshcat.SetLineSegments("floor", start, end, 1, Rgba(0.5, 0.55, 0.62))
    target = np.array([0.35 * reach, 0.0, 0.4])
    away = (0.7 + 0.45 * reach) * np.array([-0.5, -1.1, 0.75])
    meshcat.SetCameraPose(target + away, target)


def _draw_body(
    plant: Any, body: Any, inspector: Any, meshcat: Meshcat, path: str
) -> bool:
    """Draws what a body looks like; returns whether there is anything to see."""
    geometries = plant.GetVisualGeometriesForBody(body)
    for i, geometry in enumerate(geometries):
        part = f"{path}/{i}"
        properties = inspector.GetIllustrationProperties(geometry)
        color = properties.GetPropertyOrDefault("phong", "diffuse", Rgba(0.8, 0.8, 0.8))
        meshcat.SetObject(part, inspector.GetShape(geometry), color)
        meshcat.SetTransform(part, inspector.GetPoseInFrame(geometry))
    return bool(geometries)


class _Path:
    """Where something has been of late."""

    def __init__(self, color: Rgba) -> None:
        self.color = color
        self.points: list[list[float]] = []

    def goes_on(self, point: list[float]) -> bool:
        """Adds a point if it is far enough from the last; returns whether to draw."""
        if self.points and np.linalg.norm(np.subtract(point, self.points[-1])) < _STEP:
            return False
        self.points = [*self.points[1 - _KEPT :], point]
        return len(self.points) > 1


class Viewer:
    """Shows a session in Meshcat from a thread of its own, until it is closed.

    Meshcat is served to this machine alone.

    Args:
        session: that is shown.
    """

    def __init__(self, session: LiveSession) -> None:
        self.url = ""  # Of Meshcat.
        self._session = session
        self._closing, self._ready = threading.Event(), threading.Event()
        # Meshcat may be called only by the thread that made it.
        self._thread = threading.Thread(target=self._run, name="view", daemon=True)
        self._thread.start()
        self._ready.wait()

    def close(self) -> None:
        """Ends it."""
        self._closing.set()
        self._thread.join()

    def _run(self) -> None:
        try:
            meshcat = local_meshcat()
            draggable = self._session.draggable if DRAGS else ()
            view = View(self._session.scenario, meshcat, draggable)
            self.url = meshcat.web_url()
        finally:
            self._ready.set()  # Without a picture one still drives.
        shown: Any = None
        while not self._closing.wait(PERIOD):
            snapshot = self._session.snapshot()
            if snapshot is not shown and meshcat.GetNumActiveConnections():
                view.show(snapshot)
                shown = snapshot


def local_meshcat(port: int | None = None) -> Meshcat:
    """Returns a Meshcat that is served to this machine alone, without a word of it.

    Args:
        port: 0 or None for any that is free.

    Raises:
        RuntimeError: where the port cannot be had.
    """
    logging.getLogger("drake").setLevel(logging.WARNING)
    params = MeshcatParams(host="localhost", port=port, show_stats_plot=False)
    return Meshcat(params)
