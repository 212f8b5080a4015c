"""A robot as shaded faces in parallel projection."""

import itertools
from typing import Any

import numpy as np
from pydrake.geometry import Box, Convex, Cylinder, Mesh, Rgba, Shape, Sphere
from pydrake.multibody.tree import BodyIndex

from drake_mobman.robot_model import RobotDescription
from drake_mobman.robot_model.model import drawn_plant


def view(azimuth: float, elevation: float) -> np.ndarray:
    """Returns the unit vectors right, up and towards the viewer (3, 3) in W.

    Args:
        azimuth: of the viewer [rad].
        elevation: of the viewer above the horizon [rad].
    """
    c, s = np.cos(azimuth), np.sin(azimuth)
    right = np.array([-s, c, 0.0])
    towards = np.array(
        [np.cos(elevation) * c, np.cos(elevation) * s, np.sin(elevation)]
    )
    return np.array([right, np.cross(towards, right), towards])


VIEW = view(*np.radians([-60.0, 22.0]))
"""From the right, ahead and above."""

_GREY = Rgba(0.7, 0.7, 0.7)
"""Of what has no colour."""

_LIGHT = np.array([-0.4, 0.75, 0.53])  # Towards the light: right, up, to the viewer.


class Solid:
    """The shapes of a robot's model; a mesh is drawn as its convex hull."""

    def __init__(self, robot: RobotDescription) -> None:
        self.plant, scene_graph = drawn_plant(robot)
        self._context = self.plant.CreateDefaultContext()
        inspector = scene_graph.model_inspector()
        self._parts: list[tuple[Any, np.ndarray, list[float]]] = []
        for index in range(self.plant.num_bodies()):
            body = self.plant.get_body(BodyIndex(index))
            for shape in self.plant.GetVisualGeometriesForBody(body):
                faces = _faces(inspector.GetShape(shape))
                X_BG = inspector.GetPoseInFrame(shape)
                looks = inspector.GetIllustrationProperties(shape)
                rgba = looks.GetPropertyOrDefault("phong", "diffuse", _GREY)
                colour = [rgba.r(), rgba.g(), rgba.b()]
                self._parts.append((body, _moved(X_BG, faces), colour))

    def seen(
        self, q: np.ndarray, axes: np.ndarray = VIEW
    ) -> tuple[np.ndarray, np.ndarray]:
        """Returns the visible faces (m, 4, 2) [m] at positions `q`, and their colours.

        Those in the back come first, to be painted over.

        Args:
            q: positions of the robot's plant.
            axes: right, up and towards the viewer, as `view` returns them.
        """
        self.plant.SetPositions(self._context, q)
        parts, paints = [], []
        for body, part, paint in self._parts:
            X_WB = self.plant.EvalBodyPoseInWorld(self._context, body)
            parts.append(_moved(X_WB, part) @ axes.T)
            paints.append(np.tile(paint, (len(part), 1)))
        faces, colours = np.concatenate(parts), np.concatenate(paints)
        normals = np.cross(faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        light = 0.55 + 0.45 * np.clip(normals @ _LIGHT, 0.0, 1.0)
        order = np.argsort(faces[:, :, 2].mean(axis=1))
        order = order[normals[order, 2] > 0]
        return faces[order, :, :2], (light[:, None] * colours)[order]


def _moved(X: Any, faces: np.ndarray) -> np.ndarray:
    return faces @ X.rotation().matrix().T + X.translation()


def _faces(shape: Shape) -> np.ndarray:
    """Returns the faces (m, 4, 3) [m] of a box, cylinder, sphere or a mesh's hull.

    A ring about z goes from the bottom to the top, as wide as the shape is there. Seen
    from outside, a face's corners go counterclockwise.
    """
    if isinstance(shape, Mesh | Convex):
        return _hull(shape.GetConvexHull())
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


def _hull(surface: Any) -> np.ndarray:
    """Returns the triangles (m, 4, 3) [m] of a convex surface, last corner twice."""
    points = np.array([surface.vertex(i) for i in range(surface.num_vertices())])
    corners = []
    for face in map(surface.element, range(surface.num_faces())):
        ring = [face.vertex(i) for i in range(face.num_vertices())]
        corners += [(ring[0], a, b, b) for a, b in itertools.pairwise(ring[1:])]
    return points[np.array(corners)]
