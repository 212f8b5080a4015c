"""The hand's rates as joint rates, the hand oriented in W whatever the base does."""

from typing import Any

from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_mobman import signals
from drake_mobman.arm.inverse import declare_inverse_ports
from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.limits import (
    ArmStatus,
    JointLimits,
    bounded_rates,
    filled_rates,
)
from drake_mobman.arm.place_first import best_placed, relieved
from drake_mobman.parameters import ParameterError, checked_period
from drake_mobman.scalars import Scalar

_IN_W = ("turning", "held")

ORIENTATIONS = ("reach", *_IN_W)
"""How a level hand may be turned: along its reach, at omega_c in W, or held in W."""

_LIMITED = ArmStatus.JOINT_RATE | ArmStatus.JOINT_LIMIT


def oriented_rates(
    arm: JacobianArm,
    q: Any,
    command: Any,
    yaw_rate: Scalar,
    yaw: Scalar,
    limits: JointLimits,
    period: float,
) -> tuple[list[Scalar], Scalar]:
    """Returns joint rates that move the hand, and turn it, within the limits.

    Its place comes first, where not both can be had: the arm moves the hand without a
    wrist that is at the end of its range, and then without bringing it back to `yaw`.
    Room that is left goes to bringing the joints back to the posture.

    Args:
        arm: whose joints these are.
        q: joint angles (n,) [rad].
        command: `arm_command`.
        yaw_rate: of the hand in B [rad/s].
        yaw: where the hand is to be turned to, in B [rad].
        limits: of the joints.
        period: for which the rates are held [s].

    Returns:
        The rates (n,) [rad/s], and the `ArmStatus` flags of what keeps the hand from
        moving and turning as commanded.
    """
    parts = arm.oriented_parts(q, command, yaw)
    apart = yaw_rate - command[1]
    turn = parts.turns[:, 2].tolist()
    turned = [a + apart * b for a, b in zip(parts.hand, turn, strict=True)]
    wanted = [a + b for a, b in zip(turned, parts.level, strict=True)]
    rates, bound = bounded_rates(wanted, q, limits, period)
    extra = parts.posture
    if bound > 0:
        ways = wanted, turned, parts.hand
        placed = best_placed(ways, parts.turns, arm.wrist, q, limits, period)
        if placed.gives_way:
            rates, bound = placed.rates, bound + float(ArmStatus.ORIENTATION)
            extra = relieved(extra, dict.fromkeys(placed.held, 0.0), parts.turns)
    rates = filled_rates(rates, extra, q, limits, period)
    return rates, bound + parts.damped * float(ArmStatus.SINGULAR)


@TemplateSystem.define("OrientedInverse_", T_list=[float, AutoDiffXd])
def OrientedInverse_(T: Any) -> Any:
    """Returns the block for scalars of type `T`, float or AutoDiffXd."""

    class Impl(LeafSystem_[T]):
        """Turns rates of the workspace into joint rates, the hand oriented in W.

        The hand is level, and its yaw in W turns at omega_c or is held: its yaw rate in
        B is that less the omega_b that the base is sent.

        .. pydrake_system::

            name: OrientedInverse
            input_ports:
            - arm_command
            - arm_position
            - ee_command
            - base_command_smoothed
            - base_pose
            output_ports:
            - arm_velocity_command
            - arm_status

        The state is the yaw in W [rad] that the hand is led to, at the start of a
        simulation the one that it has: what the servos of base and arm lag behind is
        taken back. A hand that is held comes back to it, too, by the shorter way, when
        a limit is no more in its way. A hand that turns goes on from where the limit
        left it: an operator who has let go of the stick is not owed a turn.

        E's velocity in W is what `arm_command` and the base make together, whatever the
        orientation: with the exact rest, v_c along the reach S->E and l omega_c across
        it. E's path is the base's affair only in so far as the direction of the reach
        is, by its definition: the base moves S.

        Built as `OrientedInverse(arm, limits, period, orientation)`: a `JacobianArm`,
        its joint limits, the control period [s], and `turning` or `held`. Raises
        `ParameterError` where one of the last two is not valid.
        """

        def _construct(
            self,
            arm: JacobianArm,
            limits: JointLimits,
            period: float,
            orientation: str,
            converter: Any = None,
        ) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            if orientation not in _IN_W:
                valid = f"must be one of {', '.join(_IN_W)}"
                raise ParameterError("orientation", orientation, valid)
            self.arm, self.limits, self.orientation = arm, limits, orientation
            self.period = checked_period(period)
            declare_inverse_ports(self, arm.num_joints, self._invert)
            self.ee_command = self.DeclareVectorInputPort(signals.EE_COMMAND, 3)
            self.base_command_smoothed = self.DeclareVectorInputPort(
                signals.BASE_COMMAND_SMOOTHED, 2
            )
            self.base_pose = self.DeclareVectorInputPort(signals.BASE_POSE, 3)
            self.DeclareDiscreteState(1)
            self.DeclareInitializationDiscreteUpdateEvent(self._start)
            if orientation == "turning":
                self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._turn)

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(
                self,
                other.arm,
                other.limits,
                other.period,
                other.orientation,
                converter=converter,
            )

        def _yaw(self, context: Any) -> Scalar:
            """Returns the hand's yaw in W [rad]."""
            heading = self.base_pose.Eval(context)[2]
            return heading + self.arm.yaw(self.position.Eval(context))

        def _start(self, context: Any, state: Any) -> None:
            state.get_mutable_vector().SetAtIndex(0, self._yaw(context))

        def _turn(self, context: Any, state: Any) -> None:
            omega_c = self.ee_command.Eval(context)[1]
            limited = int(self.inverted.Eval(context)[1]) & _LIMITED
            last = context.get_discrete_state_vector().GetAtIndex(0)
            yaw = self._yaw(context) if limited else last
            state.get_mutable_vector().SetAtIndex(0, yaw + self.period * omega_c)

        def _invert(self, context: Any) -> tuple[list[Scalar], Scalar]:
            turning = self.orientation == "turning"
            omega_W = self.ee_command.Eval(context)[1] if turning else 0.0
            yaw = context.get_discrete_state_vector().GetAtIndex(0)
            return oriented_rates(
                self.arm,
                self.position.Eval(context),
                self.command.Eval(context),
                omega_W - self.base_command_smoothed.Eval(context)[1],
                yaw - self.base_pose.Eval(context)[2],
                self.limits,
                self.period,
            )

    return Impl


OrientedInverse = OrientedInverse_[None]
