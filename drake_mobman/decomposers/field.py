"""Teleoperation by a base controller: the base follows, the arm compensates.

Petric & Zlajpah, eqs. 1-6, for the base: a controller that needs only the arm's joint
angles also works in teleoperation.
"""

from typing import Any

from drake_mobman.arm.first_joint import first_joint
from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.base import BaseController
from drake_mobman.blocks import cached, scalar_block, tickets
from drake_mobman.decomposers.arm_compensation import arm_compensation
from drake_mobman.decomposers.decomposer import (
    CompensatedDecomposer,
    DecomposerParams,
)
from drake_mobman.decomposers.limiter import Limiter
from drake_mobman.decomposers.status import DecomposerStatus
from drake_mobman.parameters import checked
from drake_mobman.robot_model import Reach, RobotSetup
from drake_mobman.scalars import Scalar, Vector, where


def limited_base_command(
    q: Vector,
    params: BaseController,
    reach: Reach,
    arm: ArmKinematics,
    limiter: Limiter | None,
) -> tuple[Scalar, Scalar, Scalar]:
    """Returns v_b [m/s] and omega_b [rad/s] of the base, and the status.

    It is the base controller's command, as far as the arm can compensate for it.

    Args:
        q: joint angles (n,) [rad].
        params: of the base controller.
        reach: of the arm.
        arm: its kinematics.
        limiter: of its joints; None for joints without limits.
    """
    p_BT = arm.p_BT(q)
    if limiter is None:
        v_b, omega_b, _ = params.command(p_BT, reach, None)
        return v_b, omega_b, 0.0 * q[0]
    joint = first_joint(q, limiter.joint_limits, arm.turn)
    v, omega, held = params.command(p_BT, reach, joint)
    v_b, omega_b, share = limiter.base_scaling(q, v, omega)
    flag = float(DecomposerStatus.BASE_HELD)
    status = where(share < 1, flag, where(held > 0, flag, 0.0 * q[0]))
    return v_b, omega_b, status


@scalar_block
class FieldDecomposer(CompensatedDecomposer):
    """Drives the base by a base controller; the arm compensates for it exactly.

    .. pydrake_system::

        name: FieldDecomposer
        input_ports: [ee_command, ee_cylindrical, arm_position, base_command_smoothed,
                      base_estimate]
        output_ports: [base_command, base_contribution, arm_command, decomposer_status]

    Args:
        params: of the base controller.
        reach: of the arm.
        arm: its kinematics.
        limiter: of its joints; None for joints without limits.

    Raises:
        ParameterError: as the base controller's own block.
    """

    def __init__(
        self,
        params: BaseController,
        reach: Reach,
        arm: ArmKinematics,
        limiter: Limiter | None = None,
    ) -> None:
        self.params, self.reach = checked(params), checked(reach)
        self.arm, self.limiter = arm, limiter
        params.check_reach(reach)
        self.declare_ports()
        self._base = cached(
            self, self._calc_base_command, tickets(self, self.arm_position)
        )

    def law(
        self,
        command: Vector,
        at: Vector,
        q: Vector,
        _smoothed: Vector,
        estimate: Vector,
    ) -> tuple[Scalar, ...]:
        """Returns the components of `base_command` and of `arm_command`."""
        base, _ = self._base_and_status(q)
        return *base, *arm_compensation(command, at, estimate, self.arm.p_BS)

    def _calc_base_command(self, context: Any) -> tuple[tuple[Scalar, Scalar], Scalar]:
        return self._base_and_status(self.arm_position.Eval(context).tolist())

    def _base_and_status(self, q: Vector) -> tuple[tuple[Scalar, Scalar], Scalar]:
        v_b, omega_b, status = limited_base_command(
            q, self.params, self.reach, self.arm, self.limiter
        )
        return (v_b, omega_b), status

    def base(self, context: Any) -> tuple[Scalar, Scalar]:
        """Returns the `base_command`."""
        return self._base(context)[0]

    def compensation(self, context: Any) -> Vector:
        """Returns the `arm_command`."""
        return arm_compensation(
            self.command.Eval(context).tolist(),
            self.ee_cylindrical.Eval(context).tolist(),
            self.base_estimate.Eval(context).tolist(),
            self.arm.p_BS,
        )

    def status(self, context: Any) -> Scalar:
        """Returns the sum of the `DecomposerStatus` flags that hold."""
        return self._base(context)[1]


FieldDecomposer_ = FieldDecomposer.template


def build_decomposer(params: DecomposerParams, setup: RobotSetup) -> Any:
    """Returns the block of a decomposer, or of a base controller used as one.

    Raises:
        ParameterError: where a parameter is not valid for the robot.
    """
    if not isinstance(params, BaseController):
        return params.build(setup)
    s = setup
    limiter = Limiter(s.arm, s.joint_limits, s.base_limits, None, s.period)
    return FieldDecomposer(params, s.reach, s.arm, limiter)
