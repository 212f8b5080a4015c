"""The base turns to face the end effector, and the arm's first joint turns back.

Ours. A bearing counts no turns, but a joint has limits: by the shorter way round, the
base would wind up an arm that is past half a turn already, and then drag the end
effector round and round. So the base turns the way that the first joint can follow, and
no further than that joint goes.
"""

import math
from typing import NamedTuple

from drake_mobman.arm.limits import JointLimits
from drake_mobman.arm.shoulder import Carrier
from drake_mobman.scalars import Scalar, Vector, smoothstep, where


class FirstJoint(NamedTuple):
    """The joint that turns all of the arm about the shoulder's axis, to the left."""

    angle: Scalar  # [rad].
    lower: float  # Its smallest angle [rad]; may be infinite.
    upper: float  # Its largest angle [rad]; may be infinite.


def first_joint(
    q: Vector, joint_limits: JointLimits, turn: Carrier | None
) -> FirstJoint | None:
    """Returns the joint that turns an arm; None where no joint does.

    Args:
        q: positions of the arm's joints (n,) [rad].
        joint_limits: of these joints.
        turn: which of them turns all of the arm, and which way.
    """
    if turn is None:
        return None
    i, sign = turn
    lower, upper = sign * joint_limits.lower[i], sign * joint_limits.upper[i]
    return FirstJoint(sign * q[i], min(lower, upper), max(lower, upper))


def unwound(phi: Scalar, joint: FirstJoint) -> Scalar:
    """Returns by how much the base has to turn to face a bearing [rad].

    By phi, which takes the first joint from its angle to angle - phi; or the longer way
    round, where the joint cannot get there, or is further from its limits after the
    longer way. Where it can get to neither, the base starts the shorter way.

    Args:
        phi: bearing of the end effector, in [-pi, pi] [rad].
        joint: the joint that turns back.
    """
    least, most = _between(joint.lower, joint.upper)
    turn, after = 2 * math.pi, joint.angle - phi
    return phi + where(after > most, turn, where(after < least, -turn, 0.0))


def _between(lower: float, upper: float) -> tuple[float, float]:
    """Returns the range in which the joint may end by the shorter way [rad]."""
    if math.isinf(lower) or math.isinf(upper):
        return lower, upper
    middle, turn = 0.5 * (lower + upper), 2 * math.pi
    return min(middle - math.pi, upper - turn), max(middle + math.pi, lower + turn)


def turning_share(omega: Scalar, joint: FirstJoint, width: float) -> Scalar:
    """Returns the share of a yaw rate that the first joint allows, in [0, 1].

    1 where the joint has more room than `width` to turn back, and 0 at its limit.

    Args:
        omega: yaw rate of the base [rad/s].
        joint: the joint that turns back.
        width: room to the limit over which the share falls [rad].
    """
    turns_left = joint.angle - joint.lower
    turns_right = joint.upper - joint.angle
    return smoothstep(where(omega > 0, turns_left, turns_right), 0.0, width)
