"""What every fidelity has, so that one can replace another."""

from typing import Any, ClassVar, Protocol

from pydrake.systems.framework import Diagram

from drake_mobman.robot_model import RobotDescription, RobotSetup


class FidelityParams(Protocol):
    """Parameters of how a robot is simulated.

    Where a hand can pull the arm, there are also `build_guided` and `guided_plant`, as
    in `Servo`.
    """

    has_masses: ClassVar[bool]  # Without, the robot has its commanded velocity at once.

    def build(self, setup: RobotSetup, start: list[float]) -> Diagram:
        """Returns the robot as a diagram.

        Args:
            setup: of the robot.
            start: positions (3 + n,) of base and arm.

        Raises:
            ParameterError: where a parameter is not valid.
        """

    def plant(self, robot: RobotDescription) -> Any:
        """Returns the simulated plant alone; None where there is none."""

    def check_period(self, period: float) -> None:
        """Raises `ParameterError` unless it works at a control period [s]."""

    def aligned_with(self, period: float) -> tuple[float, Any]:
        """Returns period [s] and fidelity, the period an exact multiple of the step."""
