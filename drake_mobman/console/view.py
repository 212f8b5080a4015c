"""The robot in 3D as it is now, drawn by Meshcat.

For the console's page no Meshcat is served: a browser gets the page that Meshcat makes
of its drawing at the start, and then only what moves.
"""

from collections.abc import Collection
from typing import Any

import numpy as np
from pydrake.geometry import Meshcat, Rgba, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.tree import BodyIndex
from pydrake.visualization import VisualizationConfig

from drake_mobman import signals
from drake_mobman.console.frame import Frame, Trail
from drake_mobman.console.snapshot import Snapshot
from drake_mobman.frames import frame
from drake_mobman.meshcat import offline_meshcat
from drake_mobman.robot_model.model import drawn_plant
from drake_mobman.scenario import AnyScenario

FRAME_PERIOD = 1 / 30
"""Shortest time between two frames [s]."""

CAN_DRAG = hasattr(VisualizationConfig, "mouse_interaction_stiffness")
"""Whether Meshcat supports Ctrl + drag, as it does from Drake 1.57 on."""

# Paths begin at the root: Meshcat puts any other below what may be dragged.
_WORLD = "/world"
"""Path of all that stands in the world, except for what may be dragged."""

_DRAGGABLE = "/drake"
"""Path of what may be dragged: Meshcat searches nowhere else."""

_FLOOR = "/floor"
"""Path of the floor, which moves with the base by whole cells."""

_HAND = f"{_WORLD}/guiding_hand"
"""Path of the hand that pulls."""

_BASE_TRAIL, _EE_TRAIL = f"{_WORLD}/base_trail", f"{_WORLD}/ee_trail"
"""Paths of the lines along which base and end effector have gone."""

TRAIL_COLORS = {_BASE_TRAIL: Rgba(0.45, 0.45, 0.45), _EE_TRAIL: Rgba(0.1, 0.55, 0.75)}

_TOLERANCE = 1e-4
"""Largest change that is not drawn [m, rad]."""

_WIDTH, _CELL = 6.0, 0.5
"""How far the floor is drawn around the base, and the width of its cells [m]."""


class Picture:
    """A picture of the robot, outside of the simulation, which it does not change.

    The base stays in the middle and the world moves under it, so that the robot never
    leaves the picture. All calls come from one thread.

    Args:
        scenario: whose robot is shown.
        names: of the signals in the snapshots; a hand is drawn where it has a position.
        draggable: names of bodies that may be dragged.
    """

    def __init__(
        self,
        scenario: AnyScenario,
        names: Collection[str],
        draggable: Collection[str] = (),
    ) -> None:
        self._reach = scenario.workspace.l_max
        self._has_hand = signals.HAND_POSITION in names
        self._plant, self._scene_graph = drawn_plant(scenario.robot)
        self._context = self._plant.CreateDefaultContext()
        self._paths = _paths_of_bodies(self._plant, draggable)
        self._trails = {path: Trail() for path in TRAIL_COLORS}
        self._time = 0.0
        self._shown: Any = np.inf  # The positions in the frame.
        self._frame = Frame()

    def draw(self, meshcat: Meshcat) -> None:
        """Draws all that a frame moves, and all that does not move."""
        # Not with a `MeshcatVisualizer`: in a diagram, Python may delete it and
        # `meshcat` at any time and in any thread, which ends the process.
        inspector = self._scene_graph.model_inspector()
        for body, path in self._paths.items():
            geometries = self._plant.GetVisualGeometriesForBody(body)
            for i, geometry in enumerate(geometries):
                _draw_geometry(inspector, geometry, meshcat, f"{path}/{i}")
        if self._has_hand:
            meshcat.SetObject(_HAND, Sphere(0.045), Rgba(0.95, 0.45, 0.1, 0.6))
        for path, color in TRAIL_COLORS.items():
            meshcat.SetLine(path, np.zeros((3, 2)), 3, color)
        _draw_surroundings(meshcat, self._reach)

    def at(self, snapshot: Snapshot) -> Frame:
        """Returns the frame of a snapshot; the last frame if nothing has moved."""
        pose = snapshot.signals.get(signals.BASE_POSE)
        if pose is None:
            return self._frame
        q = [*pose, *snapshot.signals[signals.ARM_POSITION]]
        hand = snapshot.signals.get(signals.HAND_POSITION, ())
        restarted = snapshot.time < self._time
        self._time = snapshot.time
        positions = np.array([*q, *hand])
        still = np.allclose(positions, self._shown, rtol=0, atol=_TOLERANCE)
        # Drawing takes the browser's time, where it has no graphics card.
        if (still and not restarted) or not np.isfinite(positions).all():
            return self._frame
        self._shown = positions
        self._plant.SetPositions(self._context, q)
        poses = {
            path: self._plant.EvalBodyPoseInWorld(self._context, body)
            for body, path in self._paths.items()
        }
        if hand:
            poses[_HAND] = RigidTransform(hand)
        tool = frame(self._plant, "tool").CalcPoseInWorld(self._context)
        ends = {_EE_TRAIL: tuple(tool.translation()), _BASE_TRAIL: (*pose[:2], 0.005)}
        for path, trail in self._trails.items():
            begun = Trail(trail.total) if restarted else trail
            self._trails[path] = begun.extended(ends[path])
        poses |= _scrolled(*pose[:2])
        matrices = {path: X.GetAsMatrix4() for path, X in poses.items()}
        self._frame = Frame(matrices, self._trails.copy())
        return self._frame


def _paths_of_bodies(plant: Any, draggable: Collection[str]) -> dict[Any, str]:
    """Returns a path of its own for each body that is drawn.

    Where a robot is made of several models, two bodies may have one name.
    """
    paths: dict[Any, str] = {}
    for body in map(plant.get_body, map(BodyIndex, range(1, plant.num_bodies()))):
        name = body.name()
        path = f"{_DRAGGABLE if name in draggable else _WORLD}/{name}"
        if path in paths.values():
            path = f"{_WORLD}/{body.scoped_name()}"
        if plant.GetVisualGeometriesForBody(body):
            paths[body] = path
    return paths


def picture_page(picture: Picture) -> str:
    """Returns a page that shows a picture at the start, and needs no other file."""
    meshcat = offline_meshcat()
    picture.draw(meshcat)
    return meshcat.StaticHtml()


def _scrolled(x: float, y: float) -> dict[str, RigidTransform]:
    """Returns the poses of world and floor that keep the base in the middle.

    The floor's lines stand still in the world, and its middle stays near the base.
    """
    world = RigidTransform([-x, -y, 0.0])
    cell = RigidTransform([-(x % _CELL), -(y % _CELL), 0.0])
    return {_WORLD: world, _DRAGGABLE: world, _FLOOR: cell}


def _draw_surroundings(meshcat: Meshcat, reach: float) -> None:
    """Draws the floor, and places the camera for a robot of such a reach [m]."""
    for path in ("/Axes", "/Grid"):
        meshcat.SetProperty(path, "visible", False)
    meshcat.SetProperty("/Background/<object>", "top_color", [0.90, 0.93, 0.97])
    meshcat.SetProperty("/Background/<object>", "bottom_color", [0.66, 0.71, 0.78])
    # In pieces of a cell: a line that ends behind the camera is not always drawn.
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
