"""What every smoothing of the base command has, so that one can replace another."""

from typing import Any, ClassVar, Protocol

from drake_mobman.robot_model import BaseLimits, RobotSetup
from drake_mobman.scalars import Vector


class SmoothingParams(Protocol):
    """Parameters of a block that turns `base_command` into `base_command_smoothed`."""

    max_speed: float  # Of the base, forward and back [m/s].
    max_yaw_rate: float  # [rad/s].
    states: ClassVar[int]  # Size of its state; the first two are the command.

    def limits(self) -> BaseLimits:
        """Returns the limits that the smoothed command keeps to."""

    def next(self, state: Vector, raw: Vector, period: float) -> Vector:
        """Returns the state after a period: the law.

        Args:
            state: begins with the last smoothed command (2,) [m/s], [rad/s]; all zero
                at rest.
            raw: `base_command` (2,).
            period: control period [s].
        """

    def build(self, setup: RobotSetup) -> Any:
        """Returns the block."""
