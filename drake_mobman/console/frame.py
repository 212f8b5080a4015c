"""What moves in the picture at one time, and what changes until the next frame."""

import dataclasses as dc
import math
from typing import Any, NamedTuple

import numpy as np

_MIN_STEP = 0.02
"""Shortest way between two points of a trail [m]."""

_MAX_POINTS = 400
"""Points of a trail that are drawn."""


class Trail(NamedTuple):
    """The path of a point over the last meters."""

    total: int = 0  # Points that there have been, forgotten ones included.
    points: tuple[tuple[float, ...], ...] = ()  # (x, y, z) in W, the latest last [m].

    def extended(self, point: tuple[float, ...]) -> "Trail":
        """Returns it with one more point, if that is far enough from the last one."""
        if self.points and math.dist(point, self.points[-1]) < _MIN_STEP:
            return self
        return Trail(self.total + 1, (*self.points[1 - _MAX_POINTS :], point))

    def since(self, before: "Trail") -> dict[str, Any]:
        """Returns how many of the last points of `before` it keeps, and new ones."""
        new = min(self.total - before.total, len(self.points))
        keep = len(self.points) - new
        return {"keep": keep, "add": np.round(self.points[keep:], 4).tolist()}


@dc.dataclass(frozen=True)
class Frame:
    """What moves in the picture, at one time; it never changes."""

    # Poses (4, 4) by path, each in the frame of the path above it [m].
    poses: dict[str, Any] = dc.field(default_factory=dict)
    trails: dict[str, Trail] = dc.field(default_factory=dict)  # By path.

    def since(self, before: "Frame") -> "Frame":
        """Returns what is different from the frame `before`."""
        poses = {
            path: X
            for path, X in self.poses.items()
            if not (path in before.poses and np.array_equal(X, before.poses[path]))
        }
        trails = {
            path: trail
            for path, trail in self.trails.items()
            if trail is not before.trails.get(path)
        }
        return Frame(poses, trails)

    def message(self, before: "Frame") -> dict[str, Any]:
        """Returns the message to a browser that shows `before`; matrices by columns."""
        changes = self.since(before)
        poses = {
            path: np.round(X, 6).ravel(order="F").tolist()
            for path, X in changes.poses.items()
        }
        lines = {
            path: trail.since(before.trails.get(path, Trail()))
            for path, trail in changes.trails.items()
        }
        return {"poses": poses, "lines": lines}
