"""The axes of joints as lines, and where two of them meet or come nearest."""

from typing import Any, NamedTuple

import numpy as np

from drake_mobman.scalars import Matrix

_PARALLEL = 1e-3
"""Angle below which two axes count as parallel, which have no nearest points [rad]."""


class Line(NamedTuple):
    """A line in space."""

    point: Matrix  # On it (3,) [m].
    direction: Matrix  # Along it (3,), of length 1.


def axis(joint: Any, context: Any, frame: Any) -> Line:
    """Returns the axis of a revolute or prismatic joint in a frame of its plant.

    Args:
        joint: of a finalized plant; its direction is that of a positive rate.
        context: of the plant.
        frame: in whose axes the line is.
    """
    X = joint.frame_on_child().CalcPose(context, frame)
    turns = joint.type_name() == "revolute"
    along = joint.revolute_axis() if turns else joint.translation_axis()
    return Line(X.translation(), X.rotation() @ along)


def nearest_on(line: Line, other: Line) -> Matrix:
    """Returns the point (3,) of a line that is nearest to another [m].

    Where they are parallel, it is the line's own point.
    """
    normal = np.cross(line.direction, other.direction)
    squared = normal @ normal
    if squared < _PARALLEL**2:
        return line.point
    between = other.point - line.point
    along = np.cross(between, other.direction) @ normal / squared
    return np.asarray(line.point + along * line.direction)


def distance(line: Line, other: Line) -> float:
    """Returns how far two lines are from each other [m]; 0 where they meet."""
    normal = np.cross(line.direction, other.direction)
    between = other.point - line.point
    length = float(np.linalg.norm(normal))
    if length < _PARALLEL:
        return float(np.linalg.norm(np.cross(between, line.direction)))
    return float(abs(between @ normal)) / length
