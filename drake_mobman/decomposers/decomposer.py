"""The decomposer's ports, and what all decomposers by shares have in common."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_mobman import signals
from drake_mobman.blocks import tickets
from drake_mobman.decomposers.share import Projection, WorkspaceLimits, base_speed
from drake_mobman.parameters import checked
from drake_mobman.scalars import Scalar


def declare_decomposer_ports(
    block: Any,
    num_joints: int,
    calc_base: Any,
    calc_share: Any,
    calc_arm: Any,
    calc_status: Any = None,
) -> None:
    """Declares the ports that every decomposer has, so that one swaps for another.

    What the base does may not depend on `base_command_smoothed`: the outputs'
    prerequisites say so, and the loop through smoother and decomposer is no algebraic
    one. One that can fall short of its command has `decomposer_status` besides.
    """
    block.command = block.DeclareVectorInputPort(signals.EE_COMMAND, 3)
    block.ee_cylindrical = block.DeclareVectorInputPort(signals.EE_CYLINDRICAL, 3)
    block.arm_position = block.DeclareVectorInputPort(signals.ARM_POSITION, num_joints)
    block.base_command_smoothed = block.DeclareVectorInputPort(
        signals.BASE_COMMAND_SMOOTHED, 2
    )
    told = block.command, block.ee_cylindrical, block.arm_position
    state = tickets(block, *told) | {block.xd_ticket()}
    smoothed = tickets(block, block.base_command_smoothed)
    block.base_command = block.DeclareVectorOutputPort(
        signals.BASE_COMMAND, 2, calc_base, prerequisites_of_calc=state
    )
    block.base_contribution = block.DeclareVectorOutputPort(
        signals.BASE_CONTRIBUTION, 2, calc_share, prerequisites_of_calc=state
    )
    block.arm_command = block.DeclareVectorOutputPort(
        signals.ARM_COMMAND, 3, calc_arm, prerequisites_of_calc=state | smoothed
    )
    if calc_status is not None:
        block.decomposer_status = block.DeclareVectorOutputPort(
            signals.DECOMPOSER_STATUS,
            1,
            calc_status,
            prerequisites_of_calc=state | smoothed,
        )


class ShareDecomposer(LeafSystem):
    """Splits the end effector's command between base and arm, by shares.

    The base gets its share of `v_c`, taken as a projection on the reach, and of
    `omega_c`; the arm gets what is left of each, and all of `v_z` (Kwon, eq. 16 with
    base and arm as in Algorithm 1). What the shares are, a subclass says.
    """

    def __init__(
        self,
        params: Any,
        workspace: WorkspaceLimits | None = None,
        projection: Projection | None = None,
        num_joints: int = 2,
    ) -> None:
        self.params = checked(params)
        self.workspace = checked(workspace or WorkspaceLimits())
        self.projection = checked(projection or Projection())
        declare_decomposer_ports(
            self, num_joints, self._calc_base, self._calc_contribution, self._calc_arm
        )

    @staticmethod
    def shares(
        params: Any, limits: WorkspaceLimits, command: Any, at: Any
    ) -> tuple[Scalar, Scalar]:
        """Returns the base's shares of `v_c` and of `omega_c`, each in [0, 1].

        Args:
            params: of the law.
            limits: of the workspace.
            command: `ee_command` (3,).
            at: `ee_cylindrical` (3,).
        """
        raise NotImplementedError

    def _calc_contribution(self, context: Any, output: Any) -> None:
        command, at = self.command.Eval(context), self.ee_cylindrical.Eval(context)
        mu, nu = self.shares(self.params, self.workspace, command, at)
        output.SetFromVector(np.array([mu * command[0], nu * command[1]]))

    def _calc_base(self, context: Any, output: Any) -> None:
        v_bm, omega_b = self.base_contribution.Eval(context)
        psi = self.ee_cylindrical.Eval(context)[1]
        v_b = base_speed(v_bm, psi, self.projection)
        output.SetFromVector(np.array([v_b, omega_b]))

    def _calc_arm(self, context: Any, output: Any) -> None:
        v_c, omega_c, v_z = self.command.Eval(context)
        v_bm, omega_b = self.base_contribution.Eval(context)
        output.SetFromVector(np.array([v_c - v_bm, omega_c - omega_b, v_z]))
