"""How fast base and end effector are to be, from the limits of base and joints."""

import numpy as np

from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.limits import JointLimits
from drake_mobman.base.smoother import Smoother
from drake_mobman.parameters import SPEED, YAW_RATE
from drake_mobman.robot_model import BaseLimits
from drake_mobman.robots.derive.derived import Derived
from drake_mobman.scalars import Matrix
from drake_mobman.teleop.guard import Guard

_OF_BASE = 0.5
"""Share of what the base can do that it is to do."""

_OF_COMMAND = 0.8
"""Largest command of the end effector: a share of the base's speed, so that the base
keeps up where the arm does not help."""

_OF_TURN = 0.4
"""Likewise of its yaw rate: it is also to turn towards the end effector."""

_OF_JOINTS = 0.5
"""Share of the joints' largest rates that a largest command takes at the posture."""


def smoother(limits: BaseLimits) -> Derived[Smoother]:
    """Returns limits for the command of a base."""
    found = Smoother(
        max_speed=_OF_BASE * limits.max_speed,
        max_acceleration=limits.max_acceleration,
        max_yaw_rate=_OF_BASE * limits.max_yaw_rate,
        max_yaw_acceleration=limits.max_yaw_acceleration,
    )
    return Derived(found, f"{_OF_BASE:g} of what the base can do")


def guard(arm: JacobianArm, limits: JointLimits, base: Smoother) -> Derived[Guard]:
    """Returns the largest command for the end effector.

    Args:
        arm: its kinematics.
        limits: of its joints.
        base: limits of the base's command.
    """
    # The joints' share of their limits at 1 m/s, or 1 rad/s, of each.
    shares = joint_shares(arm, limits, arm.posture, np.eye(3))
    by_arm = [_OF_JOINTS / max(share, 1e-3) for share in shares]
    speed, turn = _OF_COMMAND * base.max_speed, _OF_TURN * base.max_yaw_rate
    v_c, omega_c, v_z = (
        round(min(most, by), 3)
        for most, by in zip((speed, turn, speed), by_arm, strict=True)
    )
    found = Guard(
        max_v_c=max(v_c, SPEED.low),
        max_omega_c=max(omega_c, YAW_RATE.low),
        max_v_z=max(v_z, SPEED.low),
    )
    source = f"{_OF_COMMAND:g} of the base's speed, {_OF_JOINTS:g} of the joints'"
    return Derived(found, source)


def joint_shares(
    arm: JacobianArm, limits: JointLimits, q: Matrix, commands: Matrix
) -> list[float]:
    """Returns the largest share of a joint's limit that each command takes.

    Args:
        arm: its kinematics.
        limits: of its joints.
        q: joint positions (n,) [rad], [m].
        commands: `arm_command`s (N, 3).
    """
    rates = np.abs(arm.undamped_rates(q.tolist(), *commands))
    return [float(x) for x in (rates / np.asarray(limits.velocity)).max(axis=1)]
