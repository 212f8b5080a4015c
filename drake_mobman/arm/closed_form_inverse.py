"""The hand's rates as joint rates, in closed form (Kwon et al., eqs. 4-9)."""

from typing import Any

from pydrake.systems.framework import LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_mobman.arm.inverse import declare_inverse_ports
from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.arm.limits import ArmStatus, JointLimits, bounded_rates
from drake_mobman.parameters import ParameterError, checked_period
from drake_mobman.scalars import Scalar, where

INVERSES = ("positions", "rates")
"""What may be inverted."""


def rates_by_positions(
    arm: ArmKinematics, q: Any, command: Any, period: float
) -> tuple[list[Scalar], Scalar]:
    """Returns the joint rates that reach, after `period`, where the command leads.

    Inverts the position after one Euler step (eqs. 4, 5 and Algorithm 1 lines 33-34),
    so that a singular Jacobian, as at l = 0, is no trouble.

    Returns:
        The rates (n,) [rad/s], and the `ArmStatus` flags.
    """
    now = arm.ee_cylindrical(q)
    target = [x + rate * period for x, rate in zip(now, command, strict=True)]
    moves = zip(q, arm.inverse(target), strict=True)
    rates = [(after - before) / period for before, after in moves]
    return rates, where(arm.is_in_reach(target), 0.0, float(ArmStatus.OUT_OF_REACH))


def rates_by_jacobian(
    arm: ArmKinematics, q: Any, command: Any
) -> tuple[list[Scalar], Scalar]:
    """Returns the joint rates that the inverse of the Jacobian gives (eqs. 8, 9).

    Returns:
        The rates (n,) [rad/s], damped near a singularity, and the `ArmStatus` flags.
    """
    return arm.rates(q, command), arm.is_near_singular(q) * float(ArmStatus.SINGULAR)


@TemplateSystem.define("ClosedFormInverse_")
def ClosedFormInverse_(T: Any) -> Any:
    """Returns the block for scalars of type `T`."""

    class Impl(LeafSystem_[T]):
        """Turns rates of the workspace into joint rates that the arm can make.

        .. pydrake_system::

            name: ClosedFormInverse
            input_ports:
            - arm_command
            - arm_position
            output_ports:
            - arm_velocity_command
            - arm_status

        Built as `ClosedFormInverse(arm, limits, period, by="positions")`: the arm's
        kinematics, its joint limits, the control period [s], and what is inverted, one
        of `INVERSES`. Raises `ParameterError` where one of them is not valid.
        """

        def _construct(
            self,
            arm: ArmKinematics,
            limits: JointLimits,
            period: float,
            by: str = "positions",
            converter: Any = None,
        ) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            if by not in INVERSES:
                raise ParameterError("by", by, f"must be one of {', '.join(INVERSES)}")
            self.arm, self.limits, self.by = arm, limits, by
            self.period = checked_period(period)
            declare_inverse_ports(self, arm.num_joints, self._invert)

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(
                self,
                other.arm,
                other.limits,
                other.period,
                other.by,
                converter=converter,
            )

        def _invert(self, context: Any) -> tuple[list[Scalar], Scalar]:
            q = self.position.Eval(context)
            command = self.command.Eval(context)
            if self.by == "positions":
                rates, wanting = rates_by_positions(self.arm, q, command, self.period)
            else:
                rates, wanting = rates_by_jacobian(self.arm, q, command)
            rates, bound = bounded_rates(rates, q, self.limits, self.period)
            return rates, wanting + bound

    return Impl


ClosedFormInverse = ClosedFormInverse_[None]
