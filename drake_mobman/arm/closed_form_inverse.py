"""Joint rates for the end effector's rates, in closed form (Kwon et al., eqs. 4-9)."""

from typing import Any

from drake_mobman.arm.inverse import ArmInverse
from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.arm.limits import ArmStatus, JointLimits, bounded_rates
from drake_mobman.blocks import scalar_block
from drake_mobman.parameters import ParameterError
from drake_mobman.scalars import Scalar, Vector, where

INVERSES = ("positions", "rates")
"""What may be inverted."""


def rates_by_positions(
    arm: ArmKinematics, q: Vector, command: Vector, period: float
) -> tuple[list[Scalar], Scalar]:
    """Returns the joint rates that reach, after `period`, where the command leads.

    Inverts the position after one Euler step (eqs. 4, 5 and Algorithm 1 lines 33-34),
    so that a singular Jacobian, as at l = 0, is no trouble.

    Args:
        arm: whose joints these are.
        q: joint angles (n,) [rad].
        command: `arm_command` (3,).
        period: of the step [s].

    Returns:
        The rates (n,) [rad/s], and the `ArmStatus` flags.
    """
    now = arm.ee_cylindrical(q)
    target = [x + rate * period for x, rate in zip(now, command, strict=True)]
    moves = zip(q, arm.inverse(target), strict=True)
    rates = [(after - before) / period for before, after in moves]
    return rates, where(arm.is_in_reach(target), 0.0, float(ArmStatus.OUT_OF_REACH))


def rates_by_jacobian(
    arm: ArmKinematics, q: Vector, command: Vector
) -> tuple[list[Scalar], Scalar]:
    """Returns the joint rates that the inverse of the Jacobian gives (eqs. 8, 9).

    Args:
        arm: whose joints these are.
        q: joint angles (n,) [rad].
        command: `arm_command` (3,).

    Returns:
        The rates (n,) [rad/s], damped near a singularity, and the `ArmStatus` flags.
    """
    return arm.rates(q, command), arm.is_near_singular(q) * float(ArmStatus.SINGULAR)


@scalar_block
class ClosedFormInverse(ArmInverse):
    """Turns the rates of `ee_cylindrical` into joint rates that the arm can make.

    .. pydrake_system::

        name: ClosedFormInverse
        input_ports: [arm_command, arm_position]
        output_ports: [arm_velocity_command, arm_status]

    Args:
        arm: the arm's kinematics, in closed form.
        joint_limits: of its n joints.
        period: control period [s].
        by: what is inverted, one of `INVERSES`.

    Raises:
        ParameterError: where `period` or `by` is not valid.
    """

    def __init__(
        self,
        arm: ArmKinematics,
        joint_limits: JointLimits,
        period: float,
        by: str = "positions",
    ) -> None:
        if by not in INVERSES:
            raise ParameterError("by", by, f"must be one of {', '.join(INVERSES)}")
        self.by = by
        ArmInverse.__init__(self, arm, joint_limits, period)

    def _invert(self, context: Any) -> tuple[list[Scalar], Scalar]:
        q = self.position.Eval(context)
        command = self.command.Eval(context)
        if self.by == "positions":
            rates, limiting = rates_by_positions(self.arm, q, command, self.period)
        else:
            rates, limiting = rates_by_jacobian(self.arm, q, command)
        rates, bound = bounded_rates(rates, q, self.joint_limits, self.period)
        return rates, limiting + bound


ClosedFormInverse_ = ClosedFormInverse.template
