"""What every inverse of an arm has in common, so that one swaps for another."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_mobman import signals
from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.arm.limits import JointLimits
from drake_mobman.blocks import cached
from drake_mobman.parameters import checked_period


class ArmInverse(LeafSystem):
    """Turns the rates of `ee_cylindrical` into joint rates that the arm can make.

    A subclass defines `_invert`; both outputs use one evaluation of it.
    """

    def __init__(
        self, arm: ArmKinematics, joint_limits: JointLimits, period: float
    ) -> None:
        self.arm, self.joint_limits = arm, joint_limits
        self.period = checked_period(period)
        n = arm.num_joints
        self.command = self.DeclareVectorInputPort(signals.ARM_COMMAND, 3)
        self.position = self.DeclareVectorInputPort(signals.ARM_POSITION, n)
        self.inverted = cached(self, self._invert)
        for name, size, calc in (
            (signals.ARM_VELOCITY_COMMAND, n, self._calc_rates),
            (signals.ARM_STATUS, 1, self._calc_status),
        ):
            self.DeclareVectorOutputPort(
                name, size, calc, prerequisites_of_calc={self.inverted.ticket}
            )

    def _invert(self, context: Any) -> tuple[Any, ...]:
        """Returns the joint rates (n,) [rad/s], and the `ArmStatus` flags."""
        raise NotImplementedError

    def _calc_rates(self, context: Any, output: Any) -> None:
        output.SetFromVector(np.array(self.inverted(context)[0]))

    def _calc_status(self, context: Any, output: Any) -> None:
        output.SetFromVector(np.array([self.inverted(context)[1]]))
