"""Where the hand is, told from the joint angles in closed form."""

from typing import Any

import numpy as np
from pydrake.math import atan2, cos, sin
from pydrake.systems.framework import LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_mobman import signals
from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.parameters import checked_period
from drake_mobman.scalars import Scalar


def unwrapped(angle: Scalar, last: Scalar) -> Scalar:
    """Returns `angle` [rad], less as many turns as are between it and `last`."""
    step = angle - last
    return last + atan2(sin(step), cos(step))


@TemplateSystem.define("EndEffectorSensor_")
def EndEffectorSensor_(T: Any) -> Any:
    """Returns the block for scalars of type `T`."""

    class Impl(LeafSystem_[T]):
        """Tells where end effector and wrist centre are, from the joints.

        .. pydrake_system::

            name: EndEffectorSensor
            input_ports:
            - arm_position
            output_ports:
            - workspace
            - p_BT

        Built as `EndEffectorSensor(arm)` from the arm's kinematics. One that is pulled
        gets where no hand steers it, over its own back, and there the joints alone
        tell psi a turn off. `EndEffectorSensor(arm, psi, period)`, psi at the start
        [rad] and the control period [s], tells it on from its state, the psi last told.
        Raises `ParameterError` where the period is none.
        """

        def _construct(
            self,
            arm: ArmKinematics,
            psi: float | None = None,
            period: float | None = None,
            converter: Any = None,
        ) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            self.arm, self.psi, self.period = arm, psi, period
            self.position = self.DeclareVectorInputPort(
                signals.ARM_POSITION, arm.num_joints
            )
            needs = {self.all_input_ports_ticket()}
            self.workspace = self.DeclareVectorOutputPort(
                signals.EE_CYLINDRICAL,
                3,
                self._calc_workspace,
                prerequisites_of_calc=needs | {self.xd_ticket()},
            )
            self.DeclareVectorOutputPort(
                signals.P_BT, 3, self._calc_p_BT, prerequisites_of_calc=needs
            )
            if period is not None:
                self.DeclareDiscreteState(np.array([T(psi)]))
                self.DeclarePeriodicDiscreteUpdateEvent(
                    checked_period(period), 0.0, self._keep_psi
                )

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(
                self, other.arm, other.psi, other.period, converter=converter
            )

        def _calc_workspace(self, context: Any, output: Any) -> None:
            q = self.position.Eval(context).tolist()
            l, psi, z = self.arm.ee_cylindrical(q)
            if self.period is not None:
                psi = unwrapped(psi, context.get_discrete_state_vector().GetAtIndex(0))
            output.SetFromVector(np.array([l, psi, z]))

        def _keep_psi(self, context: Any, state: Any) -> None:
            state.get_mutable_vector().SetAtIndex(0, self.workspace.Eval(context)[1])

        def _calc_p_BT(self, context: Any, output: Any) -> None:
            q = self.position.Eval(context).tolist()
            output.SetFromVector(np.array(self.arm.p_BT(q)))

    return Impl


EndEffectorSensor = EndEffectorSensor_[None]
