"""What stands between a base command and the base."""

from typing import Any, Protocol

from drake_mobman.robot_model import BaseLimits, RobotSetup


class SmoothingParams(Protocol):
    """Parameters of what makes `base_command_smoothed` of `base_command`."""

    max_speed: float  # Of the base, forward and back [m/s].
    max_yaw_rate: float  # [rad/s].

    def limits(self) -> BaseLimits:
        """Returns the limits that the base keeps to behind it."""

    def build(self, setup: RobotSetup) -> Any:
        """Returns the block."""
