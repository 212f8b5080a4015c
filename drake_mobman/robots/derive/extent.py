"""How far shapes reach from an axis and down, from a model's geometry."""

import math
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    Mesh,
    Sphere,
)

from drake_mobman.scalars import Matrix

_RIM = 72
"""Points on a circle: its radius is met to one part in 1000."""


class Placed(NamedTuple):
    """A shape, and where it is."""

    shape: Any
    X: Any  # Its pose, a `RigidTransform`.


class Extent(NamedTuple):
    """How far shapes reach in a frame."""

    radius: float  # From the z axis [m].
    lowest: float  # z of the lowest point [m].
    width: float  # Largest size across the z axis, of one shape [m].


def extents(shapes: Iterable[Placed]) -> list[Extent]:
    """Returns how far each shape reaches in the frame that it is placed in.

    Shapes without end, and files that Drake does not read, are left out.
    """
    found = []
    for placed in shapes:
        local, swelling = _points(placed.shape)
        if not len(local):
            continue
        points = local @ placed.X.rotation().matrix().T + placed.X.translation()
        size = np.ptp(points[:, :2], axis=0).max() + 2 * swelling
        radius = np.hypot(points[:, 0], points[:, 1]).max() + swelling
        lowest = points[:, 2].min() - swelling
        found.append(Extent(float(radius), float(lowest), float(size)))
    return found


def _points(shape: Any) -> tuple[Matrix, float]:
    """Returns points (N, 3) whose hull, swollen by a radius [m], is the shape's."""
    if isinstance(shape, Sphere):
        return np.zeros((1, 3)), shape.radius()
    if isinstance(shape, Capsule):
        return np.outer([-0.5, 0.5], [0, 0, shape.length()]), shape.radius()
    corners = next((f for kind, f in _CORNERS.items() if isinstance(shape, kind)), None)
    return (corners(shape) if corners else np.zeros((0, 3))), 0.0


def _of_box(box: Box) -> Matrix:
    return (np.array([*np.ndindex(2, 2, 2)]) - 0.5) * box.size()


def _of_cylinder(cylinder: Cylinder) -> Matrix:
    rim, half = cylinder.radius() * _circle(), cylinder.length() / 2
    return np.vstack([rim + np.array([0, 0, z]) for z in (-half, half)])


def _of_ellipsoid(ellipsoid: Ellipsoid) -> Matrix:
    polar = np.linspace(-math.pi / 2, math.pi / 2, _RIM // 2 + 1)
    rings = [math.cos(a) * _circle() + np.array([0, 0, math.sin(a)]) for a in polar]
    return np.vstack(rings) * [ellipsoid.a(), ellipsoid.b(), ellipsoid.c()]


def _of_mesh(mesh: Mesh | Convex) -> Matrix:
    try:
        hull = mesh.GetConvexHull()
    except RuntimeError:
        return np.zeros((0, 3))
    return np.array([hull.vertex(i) for i in range(hull.num_vertices())])


_CORNERS: dict[type, Callable[[Any], Matrix]] = {
    Box: _of_box,
    Cylinder: _of_cylinder,
    Ellipsoid: _of_ellipsoid,
    Mesh: _of_mesh,
    Convex: _of_mesh,
}


def _circle() -> Matrix:
    """Returns points (N, 3) around the unit circle about z."""
    angle = np.linspace(0.0, 2 * math.pi, _RIM, endpoint=False)
    return np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])


def shapes_of(
    plant: Any, inspector: Any, context: Any, body: Any, frame: Any
) -> tuple[list[Placed], str]:
    """Returns the shapes of a body in a frame, and what they are for.

    What collides, or else what is drawn.

    Args:
        plant: finalized, with geometry.
        inspector: of its `SceneGraph`.
        context: of the plant.
        body: whose shapes they are.
        frame: in which they are placed.
    """
    X = body.body_frame().CalcPose(context, frame)
    for kind, found in (
        ("collision", plant.GetCollisionGeometriesForBody(body)),
        ("visual", plant.GetVisualGeometriesForBody(body)),
    ):
        shapes = [
            Placed(inspector.GetShape(i), X @ inspector.GetPoseInFrame(i))
            for i in found
        ]
        if extents(shapes):
            return shapes, f"{kind} geometry"
    return [], "no geometry"
