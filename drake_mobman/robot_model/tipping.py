"""When a robot on wheels tips over: its zero-moment point leaves its support polygon.

The zero-moment point is where the floor's force acts. Wheels and casters can only push,
so it lies in the polygon of their contacts; on an edge, all others lift.
"""

import dataclasses as dc
from typing import Any

import numpy as np
from pydrake.geometry.optimization import HPolyhedron, VPolytope

from drake_mobman.scalars import Scalar, Vector


@dc.dataclass(frozen=True)
class SupportPolygon:
    """The convex hull of where a robot touches the floor, in B: A p <= b."""

    A: np.ndarray  # Normals of its edges, outward, each of length 1 (K, 2).
    b: np.ndarray  # Distances of its edges from B (K,) [m].

    @classmethod
    def of(cls, points: Any) -> "SupportPolygon":
        """Returns the polygon of points in B (N, 2) [m], three at least, not in line.

        Raises:
            RuntimeError: where they have no area between them.
        """
        hull = HPolyhedron(VPolytope(np.asarray(points, dtype=float).T))
        lengths = np.linalg.norm(hull.A(), axis=1)
        return cls(hull.A() / lengths[:, None], hull.b() / lengths)

    def inside(self, p: np.ndarray) -> np.ndarray:
        """Returns how far points (N, 2) are inside (N,) [m]; below zero outside."""
        inside: np.ndarray = np.min(self.b - p @ self.A.T, axis=1)
        return inside


def zero_moment_point(p_BC: Vector, a_BC: Vector, g_B: Vector) -> tuple[Scalar, Scalar]:
    """Returns where on the floor the whole robot's weight and inertia act, in B [m].

    p - (h / f_z) f for a centre of mass C above p at height h, with f = g - a: f has no
    moment about that point. Turning of the robot's parts about C is left out.

    Args:
        p_BC: position of the centre of mass in B (3,) [m].
        a_BC: its acceleration in W, in B's axes (3,) [m/s^2].
        g_B: gravity in B's axes (3,) [m/s^2].
    """
    f_x, f_y, f_z = (g - a for g, a in zip(g_B, a_BC, strict=True))
    x, y, h = p_BC
    return x - h * f_x / f_z, y - h * f_y / f_z
