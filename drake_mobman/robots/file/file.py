"""Anyone's robot, described by a file."""

import dataclasses as dc
from pathlib import Path
from typing import Any

from drake_mobman.arm.damped_inverse import DampedInverse
from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.oriented_inverse import OrientedInverse
from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import Reach, RobotModel, RobotSetup
from drake_mobman.robot_model.rolling import RollingBase, no_wheels
from drake_mobman.robots.file.described import Described, RobotFileError, described
from drake_mobman.robots.file.resolved import Resolved, resolve


@dc.dataclass
class File:
    """A robot described by a file, which names its model, base, arm and tool."""

    path: str = ""  # Of the file, relative to that of the scenario; or a known name.

    def check(self) -> None:
        """Raises `ParameterError` unless the file describes a robot."""
        self.described()

    def described(self) -> Described:
        """Returns the robot file with its models.

        Raises:
            ParameterError: where it cannot be used.
        """
        if not self.path:
            raise ParameterError("path", self.path, "must be the path of a robot file")
        return described(Path(self.path).absolute())

    def resolved(self) -> Resolved:
        """Returns all that is known of the robot, as given or as derived."""
        robot = self.described()
        try:
            return resolve(robot)
        except RobotFileError:
            raise
        except ParameterError as error:
            raise RobotFileError(robot.path.name, error) from None

    def defaults(self) -> list[Any]:
        """Returns parameters that fit the robot, for what a scenario leaves out."""
        return self.resolved().defaults()

    def add_to(self, plant: Any) -> list[Any]:
        """Adds the robot to a plant; returns its model instances."""
        return self.described().assembly.add_to(plant)

    def add_rolling_to(self, plant: Any) -> RollingBase:
        """Adds the robot to a plant on its own wheels.

        Raises:
            ParameterError: where it has no wheels, or they do not roll ahead.
        """
        robot = self.described()
        if not robot.layout.wheels:
            raise no_wheels(self)
        track = self.resolved().track
        assert track is not None
        return robot.assembly.add_rolling_to(plant, track.value)

    def arm(self, plant: Any = None) -> JacobianArm:
        """Returns the arm's kinematics, by its Jacobian."""
        known = self.resolved()
        level = known.orientation.value != "free"
        return JacobianArm(
            plant or RobotModel(self).plant,
            known.posture.value,
            known.damping.value,
            level=level,
        )

    def reach(self, plant: Any = None) -> Reach:
        """Returns shoulder and reach for a base controller, measured on the model."""
        del plant
        return self.resolved().reach.value

    def arm_inverse(self, setup: RobotSetup) -> Any:
        """Returns the arm's inverse, by its Jacobian."""
        arm: Any = setup.arm
        limits, period = setup.joint_limits, setup.period
        orientation = self.resolved().orientation.value
        if orientation in {"reach", "free"}:
            return DampedInverse(arm, limits, period)
        return OrientedInverse(arm, limits, period, orientation)
