"""No smoothing: the base gets its raw command."""

import dataclasses as dc
from typing import Any, ClassVar

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_mobman import signals
from drake_mobman.blocks import scalar_block
from drake_mobman.parameters import SPEED, YAW_RATE, within
from drake_mobman.robot_model import BaseLimits, RobotSetup
from drake_mobman.scalars import Scalar, Vector, finite_or_zero


@dc.dataclass
class Unsmoothed:
    """The base command is not smoothed, as in Kwon et al."""

    # Decomposers keep to these limits; a faster command is passed on unchanged.
    max_speed: float = 0.5  # Of the base, forward and back [m/s].
    max_yaw_rate: float = 1.0  # [rad/s].
    states: ClassVar[int] = 2

    def check(self) -> None:
        """Raises `ParameterError` unless both are in range."""
        within(self, SPEED, "max_speed")
        within(self, YAW_RATE, "max_yaw_rate")

    def limits(self) -> BaseLimits:
        """Returns the limits that decomposers keep to."""
        return BaseLimits(max_speed=self.max_speed, max_yaw_rate=self.max_yaw_rate)

    def next(self, _state: Vector, raw: Vector, _period: float) -> list[Scalar]:
        """Returns the next smoothed command (2,): the raw one, if it is finite."""
        return [finite_or_zero(x) for x in raw]

    def build(self, _setup: RobotSetup) -> "CommandPassThrough":
        """Returns the block for a robot."""
        return CommandPassThrough()


@scalar_block
class CommandPassThrough(LeafSystem):
    """Passes a base command on; a component that is not finite becomes zero.

    .. pydrake_system::

        name: CommandPassThrough
        input_ports:
        - base_command
        output_ports:
        - base_command_smoothed
    """

    def __init__(self) -> None:
        self.raw = self.DeclareVectorInputPort(signals.BASE_COMMAND, 2)
        self.DeclareVectorOutputPort(
            signals.BASE_COMMAND_SMOOTHED,
            2,
            self._calc,
            prerequisites_of_calc={self.all_input_ports_ticket()},
        )

    def _calc(self, context: Any, output: Any) -> None:
        raw = self.raw.Eval(context).tolist()
        output.SetFromVector(np.array([finite_or_zero(x) for x in raw]))


CommandPassThrough_ = CommandPassThrough.template
