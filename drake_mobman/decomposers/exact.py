"""The end effector moves exactly as commanded, however the base moves.

Our own law. The base gets its share and turns towards the end effector; the arm gets
exactly the rest. Where a limit is active, end effector and base slow down together.
"""

import dataclasses as dc
import math
from typing import Any, NamedTuple

from pydrake.math import cos

from drake_mobman.arm.first_joint import FirstJoint, first_joint, turning_share
from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.arm.limits import JointLimits
from drake_mobman.base.velocity_field import yaw_rate
from drake_mobman.blocks import cached, scalar_block, tickets
from drake_mobman.decomposers.arm_compensation import (
    LEAST_REACH,
    arm_compensation,
    base_induced_rates,
)
from drake_mobman.decomposers.decomposer import CompensatedDecomposer
from drake_mobman.decomposers.limiter import Factors, Limiter, least, status
from drake_mobman.decomposers.share import (
    SHARES,
    SHARPNESS_L,
    SHARPNESS_PSI,
    authority_shares,
)
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
from drake_mobman.robot_model import BaseLimits, RobotSetup, WorkspaceLimits
from drake_mobman.scalars import (
    Scalar,
    Vector,
    larger,
    smaller,
    smallest,
    smoothstep,
    where,
)

_WHOLE = math.cos(math.pi / 3)
"""|cos psi| from which the base makes its full share."""

_TINY = 1e-9
"""Used for |cos psi| at a right angle, where the base contributes nothing."""


@dc.dataclass
class Exact:
    """How authority is shared, and how the base turns towards the end effector."""

    share: str = "smoothstep"  # Keeps to the limits; or "tanh", the paper's.
    alpha: float = 21.0  # Sharpness of the transition in l [1/m].
    beta: float = 21.0  # Sharpness of the transition in psi [1/rad].
    # At 0, psi would grow to a right angle while the base drives.
    K_omega: float = 0.8  # Yaw rate towards E at phi_max and beyond [rad/s].
    phi_min: float = 0.2  # |psi| from which the base turns [rad].
    phi_max: float = 0.7  # |psi| from which it turns at K_omega [rad].
    # For a slower E the base turns in proportion, and not at all for an E at rest.
    turning_speed: float = 0.05  # Speed of E from which the base turns fully [m/s].

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range, and the share law exists."""
        one_of(self, "share", tuple(SHARES))
        within(self, SHARPNESS_L, "alpha")
        within(self, SHARPNESS_PSI, "beta")
        within(self, Range(0.0, YAW_RATE.high, "rad/s"), "K_omega")
        within(self, Range(0.0, math.pi, "rad"), "phi_min", "phi_max")
        in_order(self, "phi_min", "phi_max")
        within(self, Range(1e-4, SPEED.high, "m/s"), "turning_speed")

    def shares(
        self, limits: WorkspaceLimits, command: Vector, at: Vector
    ) -> tuple[Scalar, Scalar]:
        """Returns the base's shares of `v_c` and `omega_c`."""
        return authority_shares(self, limits, command, at)

    def build(self, setup: RobotSetup) -> "ExactDecomposer":
        """Returns the block for a robot."""
        return ExactDecomposer(
            self,
            setup.workspace,
            setup.arm,
            setup.joint_limits,
            setup.base_limits,
            setup.period,
        )


def exact_base(
    command: Vector,
    at: Vector,
    params: Exact,
    limits: WorkspaceLimits,
    p_BS: Vector,
    joint: FirstJoint | None = None,
) -> tuple[Scalar, Scalar]:
    """Returns v_b [m/s] and omega_b [rad/s] for the whole command, without limits.

    omega_b is the base's share of omega_c, plus the field's rate of turning towards the
    end effector (Petric & Zlajpah, eqs. 5 and 6). omega_b also changes the reach; v_b
    makes the base's share of the rest of v_c: all of that share up to 60 degrees aside,
    and none at a right angle. So at a limit of l the base alone moves the end effector.

    Args:
        command: `ee_command` (3,).
        at: `ee_cylindrical` (3,).
        params: of the law.
        limits: of the workspace.
        p_BS: shoulder in B (3,) [m].
        joint: the arm's first, which turns back as far as the base turns towards the
            end effector; None where it has no limits.
    """
    v_c, omega_c, _ = command
    l, psi, _ = at
    share = SHARES[params.share]
    nu = share(omega_c, psi, limits.psi_min, limits.psi_max, params.beta)
    speed = abs(v_c) + l * abs(omega_c)
    turning = smaller(speed / params.turning_speed, 1.0)
    aligning = yaw_rate(psi, params)
    if joint is not None:
        room = turning_share(aligning, joint, params.phi_max - params.phi_min)
        turning = turning * room
    omega_b = nu * omega_c + turning * aligning
    left = v_c - base_induced_rates(at, 0.0, omega_b, p_BS)[0]
    mu = share(left, l, limits.l_min, limits.l_max, params.alpha)
    c = cos(psi)
    aside = larger(abs(c), _TINY)
    projected = smoothstep(aside, 0.0, _WHOLE) / aside
    return where(c < 0, -projected, projected) * mu * left, omega_b


class BaseCommand(NamedTuple):
    """A `base_command`, and how the command was scaled for it."""

    base: tuple[Scalar, Scalar]  # v_b [m/s], omega_b [rad/s].
    factors: Factors
    scale: Scalar  # The least of the factors.


def exact_base_command(
    command: Vector,
    at: Vector,
    q: Vector,
    params: Exact,
    limits: WorkspaceLimits,
    limiter: Limiter,
) -> BaseCommand:
    """Returns the base command that base and joints can keep up permanently.

    Args:
        command: `ee_command` (3,).
        at: `ee_cylindrical` (3,).
        q: joint angles (n,) [rad].
        params: of the law.
        limits: of the workspace.
        limiter: of base and joints.
    """
    p_BS = limiter.arm.p_BS
    joint = first_joint(q, limiter.joint_limits, limiter.arm.turn)
    v_b, omega_b = exact_base(command, at, params, limits, p_BS, joint)
    arm = arm_compensation(command, at, (v_b, 0.0, omega_b), p_BS)
    factors = limiter.steady_scaling(q, arm, v_b, omega_b)
    scale = least(factors, q)
    return BaseCommand((scale * v_b, scale * omega_b), factors, scale)


def exact_arm_command(
    command: Vector,
    at: Vector,
    q: Vector,
    smoothed: Vector,
    estimate: Vector,
    base: BaseCommand,
    limiter: Limiter,
) -> tuple[Vector, Scalar]:
    """Returns the `arm_command` that compensates for the base, and the status.

    Args:
        command: `ee_command` (3,).
        at: `ee_cylindrical` (3,).
        q: joint angles (n,) [rad].
        smoothed: `base_command_smoothed` (2,).
        estimate: `base_estimate` (3,).
        base: the raw base command, and the scaling.
        limiter: of base and joints.
    """
    scale, present = base.scale, Factors()
    if not limiter.base_limits.follows_at_once:
        present = limiter.present_scaling(q, at, command, smoothed, estimate)
        scale = smallest(scale, *present.values(), made_of=(scale,))
    scaled = [scale * c for c in command]
    arm = arm_compensation(scaled, at, estimate, limiter.arm.p_BS)
    at_axis = where(at[0] < LEAST_REACH, float(DecomposerStatus.SINGULAR), 0.0)
    return arm, status(base.factors, present) + at_axis


@scalar_block
class ExactDecomposer(CompensatedDecomposer):
    """Moves the end effector exactly as commanded, as far as the limits allow.

    .. pydrake_system::

        name: ExactDecomposer
        input_ports: [ee_command, ee_cylindrical, arm_position, base_command_smoothed,
                      base_estimate]
        output_ports: [base_command, base_contribution, arm_command, decomposer_status]

    The arm compensates for what the base does, after smoothing, and not for the raw
    command: so smoothing does not disturb the end effector.

    Args:
        params: of the law.
        workspace: limits for the arm.
        arm: its kinematics.
        joint_limits: of the arm.
        base_limits: of the smoothed base command.
        period: control period [s].

    Raises:
        ParameterError: where a parameter is not valid.
    """

    def __init__(
        self,
        params: Exact,
        workspace: WorkspaceLimits,
        arm: ArmKinematics,
        joint_limits: JointLimits,
        base_limits: BaseLimits,
        period: float,
    ) -> None:
        self.params, self.workspace, self.arm = checked(params), checked(workspace), arm
        edges = workspace if params.share == "smoothstep" else None
        self.limiter = Limiter(
            arm, joint_limits, base_limits, edges, checked_period(period)
        )
        self.declare_ports()
        state = tickets(self, self.command, self.ee_cylindrical, self.arm_position)
        self._base = cached(self, self._calc_base_command, state)
        moves = tickets(self, self.base_command_smoothed, self.base_estimate)
        self._arm = cached(self, self._calc_arm_command, state | moves)

    def base(self, context: Any) -> tuple[Scalar, Scalar]:
        """Returns the `base_command`."""
        return self._base(context).base

    def compensation(self, context: Any) -> Vector:
        """Returns the `arm_command`."""
        return self._arm(context)[0]

    def status(self, context: Any) -> Scalar:
        """Returns the sum of the `DecomposerStatus` flags that hold."""
        return self._arm(context)[1]

    def law(
        self,
        command: Vector,
        at: Vector,
        q: Vector,
        smoothed: Vector,
        estimate: Vector,
    ) -> tuple[Scalar, ...]:
        """Returns the components of `base_command` and of `arm_command`."""
        inputs = command, at, q
        base = exact_base_command(*inputs, self.params, self.workspace, self.limiter)
        arm, _ = exact_arm_command(*inputs, smoothed, estimate, base, self.limiter)
        return *base.base, *arm

    def law_without_limits(
        self,
        command: Vector,
        at: Vector,
        _q: Vector,
        _smoothed: Vector,
        estimate: Vector,
    ) -> tuple[Scalar, ...]:
        """Returns the same where no limit is active, which is faster."""
        p_BS = self.arm.p_BS
        base = exact_base(command, at, self.params, self.workspace, p_BS)
        return *base, *arm_compensation(command, at, estimate, p_BS)

    def _calc_base_command(self, context: Any) -> BaseCommand:
        return exact_base_command(
            *self._inputs(context), self.params, self.workspace, self.limiter
        )

    def _calc_arm_command(self, context: Any) -> tuple[Vector, Scalar]:
        return exact_arm_command(
            *self._inputs(context),
            self.base_command_smoothed.Eval(context),
            self.base_estimate.Eval(context),
            self._base(context),
            self.limiter,
        )

    def _inputs(self, context: Any) -> tuple[Vector, Vector, Vector]:
        # Python's floats take half the time of numpy's.
        return (
            self.command.Eval(context).tolist(),
            self.ee_cylindrical.Eval(context).tolist(),
            self.arm_position.Eval(context).tolist(),
        )


ExactDecomposer_ = ExactDecomposer.template
