"""The hand's rates as joint rates, for an arm that has no closed form."""

from typing import Any

from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_mobman.arm.inverse import declare_inverse_ports
from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.limits import (
    ArmStatus,
    JointLimits,
    bounded_rates,
    filled_rates,
)
from drake_mobman.arm.place_first import best_placed, relieved
from drake_mobman.parameters import checked_period
from drake_mobman.scalars import Scalar


def rates_within_limits(
    arm: JacobianArm, q: Any, command: Any, limits: JointLimits, period: float
) -> tuple[list[Scalar], Scalar]:
    """Returns joint rates for the hand, then for the posture, within the limits.

    The hand's place comes first, then that it is level: a joint that this or the
    posture alone would push against its limit does not slow the hand down.

    Args:
        arm: whose joints these are.
        q: joint angles (n,) [rad].
        command: `arm_command`.
        limits: of the joints.
        period: for which the rates are held [s].

    Returns:
        The rates (n,) [rad/s], and the `ArmStatus` flags of what keeps the hand from
        moving, and from being level, as commanded.
    """
    hand, extra, damped = arm.hand_and_posture_rates(q, command)
    rates, bound = bounded_rates(hand, q, limits, period)
    if bound >= float(ArmStatus.JOINT_LIMIT):
        parts = arm.oriented_parts(q, command, arm.ee_cylindrical(q)[1])
        ways = hand, parts.hand
        placed = best_placed(ways, parts.turns, arm.wrist, q, limits, period)
        if placed.gives_way:
            rates, bound = placed.rates, bound + float(ArmStatus.ORIENTATION)
            extra = relieved(extra, dict.fromkeys(placed.held, 0.0), parts.turns)
    rates = filled_rates(rates, extra, q, limits, period)
    return rates, bound + damped * float(ArmStatus.SINGULAR)


@TemplateSystem.define("DampedInverse_", T_list=[float, AutoDiffXd])
def DampedInverse_(T: Any) -> Any:
    """Returns the block for scalars of type `T`, float or AutoDiffXd."""

    class Impl(LeafSystem_[T]):
        """Turns rates of the workspace into joint rates that the arm can make.

        .. pydrake_system::

            name: DampedInverse
            input_ports:
            - arm_command
            - arm_position
            output_ports:
            - arm_velocity_command
            - arm_status

        Built as `DampedInverse(arm, limits, period)`: a `JacobianArm`, its joint
        limits and the control period [s].
        """

        def _construct(
            self,
            arm: JacobianArm,
            limits: JointLimits,
            period: float,
            converter: Any = None,
        ) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            self.arm, self.limits = arm, limits
            self.period = checked_period(period)
            declare_inverse_ports(self, arm.num_joints, self._invert)

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(
                self, other.arm, other.limits, other.period, converter=converter
            )

        def _invert(self, context: Any) -> tuple[list[Scalar], Scalar]:
            q, command = self.position.Eval(context), self.command.Eval(context)
            return rates_within_limits(self.arm, q, command, self.limits, self.period)

    return Impl


DampedInverse = DampedInverse_[None]
