"""Joint rates for the end effector's rates, for an arm without a closed form."""

from typing import Any

from drake_mobman.arm.inverse import ArmInverse
from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.limits import (
    ArmStatus,
    JointLimits,
    bounded_rates,
    filled_rates,
)
from drake_mobman.arm.place_first import Wrist, give_way
from drake_mobman.blocks import scalar_block
from drake_mobman.scalars import Scalar, Vector, where
from drake_mobman.tracing import named


def rates_within_limits(
    arm: JacobianArm, q: Vector, command: Vector, limits: JointLimits, period: float
) -> tuple[list[Scalar], Scalar]:
    """Returns joint rates for the end effector, then for the posture, within limits.

    The position of E comes first, then that it is level: a joint that only levelling,
    or only the posture, would push against its limit does not slow E down.

    Args:
        arm: whose joints these are.
        q: joint angles (n,) [rad].
        command: `arm_command` (3,).
        limits: of the joints.
        period: for which the rates are held [s].

    Returns:
        The rates (n,) [rad/s], and the `ArmStatus` flags of what keeps E from moving,
        and from being level, as commanded.
    """
    parts = arm.oriented_parts(q, command, arm.ee_cylindrical(q)[1])
    ee = [a + b for a, b in zip(parts.ee, parts.level, strict=True)]
    rates, bound = bounded_rates(ee, q, limits, period)
    at_end = named(where(bound >= float(ArmStatus.JOINT_LIMIT), bound, 0.0))
    wrist = Wrist(arm.wrist, parts.turns, q, limits, period)
    rates, extra, given = give_way(rates, at_end, (ee, parts.ee), parts.posture, wrist)
    rates = filled_rates(rates, extra, q, limits, period)
    return rates, bound + (given - at_end) + parts.damped * float(ArmStatus.SINGULAR)


@scalar_block
class DampedInverse(ArmInverse):
    """Turns the rates of `ee_cylindrical` into joint rates that the arm can make.

    .. pydrake_system::

        name: DampedInverse
        input_ports: [arm_command, arm_position]
        output_ports: [arm_velocity_command, arm_status]

    Args:
        arm: the arm's kinematics.
        joint_limits: of its n joints.
        period: control period [s].

    Raises:
        ParameterError: where `period` is not valid.
    """

    arm: JacobianArm

    def __init__(
        self, arm: JacobianArm, joint_limits: JointLimits, period: float
    ) -> None:
        ArmInverse.__init__(self, arm, joint_limits, period)

    def _invert(self, context: Any) -> tuple[list[Scalar], Scalar]:
        q, command = self.position.Eval(context), self.command.Eval(context)
        return rates_within_limits(self.arm, q, command, self.joint_limits, self.period)


DampedInverse_ = DampedInverse.template
