"""The base turns towards its hand, and the arm's first joint turns back by as much.

Ours. A bearing knows no turns, but a joint has ends: by the shorter way round, the base
would wind up an arm that is past half a turn already, and then drag the hand round and
round. It turns the way that the first joint can follow, and no further than that goes.
"""

import math
from typing import Any, NamedTuple

from drake_mobman.scalars import Scalar, smoothstep, where


class FirstJoint(NamedTuple):
    """The arm's first joint, which turns all of it about the shoulder's axis."""

    angle: Scalar  # [rad].
    lower: float  # End of its range [rad]; infinite where there is none.
    upper: float  # The other one [rad].


def first_joint(q: Any, limits: Any) -> FirstJoint:
    """Returns the first joint of an arm at `q` (n,) [rad] with its `JointLimits`."""
    return FirstJoint(q[0], limits.lower[0], limits.upper[0])


def unwound(phi: Scalar, joint: FirstJoint) -> Scalar:
    """Returns by how much the base is to turn to face a bearing [rad].

    By phi, which takes the first joint from its angle to angle - phi; or the longer way
    round, where the joint does not go there, or goes better to the other place. Where
    it goes to neither, the shorter way is begun.

    Args:
        phi: bearing of the hand, in [-pi, pi] [rad].
        joint: which turns back.
    """
    least, most = _between(joint.lower, joint.upper)
    turn, after = 2 * math.pi, joint.angle - phi
    return phi + where(after > most, turn, where(after < least, -turn, 0.0))


def _between(lower: float, upper: float) -> tuple[float, float]:
    """Returns the angles between which the joint may end by the shorter way [rad]."""
    if math.isinf(lower) or math.isinf(upper):
        return lower, upper
    middle, turn = 0.5 * (lower + upper), 2 * math.pi
    return min(middle - math.pi, upper - turn), max(middle + math.pi, lower + turn)


def turning_share(omega: Scalar, joint: FirstJoint, width: float) -> Scalar:
    """Returns the share of a yaw rate that the first joint leaves, in [0, 1].

    All of it where the joint has more room than `width` to turn back, and nothing at
    the end of its range.

    Args:
        omega: yaw rate of the base [rad/s].
        joint: which turns back.
        width: of the room in which the share falls [rad].
    """
    turns_left = joint.angle - joint.lower
    turns_right = joint.upper - joint.angle
    return smoothstep(where(omega > 0, turns_left, turns_right), 0.0, width)
