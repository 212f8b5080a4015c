"""Tele-operation by the field: the base follows the hand, the arm does the rest.

Petric & Zlajpah, eqs. 1-6, for the base; their controller needs the arm's joint
angles alone, and so works under tele-operation too.
"""

from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import LeafSystem_, ValueProducer
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_mobman.arm.first_joint import first_joint
from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.base.velocity_field import (
    Reach,
    VelocityField,
    Zone,
    check_zones,
    field_velocity,
    field_zone,
)
from drake_mobman.decomposers.arm_compensation import (
    arm_compensation,
    base_induced_rates,
)
from drake_mobman.decomposers.decomposer import declare_decomposer_ports
from drake_mobman.decomposers.limiter import Limiter
from drake_mobman.decomposers.status import DecomposerStatus
from drake_mobman.parameters import checked
from drake_mobman.scalars import Scalar, where


def field_base(
    q: Any,
    params: VelocityField,
    reach: Reach,
    arm: ArmKinematics,
    limiter: Limiter | None,
) -> tuple[Scalar, Scalar, Scalar]:
    """Returns v_b [m/s] and omega_b [rad/s] of the base, and the status.

    What the field asks for, as far as the arm can give way to it.

    Args:
        q: joint angles (n,) [rad].
        params: of the field.
        reach: of the arm, as the field sees it.
        arm: whose joints these are.
        limiter: of its joints; None for joints without ends.
    """
    p_BT = arm.p_BT(q)
    if limiter is None:
        return *field_velocity(p_BT, params, reach), 0.0 * q[0]
    joint = first_joint(q, limiter.joints)
    v, omega = field_velocity(p_BT, params, reach, joint)
    v_b, omega_b, share = limiter.given_way(q, v, omega)
    flag = float(DecomposerStatus.BASE_HELD)
    turned_less = field_zone(p_BT, params, reach, joint) >= float(Zone.HELD)
    status = where(share < 1, flag, where(turned_less, flag, 0.0 * q[0]))
    return v_b, omega_b, status


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
            - base_command_smoothed
            output_ports:
            - base_command
            - base_contribution
            - arm_command
            - decomposer_status

        Built as `FieldDecomposer(params, reach, arm, limiter=None)`: a `VelocityField`,
        the arm's `Reach` and its kinematics, and the `Limiter` of its joints, or None
        for joints without ends. Raises `ParameterError` as the field's own block.
        """

        def _construct(
            self,
            params: VelocityField,
            reach: Reach,
            arm: ArmKinematics,
            limiter: Limiter | None = None,
            converter: Any = None,
        ) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            self.params = checked(params)
            self.reach = checked(reach)
            self.arm = arm
            self.limiter = limiter
            check_zones(params, reach)
            declare_decomposer_ports(
                self,
                arm.num_joints,
                self._calc_base,
                self._calc_share,
                self._calc_arm,
                self._calc_status,
            )
            self.followed = self.DeclareCacheEntry(
                "base and status",
                ValueProducer(
                    allocate=lambda: AbstractValue.Make(()), calc=self._calc_followed
                ),
                {self.input_port_ticket(self.arm_position.get_index())},
            )

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(
                self,
                other.params,
                other.reach,
                other.arm,
                other.limiter,
                converter=converter,
            )

        def _calc_followed(self, context: Any, value: Any) -> None:
            q = self.arm_position.Eval(context)
            value.set_value(
                field_base(q, self.params, self.reach, self.arm, self.limiter)
            )

        def _calc_base(self, context: Any, output: Any) -> None:
            v_b, omega_b, _ = self.followed.Eval(context)
            output.SetFromVector(np.array([v_b, omega_b]))

        def _calc_status(self, context: Any, output: Any) -> None:
            output.SetFromVector(np.array([self.followed.Eval(context)[2]]))

        def _calc_share(self, context: Any, output: Any) -> None:
            v_b, omega_b = self.base_command.Eval(context)
            workspace = self.workspace.Eval(context)
            p_BS = self.arm.p_BS
            output.SetFromVector(
                np.array(base_induced_rates(workspace, v_b, omega_b, p_BS))
            )

        def _calc_arm(self, context: Any, output: Any) -> None:
            rest = arm_compensation(
                self.command.Eval(context),
                self.workspace.Eval(context),
                self.base_command_smoothed.Eval(context),
                self.arm.p_BS,
            )
            output.SetFromVector(np.array(rest))

    return Impl


FieldDecomposer = FieldDecomposer_[None]
