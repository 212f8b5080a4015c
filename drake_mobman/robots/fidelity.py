"""What every fidelity has, so that one swaps for another."""

from typing import Any, ClassVar, Protocol

from pydrake.systems.framework import Diagram

from drake_mobman.robot_model import RobotDescription, RobotSetup


class FidelityParams(Protocol):
    """Parameters of how a robot is simulated.

    With forces, a hand may pull the arm: then there are `build_guided` and
    `guided_plant` too, as `Servo` has them.
    """

    has_masses: ClassVar[bool]  # Else the robot has a commanded velocity at once.

    def build(self, setup: RobotSetup, start: list[float]) -> Diagram:
        """Returns the robot as a diagram.

        Args:
            setup: of the robot.
            start: positions (3 + n,) of base and arm.

        Raises:
            ParameterError: where a parameter is not valid.
        """

    def plant(self, robot: RobotDescription) -> Any:
        """Returns the plant that is stepped, by itself; None where there is none."""

    def check_period(self, period: float) -> None:
        """Raises `ParameterError` unless it works at a control period [s]."""

    def aligned_with(self, period: float) -> tuple[float, Any]:
        """Returns the period [s], and the fidelity, in whole steps to the last bit."""
