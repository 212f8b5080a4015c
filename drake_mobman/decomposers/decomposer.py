"""The decomposer's ports, and the block made from a law of shares."""

from collections.abc import Callable
from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_mobman import signals
from drake_mobman.decomposers.share import Projection, Workspace, base_speed
from drake_mobman.parameters import checked
from drake_mobman.scalars import Scalar

ShareLaw = Callable[[Any, Workspace, Any, Any], tuple[Scalar, Scalar]]
"""`law(params, limits, command, workspace)` returns the base's shares of the linear
and of the angular command, each in [0, 1]; `command` and `workspace` are the signals
`ee_command` and `workspace`."""


def declare_decomposer_ports(
    block: Any,
    joints: int,
    calc_base: Any,
    calc_share: Any,
    calc_arm: Any,
    calc_status: Any = None,
) -> None:
    """Declares the ports that every decomposer has, so that one swaps for another.

    What the base does may not depend on `base_sent`: the outputs' prerequisites say
    so, and the loop through smoother and decomposer is no algebraic one. A decomposer
    that can fall short of its command has `decomposer_status` besides.
    """
    block.command = block.DeclareVectorInputPort(signals.EE_COMMAND, 3)
    block.workspace = block.DeclareVectorInputPort(signals.WORKSPACE, 3)
    block.arm_position = block.DeclareVectorInputPort(signals.ARM_POSITION, joints)
    block.base_sent = block.DeclareVectorInputPort(signals.BASE_SENT, 2)
    state = {
        block.input_port_ticket(port.get_index())
        for port in (block.command, block.workspace, block.arm_position)
    } | {block.xd_ticket()}
    sent = block.input_port_ticket(block.base_sent.get_index())
    block.base_command = block.DeclareVectorOutputPort(
        signals.BASE_COMMAND, 2, calc_base, prerequisites_of_calc=state
    )
    block.base_share = block.DeclareVectorOutputPort(
        signals.BASE_SHARE, 2, calc_share, prerequisites_of_calc=state
    )
    block.arm_command = block.DeclareVectorOutputPort(
        signals.ARM_COMMAND, 3, calc_arm, prerequisites_of_calc=state | {sent}
    )
    if calc_status is not None:
        block.decomposer_status = block.DeclareVectorOutputPort(
            signals.DECOMPOSER_STATUS,
            1,
            calc_status,
            prerequisites_of_calc=state | {sent},
        )


def share_decomposer(name: str, law: ShareLaw) -> Any:
    """Returns the block template of a decomposer that splits by shares.

    The base gets its share of `v_c`, taken as a projection on the reach, and of
    `omega_c`; the arm gets what is left of each, and all of `v_z` (Kwon, eq. 16 with
    base and arm as in Algorithm 1). Written for any scalar the law passes through.

    Args:
        name: of the template; by Drake's habit it ends in an underscore.
        law: the shares.

    The block is built as `Block(params, limits, projection, joints)`: the law's own
    parameters, the arm's `Workspace`, the base's `Projection`, and the arm's number
    of joints. It raises `ParameterError` where one of them is not valid.
    """

    @TemplateSystem.define(name)
    def ShareDecomposer_(T: Any) -> Any:
        class Impl(LeafSystem_[T]):
            """Splits the operator's command between base and arm.

            .. pydrake_system::

                name: ShareDecomposer
                input_ports:
                - ee_command
                - workspace
                - arm_position
                - base_sent
                output_ports:
                - base_command
                - base_share
                - arm_command
            """

            def _construct(
                self,
                params: Any,
                limits: Workspace | None = None,
                projection: Projection | None = None,
                joints: int = 2,
                converter: Any = None,
            ) -> None:
                LeafSystem_[T].__init__(self, converter=converter)
                self.params = checked(params)
                self.limits = checked(limits or Workspace())
                self.projection = checked(projection or Projection())
                self.joints = joints
                declare_decomposer_ports(
                    self, joints, self._calc_base, self._calc_share, self._calc_arm
                )

            def _construct_copy(self, other: Any, converter: Any = None) -> None:
                Impl._construct(
                    self,
                    other.params,
                    other.limits,
                    other.projection,
                    other.joints,
                    converter=converter,
                )

            def _calc_share(self, context: Any, output: Any) -> None:
                command = self.command.Eval(context)
                workspace = self.workspace.Eval(context)
                mu, nu = law(self.params, self.limits, command, workspace)
                output.SetFromVector(np.array([mu * command[0], nu * command[1]]))

            def _calc_base(self, context: Any, output: Any) -> None:
                v_bm, omega_b = self.base_share.Eval(context)
                psi = self.workspace.Eval(context)[1]
                v_b = base_speed(v_bm, psi, self.projection)
                output.SetFromVector(np.array([v_b, omega_b]))

            def _calc_arm(self, context: Any, output: Any) -> None:
                v_c, omega_c, v_z = self.command.Eval(context)
                v_bm, omega_b = self.base_share.Eval(context)
                output.SetFromVector(np.array([v_c - v_bm, omega_c - omega_b, v_z]))

        return Impl

    return ShareDecomposer_
