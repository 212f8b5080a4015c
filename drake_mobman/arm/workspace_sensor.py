"""Where the hand is, told from the joint angles in closed form."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_mobman import signals
from drake_mobman.arm.kinematics import ArmKinematics


@TemplateSystem.define("WorkspaceSensor_")
def WorkspaceSensor_(T: Any) -> Any:
    """Returns the block for scalars of type `T`."""

    class Impl(LeafSystem_[T]):
        """Tells where end effector and wrist centre are, from the joints alone.

        .. pydrake_system::

            name: WorkspaceSensor
            input_ports:
            - arm_position
            output_ports:
            - workspace
            - p_BT

        Built as `WorkspaceSensor(arm)` from the arm's kinematics.
        """

        def _construct(self, arm: ArmKinematics, converter: Any = None) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            self.arm = arm
            self.position = self.DeclareVectorInputPort(
                signals.ARM_POSITION, arm.joints
            )
            needs = {self.all_input_ports_ticket()}
            self.DeclareVectorOutputPort(
                signals.WORKSPACE, 3, self._calc_workspace, prerequisites_of_calc=needs
            )
            self.DeclareVectorOutputPort(
                signals.P_BT, 3, self._calc_p_BT, prerequisites_of_calc=needs
            )

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(self, other.arm, converter=converter)

        def _calc_workspace(self, context: Any, output: Any) -> None:
            q = self.position.Eval(context).tolist()
            output.SetFromVector(np.array(self.arm.workspace(q)))

        def _calc_p_BT(self, context: Any, output: Any) -> None:
            q = self.position.Eval(context).tolist()
            output.SetFromVector(np.array(self.arm.p_BT(q)))

    return Impl


WorkspaceSensor = WorkspaceSensor_[None]
