"""The hand does exactly as commanded, whatever the base does.

Ours. The base gets its share and is turned towards its hand; the arm gets exactly the
rest. Where a limit binds, hand and base slow down together.
"""

import dataclasses as dc
import math
from typing import Any, NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import cos
from pydrake.systems.framework import LeafSystem_, ValueProducer
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_mobman.arm.first_joint import FirstJoint, first_joint, turning_share
from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.arm.limits import JointLimits
from drake_mobman.base.smoother import Smoother
from drake_mobman.base.velocity_field import yaw_rate
from drake_mobman.decomposers.arm_compensation import (
    LEAST_REACH,
    arm_compensation,
    base_induced_rates,
)
from drake_mobman.decomposers.blending import SHARES, SHARPNESS_L, SHARPNESS_PSI
from drake_mobman.decomposers.decomposer import declare_decomposer_ports
from drake_mobman.decomposers.limiter import Factors, Limiter, least, status
from drake_mobman.decomposers.share import WorkspaceLimits
from drake_mobman.decomposers.status import DecomposerStatus
from drake_mobman.parameters import (
    SPEED,
    YAW_RATE,
    Range,
    checked,
    checked_period,
    in_order,
    one_of,
    within,
)
from drake_mobman.scalars import Scalar, larger, smaller, smallest, smoothstep, where

_WHOLE = math.cos(math.pi / 3)
"""|cos psi| from which the base carries its share whole."""

_TINY = 1e-9
"""Stands for |cos psi| at a right angle, where the base carries nothing."""


@dc.dataclass
class Exact:
    """How authority is shared, and how the base is turned towards its hand."""

    share: str = "smoothstep"  # Keeps the workspace; or "tanh", the paper's.
    alpha: float = 21.0  # Sharpness of the transition in l [1/m].
    beta: float = 21.0  # Sharpness of the transition in psi [1/rad].
    # Without, psi runs away to a right angle while the base drives.
    K_omega: float = 0.8  # Yaw rate towards the hand at phi_max and beyond [rad/s].
    phi_min: float = 0.2  # |psi| from which the base turns [rad].
    phi_max: float = 0.7  # |psi| from which it turns at K_omega [rad].
    # Slower, the base turns less in proportion: a hand at rest leaves it at rest.
    turning_speed: float = 0.05  # Of the hand, from which the base turns fully [m/s].

    def check(self) -> None:
        """Raises `ParameterError` unless gains, angles and the share make a law."""
        one_of(self, "share", tuple(SHARES))
        within(self, SHARPNESS_L, "alpha")
        within(self, SHARPNESS_PSI, "beta")
        within(self, Range(0.0, YAW_RATE.high, "rad/s"), "K_omega")
        within(self, Range(0.0, math.pi, "rad"), "phi_min", "phi_max")
        in_order(self, "phi_min", "phi_max")
        within(self, Range(1e-4, SPEED.high, "m/s"), "turning_speed")


def exact_base(
    command: Any,
    workspace: Any,
    params: Exact,
    limits: WorkspaceLimits,
    p_BS: Any,
    joint: FirstJoint | None = None,
) -> tuple[Scalar, Scalar]:
    """Returns v_b [m/s] and omega_b [rad/s] that the whole command asks of the base.

    omega_b is the base's share of omega_c, and the field's rate of turning towards the
    hand (Petric & Zlajpah, eqs. 5 and 6). With v_c less what that makes of the reach,
    v_b is the base's share of it along the reach, which it carries whole as far as 60
    degrees aside, and nothing of at a right angle. So at a limit of l the base alone
    carries the hand.

    Args:
        command: `ee_command`.
        workspace: l [m], psi [rad], z [m].
        params: of the law.
        limits: of the workspace.
        p_BS: shoulder in B (3,) [m].
        joint: the arm's first, which turns back by as much as the base turns towards
            the hand; None where it turns on and on.
    """
    v_c, omega_c, _ = command
    l, psi, _ = workspace
    share = SHARES[params.share]
    nu = share(omega_c, psi, limits.psi_min, limits.psi_max, params.beta)
    speed = abs(v_c) + l * abs(omega_c)
    turning = smaller(speed / params.turning_speed, 1.0)
    aligning = yaw_rate(psi, params)
    if joint is not None:
        room = turning_share(aligning, joint, params.phi_max - params.phi_min)
        turning = turning * room
    omega_b = nu * omega_c + turning * aligning
    left = v_c - base_induced_rates(workspace, 0.0, omega_b, p_BS)[0]
    mu = share(left, l, limits.l_min, limits.l_max, params.alpha)
    c = cos(psi)
    aside = larger(abs(c), _TINY)
    projected = smoothstep(aside, 0.0, _WHOLE) / aside
    return where(c < 0, -projected, projected) * mu * left, omega_b


class BaseCommand(NamedTuple):
    """What the base is told, and how much of the command is left to follow it."""

    base: tuple[Scalar, Scalar]  # v_b [m/s], omega_b [rad/s].
    factors: Factors
    share: Scalar  # The least of the factors.


def exact_base_command(
    command: Any,
    workspace: Any,
    q: Any,
    params: Exact,
    limits: WorkspaceLimits,
    limiter: Limiter,
) -> BaseCommand:
    """Returns what the base is told of `command`, as far as base and joints follow.

    Args:
        command: `ee_command`.
        workspace: l [m], psi [rad], z [m].
        q: joint angles (n,) [rad].
        params: of the law.
        limits: of the workspace.
        limiter: of base and joints.
    """
    p_BS, joint = limiter.arm.p_BS, first_joint(q, limiter.joints)
    v_b, omega_b = exact_base(command, workspace, params, limits, p_BS, joint)
    rest = arm_compensation(command, workspace, (v_b, omega_b), p_BS)
    factors = limiter.steady_scaling(q, rest, v_b, omega_b)
    share = least(factors, q)
    return BaseCommand((share * v_b, share * omega_b), factors, share)


def exact_arm(
    command: Any,
    workspace: Any,
    q: Any,
    sent: Any,
    course: BaseCommand,
    limiter: Limiter,
) -> tuple[tuple[Scalar, Scalar, Scalar], Scalar]:
    """Returns the `arm_command` that the base, as sent, leaves, and the status.

    Args:
        command: `ee_command`.
        workspace: l [m], psi [rad], z [m].
        q: joint angles (n,) [rad].
        sent: `base_command_smoothed`.
        course: of the base.
        limiter: of base and joints.
    """
    _, factors, share = course
    present: Factors = {}
    if limiter.base.enabled:  # Else the base is sent what it is told.
        present = limiter.present_scaling(q, workspace, command, sent)
        share = smallest(share, *present.values(), made_of=(share,))
    slowed = [share * c for c in command]
    rest = arm_compensation(slowed, workspace, sent, limiter.arm.p_BS)
    at_axis = where(workspace[0] < LEAST_REACH, float(DecomposerStatus.SINGULAR), 0.0)
    return rest, status(factors, present) + at_axis


@TemplateSystem.define("ExactDecomposer_")
def ExactDecomposer_(T: Any) -> Any:
    """Returns the block for scalars of type `T`."""

    class Impl(LeafSystem_[T]):
        """Gives the hand exactly its command, or as much of it as the limits leave.

        .. pydrake_system::

            name: ExactDecomposer
            input_ports:
            - ee_command
            - workspace
            - arm_position
            - base_command_smoothed
            output_ports:
            - base_command
            - base_contribution
            - arm_command
            - decomposer_status

        Built as `ExactDecomposer(params, limits, arm, joints, smoother, period)`: an
        `Exact`, `WorkspaceLimits`, the arm's kinematics and joint limits, the `Smoother`
        that follows, and the control period [s]. The arm's part is the rest of what is
        sent to the base, so smoothing costs the hand nothing. Raises `ParameterError`
        where one of them is not valid.
        """

        def _construct(
            self,
            params: Exact,
            limits: WorkspaceLimits,
            arm: ArmKinematics,
            joints: JointLimits,
            smoother: Smoother,
            period: float,
            converter: Any = None,
        ) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            self.params = checked(params)
            self.limits = checked(limits)
            edges = limits if params.share == "smoothstep" else None
            self.limiter = Limiter(
                arm, joints, checked(smoother), edges, checked_period(period)
            )
            declare_decomposer_ports(
                self,
                arm.num_joints,
                self._calc_base,
                self._calc_share,
                self._calc_arm,
                self._calc_status,
            )
            told = {
                self.input_port_ticket(port.get_index())
                for port in (self.command, self.workspace, self.arm_position)
            }
            # Several outputs come of one evaluation.
            self.course = self._declare_entry("base and factors", self._of_course, told)
            sent = self.input_port_ticket(self.base_command_smoothed.get_index())
            self.present = self._declare_entry(
                "rest and factors", self._at_present, told | {sent}
            )

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            limiter = other.limiter
            Impl._construct(
                self,
                other.params,
                other.limits,
                limiter.arm,
                limiter.joints,
                limiter.base,
                limiter.period,
                converter=converter,
            )

        def _declare_entry(self, name: str, calc: Any, needs: Any) -> Any:
            make = AbstractValue.Make
            return self.DeclareCacheEntry(
                name,
                ValueProducer(
                    allocate=lambda: make(()),
                    calc=lambda context, value: value.set_value(calc(context)),
                ),
                needs,
            )

        def _of_course(self, context: Any) -> BaseCommand:
            return exact_base_command(
                *self._told(context), self.params, self.limits, self.limiter
            )

        def _at_present(self, context: Any) -> Any:
            sent = self.base_command_smoothed.Eval(context)
            course = self.course.Eval(context)
            return exact_arm(*self._told(context), sent, course, self.limiter)

        def _told(self, context: Any) -> tuple[Any, Any, Any]:
            # Python's own floats, which take half the time of numpy's.
            return (
                self.command.Eval(context).tolist(),
                self.workspace.Eval(context).tolist(),
                self.arm_position.Eval(context).tolist(),
            )

        def _calc_base(self, context: Any, output: Any) -> None:
            output.SetFromVector(np.array(self.course.Eval(context).base))

        def _calc_share(self, context: Any, output: Any) -> None:
            v_b, omega_b = self.course.Eval(context).base
            workspace = self.workspace.Eval(context)
            p_BS = self.limiter.arm.p_BS
            output.SetFromVector(
                np.array(base_induced_rates(workspace, v_b, omega_b, p_BS))
            )

        def _calc_arm(self, context: Any, output: Any) -> None:
            output.SetFromVector(np.array(self.present.Eval(context)[0]))

        def _calc_status(self, context: Any, output: Any) -> None:
            output.SetFromVector(np.array([self.present.Eval(context)[1]]))

    return Impl


ExactDecomposer = ExactDecomposer_[None]
