"""Tele-operation by the field: the base follows the hand, the arm does the rest.

Petric & Zlajpah, eqs. 1-6, for the base; their controller needs the arm's joint
angles alone, and so works under tele-operation too.
"""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.base.velocity_field import (
    Reach,
    VelocityField,
    check_zones,
    field_velocity,
)
from drake_mobman.decomposers.decomposer import declare_decomposer_ports
from drake_mobman.decomposers.rest import carried_rates, exact_rest
from drake_mobman.parameters import checked


@TemplateSystem.define("FieldDecomposer_")
def FieldDecomposer_(T: Any) -> Any:
    """Returns the block for scalars of type `T`."""

    class Impl(LeafSystem_[T]):
        """Drives the base by the field, and gives the arm exactly the rest.

        .. pydrake_system::

            name: FieldDecomposer
            input_ports:
            - ee_command
            - workspace
            - arm_position
            - base_sent
            output_ports:
            - base_command
            - base_share
            - arm_command

        Built as `FieldDecomposer(params, reach, arm)`: a `VelocityField`, the arm's
        `Reach` and its kinematics. Raises `ParameterError` as the field's own block.
        """

        def _construct(
            self,
            params: VelocityField,
            reach: Reach,
            arm: ArmKinematics,
            converter: Any = None,
        ) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            self.params = checked(params)
            self.reach = checked(reach)
            self.arm = arm
            check_zones(params, reach)
            declare_decomposer_ports(
                self, arm.joints, self._calc_base, self._calc_share, self._calc_arm
            )

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(
                self, other.params, other.reach, other.arm, converter=converter
            )

        def _calc_base(self, context: Any, output: Any) -> None:
            p_BT = self.arm.p_BT(self.arm_position.Eval(context))
            output.SetFromVector(
                np.array(field_velocity(p_BT, self.params, self.reach))
            )

        def _calc_share(self, context: Any, output: Any) -> None:
            v_b, omega_b = self.base_command.Eval(context)
            workspace = self.workspace.Eval(context)
            p_BS = self.arm.p_BS
            output.SetFromVector(np.array(carried_rates(workspace, v_b, omega_b, p_BS)))

        def _calc_arm(self, context: Any, output: Any) -> None:
            rest = exact_rest(
                self.command.Eval(context),
                self.workspace.Eval(context),
                self.base_sent.Eval(context),
                self.arm.p_BS,
            )
            output.SetFromVector(np.array(rest))

    return Impl


FieldDecomposer = FieldDecomposer_[None]
