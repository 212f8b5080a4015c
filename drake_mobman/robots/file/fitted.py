"""The smallest box, cylinder or sphere around a mesh, in its own axes."""

from typing import NamedTuple

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from drake_mobman.scalars import Matrix

_THIN = 1e-4
"""Least size of a shape [m]: Drake takes none without volume."""


class Fit(NamedTuple):
    """A primitive shape."""

    kind: str  # `box`, `cylinder` or `sphere`.
    size: dict[str, str]  # By attribute, as URDF has them.
    X_MG: RigidTransform  # Its pose in the axes of the mesh.
    volume: float  # [m^3].


def fitted(points: Matrix) -> Fit | None:
    """Returns the smallest primitive that holds points (N, 3) [m]; None without any.

    A box or a cylinder lies along the axes: makers draw links along them.
    """
    if not len(points):
        return None
    low, high = points.min(axis=0), points.max(axis=0)
    centre, size = (low + high) / 2, np.maximum(high - low, _THIN)
    away = points - centre
    return min(
        _box(centre, size),
        _sphere(centre, away),
        *(_cylinder(centre, size, away, axis) for axis in range(3)),
        key=lambda fit: fit.volume,
    )


def _box(centre: Matrix, size: Matrix) -> Fit:
    text = " ".join(f"{x:.9g}" for x in size)
    X = RigidTransform(centre)
    return Fit("box", {"size": text}, X, float(np.prod(size)))


def _sphere(centre: Matrix, away: Matrix) -> Fit:
    radius = max(float(np.max(np.linalg.norm(away, axis=1))), _THIN)
    volume = 4 / 3 * np.pi * radius**3
    return Fit("sphere", {"radius": f"{radius:.9g}"}, RigidTransform(centre), volume)


def _cylinder(centre: Matrix, size: Matrix, away: Matrix, axis: int) -> Fit:
    across = np.delete(away, axis, axis=1)
    radius = max(float(np.max(np.linalg.norm(across, axis=1))), _THIN)
    along = np.eye(3)[axis]
    X = RigidTransform(RotationMatrix.MakeFromOneVector(along, 2), centre)
    text = {"radius": f"{radius:.9g}", "length": f"{size[axis]:.9g}"}
    return Fit("cylinder", text, X, float(np.pi * radius**2 * size[axis]))
