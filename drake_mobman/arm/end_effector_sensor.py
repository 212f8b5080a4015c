"""Where the end effector is, from the joint angles in closed form."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_mobman import signals
from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.blocks import scalar_block, tickets
from drake_mobman.parameters import checked_period
from drake_mobman.scalars import Scalar, wrapped_angle


def unwrapped(angle: Scalar, last: Scalar) -> Scalar:
    """Returns `angle` [rad], plus the whole turns that bring it nearest to `last`."""
    return last + wrapped_angle(angle - last)


@scalar_block
class EndEffectorSensor(LeafSystem):
    """Measures the positions of end effector and wrist centre, from the joint angles.

    .. pydrake_system::

        name: EndEffectorSensor
        input_ports:
        - arm_position
        output_ports:
        - ee_cylindrical
        - p_BT

    A person who pulls the arm can take it over its own back, where no command steers
    it. There the joint angles alone give a psi that is a turn off. With `psi` and
    `period`, the sensor keeps the last psi as its state, and psi has no jump.

    Args:
        arm: the arm's kinematics.
        psi: psi at the start [rad], if it is to be kept.
        period: control period [s], if psi is to be kept.

    Raises:
        ParameterError: where `period` is not valid.
    """

    def __init__(
        self,
        arm: ArmKinematics,
        psi: float | None = None,
        period: float | None = None,
    ) -> None:
        self.arm, self.period = arm, period
        self.position = self.DeclareVectorInputPort(
            signals.ARM_POSITION, arm.num_joints
        )
        joints = tickets(self, self.position)
        self.ee_cylindrical = self.DeclareVectorOutputPort(
            signals.EE_CYLINDRICAL,
            3,
            self._calc_ee_cylindrical,
            prerequisites_of_calc=joints | {self.xd_ticket()},
        )
        self.DeclareVectorOutputPort(
            signals.P_BT, 3, self._calc_p_BT, prerequisites_of_calc=joints
        )
        if period is not None:
            self.DeclareDiscreteState(np.array([self.scalar(psi)]))
            self.DeclarePeriodicDiscreteUpdateEvent(
                checked_period(period), 0.0, self._keep_psi
            )

    def _calc_ee_cylindrical(self, context: Any, output: Any) -> None:
        q = self.position.Eval(context).tolist()
        l, psi, z = self.arm.ee_cylindrical(q)
        if self.period is not None:
            psi = unwrapped(psi, context.get_discrete_state_vector().GetAtIndex(0))
        output.SetFromVector(np.array([l, psi, z]))

    def _keep_psi(self, context: Any, state: Any) -> None:
        psi = self.ee_cylindrical.Eval(context)[1]
        state.get_mutable_vector().SetAtIndex(0, psi)

    def _calc_p_BT(self, context: Any, output: Any) -> None:
        q = self.position.Eval(context).tolist()
        output.SetFromVector(np.array(self.arm.p_BT(q)))


EndEffectorSensor_ = EndEffectorSensor.template
