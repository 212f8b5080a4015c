"""The shoulder S, and the joints that carry the whole arm about it and up."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drake_mobman.arm.axes import Line, nearest_on
from drake_mobman.arm.chain import Chain
from drake_mobman.scalars import Matrix, Vector

VERTICAL = 0.01
"""Tilt up to which an axis counts as vertical [rad]."""


class JointAxis(NamedTuple):
    """The axis of an arm's joint in B."""

    joint: int  # Index of its position in q.
    slides: bool  # Along its axis; else it turns about it.
    line: Line  # Its direction is that of a positive rate.


class Carrier(NamedTuple):
    """A joint that moves the whole arm along one coordinate of the end effector."""

    joint: int  # Index of its position in q.
    sign: float  # 1 where a positive rate increases the coordinate, else -1.


FIRST = Carrier(0, 1.0)
"""The first joint, where it turns to the left about an axis that points up."""


class Shoulder(NamedTuple):
    """Where the arm's vertical axis is on the base, and what moves the arm along it."""

    p_BS: Matrix  # Of S (3,) [m].
    turn: Carrier | None  # The joint about the vertical through S; none if tilted.
    lift: Carrier | None  # The joint that lifts the arm as a whole.


def shoulder(joints: Sequence[JointAxis]) -> Shoulder:
    """Returns the shoulder of an arm on its base.

    S is the point of the arm's first axis of rotation that is nearest to the second.
    Its place on the base stays, whatever lifts the arm.

    Args:
        joints: of the arm, from the base on, in a configuration.
    """
    rotations = [joint.line for joint in joints if not joint.slides]
    first, second, *_ = 2 * (rotations or [joint.line for joint in joints])
    carriers: dict[bool, Carrier] = {}
    for i, slides, line in joints:
        # What follows a joint that is tilted, or a second of a kind, moves a part only.
        if not is_vertical(line) or slides in carriers:
            break
        carriers[slides] = Carrier(i, float(np.sign(line.direction[2])))
    return Shoulder(nearest_on(first, second), carriers.get(False), carriers.get(True))


def shoulder_of(chain: Chain, q: Vector) -> Shoulder:
    """Returns the shoulder of a chain at joint positions `q` (n,) [rad], [m]."""
    poses = chain.at([float(x) for x in q]).joints
    return shoulder(
        [
            JointAxis(each.index, each.slides, Line(np.array(X.p), np.array(X.axes[2])))
            for each, X in zip(chain.joints, poses, strict=True)
        ]
    )


def is_vertical(line: Line) -> bool:
    """Returns whether a line points up or down, to within `VERTICAL`."""
    return float(np.hypot(*line.direction[:2])) < VERTICAL
