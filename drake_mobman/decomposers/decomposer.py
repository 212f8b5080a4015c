"""A decomposer's ports, and what decomposers have in common."""

from typing import Any, Protocol

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_mobman import signals
from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.blocks import tickets
from drake_mobman.decomposers.arm_compensation import base_induced_rates
from drake_mobman.decomposers.projection import Projection, base_speed
from drake_mobman.parameters import checked
from drake_mobman.robot_model import RobotSetup, WorkspaceLimits
from drake_mobman.scalars import Scalar, Vector


def declare_decomposer_ports(
    block: Any,
    num_joints: int,
    calc_base: Any,
    calc_share: Any,
    calc_arm: Any,
    calc_status: Any = None,
) -> None:
    """Declares the ports that every decomposer has, so that one can replace another.

    `base_command` may depend neither on `base_command_smoothed` nor on `base_estimate`:
    the outputs' prerequisites state that, so the loop through smoother and estimator is
    not an algebraic one. A decomposer that can fall short of its command also has
    `decomposer_status`.
    """
    block.command = block.DeclareVectorInputPort(signals.EE_COMMAND, 3)
    block.ee_cylindrical = block.DeclareVectorInputPort(signals.EE_CYLINDRICAL, 3)
    block.arm_position = block.DeclareVectorInputPort(signals.ARM_POSITION, num_joints)
    block.base_command_smoothed = block.DeclareVectorInputPort(
        signals.BASE_COMMAND_SMOOTHED, 2
    )
    block.base_estimate = block.DeclareVectorInputPort(signals.BASE_ESTIMATE, 3)
    inputs = block.command, block.ee_cylindrical, block.arm_position
    state = tickets(block, *inputs) | {block.xd_ticket()}
    moves = tickets(block, block.base_command_smoothed, block.base_estimate)
    block.base_command = block.DeclareVectorOutputPort(
        signals.BASE_COMMAND, 2, calc_base, prerequisites_of_calc=state
    )
    block.base_contribution = block.DeclareVectorOutputPort(
        signals.BASE_CONTRIBUTION, 2, calc_share, prerequisites_of_calc=state
    )
    block.arm_command = block.DeclareVectorOutputPort(
        signals.ARM_COMMAND, 3, calc_arm, prerequisites_of_calc=state | moves
    )
    if calc_status is not None:
        block.decomposer_status = block.DeclareVectorOutputPort(
            signals.DECOMPOSER_STATUS,
            1,
            calc_status,
            prerequisites_of_calc=state | moves,
        )


class DecomposerParams(Protocol):
    """Parameters of a block that splits the command between base and arm."""

    def build(self, setup: RobotSetup) -> Any:
        """Returns the block, with the ports that every decomposer has.

        Raises:
            ParameterError: where a parameter is not valid for the robot.
        """


class ShareParams(Protocol):
    """Parameters of a decomposer that gives the base a share of the command."""

    projection: Projection

    def shares(
        self, limits: WorkspaceLimits, command: Vector, at: Vector
    ) -> tuple[Scalar, Scalar]:
        """Returns the base's shares of `v_c` and of `omega_c`, each in [0, 1].

        Args:
            limits: of the workspace.
            command: `ee_command` (3,).
            at: `ee_cylindrical` (3,).
        """


class ShareDecomposer(LeafSystem):
    """Splits the end effector's command between base and arm, by shares.

    The base gets its share of `v_c`, as a projection on the reach, and of `omega_c`;
    the arm gets the rest of each, and all of `v_z` (Kwon, eq. 16 with base and arm as
    in Algorithm 1).

    .. pydrake_system::

        name: ShareDecomposer
        input_ports: [ee_command, ee_cylindrical, arm_position, base_command_smoothed,
                      base_estimate]
        output_ports: [base_command, base_contribution, arm_command]

    Args:
        params: of the law.
        workspace: limits for the arm; Kwon's unless given.
        num_joints: of the arm.

    Raises:
        ParameterError: where a parameter is not valid.
    """

    def __init__(
        self,
        params: ShareParams,
        workspace: WorkspaceLimits | None = None,
        num_joints: int = 2,
    ) -> None:
        self.params = checked(params)
        self.workspace = checked(workspace or WorkspaceLimits())
        declare_decomposer_ports(
            self, num_joints, self._calc_base, self._calc_contribution, self._calc_arm
        )

    def law(
        self,
        command: Vector,
        at: Vector,
        _q: Vector,
        _smoothed: Vector,
        _estimate: Vector,
    ) -> tuple[Scalar, ...]:
        """Returns the components of `base_command` and of `arm_command`."""
        v_c, omega_c, v_z = command
        v_bm, omega_b = self._contribution(command, at)
        v_b = base_speed(v_bm, at[1], self.params.projection)
        return v_b, omega_b, v_c - v_bm, omega_c - omega_b, v_z

    def _calc_contribution(self, context: Any, output: Any) -> None:
        command, at = self.command.Eval(context), self.ee_cylindrical.Eval(context)
        output.SetFromVector(np.array(self._contribution(command, at)))

    def _contribution(self, command: Vector, at: Vector) -> tuple[Scalar, Scalar]:
        """Returns the components of `base_contribution`."""
        mu, nu = self.params.shares(self.workspace, command, at)
        return mu * command[0], nu * command[1]

    def _calc_base(self, context: Any, output: Any) -> None:
        v_bm, omega_b = self.base_contribution.Eval(context)
        psi = self.ee_cylindrical.Eval(context)[1]
        v_b = base_speed(v_bm, psi, self.params.projection)
        output.SetFromVector(np.array([v_b, omega_b]))

    def _calc_arm(self, context: Any, output: Any) -> None:
        v_c, omega_c, v_z = self.command.Eval(context)
        v_bm, omega_b = self.base_contribution.Eval(context)
        output.SetFromVector(np.array([v_c - v_bm, omega_c - omega_b, v_z]))


class CompensatedDecomposer(LeafSystem):
    """Chooses the base's motion first; the arm compensates for it exactly.

    A subclass has `arm`, and defines `base`, `compensation` and `status`.
    """

    arm: ArmKinematics

    def base(self, context: Any) -> tuple[Scalar, Scalar]:
        """Returns the `base_command`."""
        raise NotImplementedError

    def compensation(self, context: Any) -> Vector:
        """Returns the `arm_command`."""
        raise NotImplementedError

    def status(self, context: Any) -> Scalar:
        """Returns the sum of the `DecomposerStatus` flags that hold."""
        raise NotImplementedError

    def declare_ports(self) -> None:
        """Declares the ports."""
        declare_decomposer_ports(
            self,
            self.arm.num_joints,
            self._calc_base,
            self._calc_contribution,
            self._calc_arm,
            self._calc_status,
        )

    def _calc_base(self, context: Any, output: Any) -> None:
        output.SetFromVector(np.array(self.base(context)))

    def _calc_contribution(self, context: Any, output: Any) -> None:
        at = self.ee_cylindrical.Eval(context)
        rates = base_induced_rates(at, *self.base(context), self.arm.p_BS)
        output.SetFromVector(np.array(rates))

    def _calc_arm(self, context: Any, output: Any) -> None:
        output.SetFromVector(np.array(self.compensation(context)))

    def _calc_status(self, context: Any, output: Any) -> None:
        output.SetFromVector(np.array([self.status(context)]))
