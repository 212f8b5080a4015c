"""A robot's URDF loaded by `MultibodyPlant`: frames, limits, kinematics, drawing."""

from typing import Any, Protocol

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.arm.limits import JointLimits
from drake_mobman.frames import frame
from drake_mobman.robot_model.base_limits import BaseLimits
from drake_mobman.robot_model.plant_motion import PlantMotion
from drake_mobman.robot_model.reach import Reach
from drake_mobman.robot_model.rolling import RollingBase

BASE_JOINTS = 3
"""x, y and theta come first among a robot's positions; the arm's joints follow."""


class RobotDescription(Protocol):
    """A robot's parameters, and what follows from them.

    `arm` and `reach` read the robot's finalized plant, and make one unless given.
    """

    def defaults(self) -> list[Any]:
        """Returns parameters that fit the robot, at most one of each class."""

    def add_to(self, plant: Any) -> list[Any]:
        """Adds the robot to a plant that is not finalized; returns its model instances.

        It has bodies `base` (B), `tee` (T) and `tool` (E), and joints `x`, `y` and
        `theta` that move the base, each with an actuator, before those of the arm.
        """

    def add_rolling_to(self, plant: Any) -> RollingBase:
        """Adds the robot to a plant that is not finalized, on its own wheels.

        The same bodies at the same indices, but `base` is free and its driven wheels
        turn: there is no x, y and theta.

        Raises:
            ParameterError: where the robot has no wheels.
        """

    def arm(self, plant: Any = None) -> ArmKinematics:
        """Returns the arm's kinematics."""

    def reach(self, plant: Any = None) -> Reach:
        """Returns shoulder and reach for a base controller."""

    def arm_inverse(self, setup: Any) -> Any:
        """Returns the block that turns rates of the end effector into joint rates.

        Args:
            setup: a `RobotSetup`, of this robot.
        """


def drawn_plant(robot: RobotDescription) -> tuple[Any, Any]:
    """Returns the robot as a finalized `MultibodyPlant`, and its `SceneGraph`."""
    scene_graph, plant = SceneGraph(), MultibodyPlant(0.0)
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    robot.add_to(plant)
    plant.Finalize()
    return plant, scene_graph


def moving_joints(plant: Any) -> list[Any]:
    """Returns a finalized plant's movable joints, in the order of its positions.

    Drake numbers joints in the order of the URDF, but positions from the base on.
    """
    joints = map(plant.get_joint, plant.GetJointIndices())
    moving = [joint for joint in joints if joint.num_positions()]
    return sorted(moving, key=lambda joint: joint.position_start())


class RobotModel(PlantMotion):
    """A robot as a finalized `MultibodyPlant`, for kinematics; it is not simulated.

    Attributes:
        plant: positions x, y [m], theta [rad] of the base, then the arm's joints.
        arm_joints: names of the arm's joints, in the order of their positions.
        arm_bodies: indices in the plant of the bodies that these joints move, by name.
        joint_limits: of the arm's joints, from the URDF.
        base_limits: of the base, from the URDF.
    """

    def __init__(self, robot: RobotDescription) -> None:
        plant = MultibodyPlant(0.0)
        robot.add_to(plant)
        plant.Finalize()
        super().__init__(plant)
        arm = moving_joints(self.plant)[BASE_JOINTS:]
        self.arm_joints = [joint.name() for joint in arm]
        moved = self.plant.GetBodiesKinematicallyAffectedBy([x.index() for x in arm])
        self.arm_bodies = {self.plant.get_body(i).name(): int(i) for i in moved}
        self.joint_limits = joint_limits(self.plant)
        self.base_limits = base_limits(self.plant)

    def manipulability(self) -> float:
        """Returns sqrt(det(J J^T)) of T's velocity in B by the arm's joints.

        For an arm with fewer than three joints, sqrt(det(J^T J)).
        """
        base = frame(self.plant, "base")
        J = self.plant.CalcJacobianTranslationalVelocity(
            self._context,
            JacobianWrtVariable.kV,
            frame(self.plant, "tee"),
            np.zeros(3),
            base,
            base,
        )[:, BASE_JOINTS:]
        gram = J @ J.T if J.shape[1] >= 3 else J.T @ J
        return float(np.sqrt(max(np.linalg.det(gram), 0.0)))


def joint_limits(plant: Any) -> JointLimits:
    """Returns the limits of the arm's joints of a finalized plant."""
    return JointLimits(
        lower=plant.GetPositionLowerLimits()[BASE_JOINTS:],
        upper=plant.GetPositionUpperLimits()[BASE_JOINTS:],
        velocity=plant.GetVelocityUpperLimits()[BASE_JOINTS:],
        acceleration=plant.GetAccelerationUpperLimits()[BASE_JOINTS:],
    )


def base_limits(plant: Any) -> BaseLimits:
    """Returns the limits of the base of a finalized plant."""
    ahead, _, turn = moving_joints(plant)[:BASE_JOINTS]
    return BaseLimits(
        max_speed=float(ahead.velocity_upper_limits()[0]),
        max_acceleration=float(ahead.acceleration_upper_limits()[0]),
        max_yaw_rate=float(turn.velocity_upper_limits()[0]),
        max_yaw_acceleration=float(turn.acceleration_upper_limits()[0]),
    )
