"""What every base controller has, so that one can replace another."""

from typing import Any, Protocol, runtime_checkable

from drake_mobman.arm.first_joint import FirstJoint
from drake_mobman.robot_model import Reach, RobotSetup
from drake_mobman.scalars import Scalar, Vector


@runtime_checkable
class BaseControllerParams(Protocol):
    """Parameters of a controller that drives the base by the position of T."""

    def build(self, setup: RobotSetup) -> Any:
        """Returns the block.

        Its inputs are `p_BT`, and `arm_position` if needed; its output `base_command`.

        Raises:
            ParameterError: where a parameter is not valid for the robot.
        """

    def check_reach(self, reach: Reach) -> None:
        """Raises `ParameterError` unless the controller fits an arm of this reach."""

    def command(
        self, p_BT: Vector, reach: Reach, joint: FirstJoint | None
    ) -> tuple[Scalar, Scalar, Scalar]:
        """Returns v [m/s], omega [rad/s], and 1 where the first joint holds the base.

        Args:
            p_BT: position of T in B (3,) [m].
            reach: of the arm.
            joint: the arm's first; None where it has no limits.
        """
