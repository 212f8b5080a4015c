"""Joint rates for an end effector that is oriented in W, whatever the base does."""

from typing import Any, NamedTuple

from drake_mobman import signals
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
from drake_mobman.parameters import ParameterError
from drake_mobman.scalars import Scalar, Vector, where
from drake_mobman.tracing import all_named

_IN_W = ("turning", "held")

ORIENTATIONS = ("reach", *_IN_W)
"""How the level end effector turns: with its reach, at omega_c in W, or held in W."""


class Inverted(NamedTuple):
    """What an oriented end effector's rates come to."""

    rates: list[Scalar]  # Of the joints (n,) [rad/s].
    status: Scalar  # `ArmStatus` flags.
    bound: Scalar  # Those of the limits alone: 0 where E turns as commanded.


def oriented_rates(
    arm: JacobianArm,
    q: Vector,
    command: Vector,
    yaw_rate: Scalar,
    yaw: Scalar,
    limits: JointLimits,
    period: float,
) -> Inverted:
    """Returns joint rates that move the end effector, and turn it, within limits.

    Its position comes first: where not both are possible, the arm moves E without a
    wrist joint that is at the end of its range, and then without turning it back to
    `yaw`. Room that is left brings the joints back to the posture.

    Args:
        arm: whose joints these are.
        q: joint angles (n,) [rad].
        command: `arm_command` (3,).
        yaw_rate: of E in B [rad/s].
        yaw: desired yaw of E in B [rad].
        limits: of the joints.
        period: for which the rates are held [s].

    Returns:
        The rates, and the flags of what keeps E from moving and turning as commanded.
    """
    parts = arm.oriented_parts(q, command, yaw)
    apart = yaw_rate - command[1]
    turned = all_named(
        [a + apart * row[2] for a, row in zip(parts.ee, parts.turns, strict=True)]
    )
    wanted = all_named([a + b for a, b in zip(turned, parts.level, strict=True)])
    rates, bound = bounded_rates(wanted, q, limits, period)
    ways = wanted, turned, parts.ee
    wrist = Wrist(arm.wrist, parts.turns, q, limits, period)
    rates, extra, status = give_way(rates, bound, ways, parts.posture, wrist)
    rates = filled_rates(rates, extra, q, limits, period)
    return Inverted(rates, status + parts.damped * float(ArmStatus.SINGULAR), bound)


@scalar_block
class OrientedInverse(ArmInverse):
    """Turns the rates of `ee_cylindrical` into joint rates, E oriented in W.

    The end effector is level, and its yaw in W turns at
    omega_c or is held: its yaw rate in B is that less the omega of the base.

    .. pydrake_system::

        name: OrientedInverse
        input_ports: [arm_command, arm_position, ee_command, base_estimate, base_pose]
        output_ports: [arm_velocity_command, arm_status]

    The state is the desired yaw of E in W [rad], which at the start of a simulation is
    the yaw that it has. So the lag of the servos of base and arm is corrected. An end
    effector that is held also returns to it, by the shorter way, once no limit is in
    the way. One that turns goes on from where the limit left it: when the operator
    lets go of the stick, nothing is left to be turned.

    The velocity of E in W is what `arm_command` and the base make together, whatever
    the orientation: with the exact arm compensation, v_c along the reach S->E and
    l omega_c across it. The base changes E's path only by the direction of the reach,
    since it moves S.

    Args:
        arm: the arm's kinematics.
        joint_limits: of its n joints.
        period: control period [s].
        orientation: `turning` or `held`.

    Raises:
        ParameterError: where `period` or `orientation` is not valid.
    """

    arm: JacobianArm

    def __init__(
        self,
        arm: JacobianArm,
        joint_limits: JointLimits,
        period: float,
        orientation: str,
    ) -> None:
        if orientation not in _IN_W:
            valid = f"must be one of {', '.join(_IN_W)}"
            raise ParameterError("orientation", orientation, valid)
        self.orientation = orientation
        ArmInverse.__init__(self, arm, joint_limits, period)
        self.ee_command = self.DeclareVectorInputPort(signals.EE_COMMAND, 3)
        self.base_estimate = self.DeclareVectorInputPort(signals.BASE_ESTIMATE, 3)
        self.base_pose = self.DeclareVectorInputPort(signals.BASE_POSE, 3)
        self.DeclareDiscreteState(1)
        self.DeclareInitializationDiscreteUpdateEvent(self._start)
        if orientation == "turning":
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._turn)

    def _yaw(self, context: Any) -> Scalar:
        """Returns the yaw of E in W [rad]."""
        heading = self.base_pose.Eval(context)[2]
        return heading + self.arm.yaw(self.position.Eval(context))

    def _start(self, context: Any, state: Any) -> None:
        state.get_mutable_vector().SetAtIndex(0, self._yaw(context))

    def _turn(self, context: Any, state: Any) -> None:
        omega_c = self.ee_command.Eval(context)[1]
        limited = self.inverted(context)[2] > 0
        last = context.get_discrete_state_vector().GetAtIndex(0)
        yaw = where(limited, self._yaw(context), last)
        state.get_mutable_vector().SetAtIndex(0, yaw + self.period * omega_c)

    def _invert(self, context: Any) -> Inverted:
        turning = self.orientation == "turning"
        omega_W = self.ee_command.Eval(context)[1] if turning else 0.0
        yaw = context.get_discrete_state_vector().GetAtIndex(0)
        return oriented_rates(
            self.arm,
            self.position.Eval(context),
            self.command.Eval(context),
            omega_W - self.base_estimate.Eval(context)[2],
            yaw - self.base_pose.Eval(context)[2],
            self.joint_limits,
            self.period,
        )


OrientedInverse_ = OrientedInverse.template
