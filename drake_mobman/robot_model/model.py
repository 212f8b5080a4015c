"""A robot's URDF loaded by `MultibodyPlant`: frames, limits, kinematics, drawing."""

from typing import Any, Protocol

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, JacobianWrtVariable

from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.arm.limits import JointLimits
from drake_mobman.frames import frame
from drake_mobman.robot_model.base_limits import BaseLimits
from drake_mobman.robot_model.reach import Reach

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


class RobotModel:
    """A robot as a finalized `MultibodyPlant`, for kinematics; it is not simulated.

    Attributes:
        plant: positions x, y [m], theta [rad] of the base, then the arm's joints.
        arm_joints: names of the arm's joints, in the order of their positions.
        arm_bodies: indices in the plant of the bodies that these joints move, by name.
        joint_limits: of the arm's joints, from the URDF.
        base_limits: of the base, from the URDF.
    """

    def __init__(self, robot: RobotDescription) -> None:
        self.plant = MultibodyPlant(0.0)
        robot.add_to(self.plant)
        self.plant.Finalize()
        arm = moving_joints(self.plant)[BASE_JOINTS:]
        self.arm_joints = [joint.name() for joint in arm]
        moved = self.plant.GetBodiesKinematicallyAffectedBy([x.index() for x in arm])
        self.arm_bodies = {self.plant.get_body(i).name(): int(i) for i in moved}
        self.joint_limits = joint_limits(self.plant)
        self.base_limits = base_limits(self.plant)
        self._context = self.plant.CreateDefaultContext()

    def set_state(self, q: Any, v: Any) -> None:
        """Sets positions and velocities of base and arm, (3 + n,) each."""
        self.plant.SetPositions(self._context, q)
        self.plant.SetVelocities(self._context, v)

    def p_W(self, link: str) -> Any:
        """Returns the position (3,) of a link's origin in W [m]."""
        return frame(self.plant, link).CalcPoseInWorld(self._context).translation()

    def v_W(self, link: str) -> Any:
        """Returns the velocity (3,) of a link's origin in W [m/s]."""
        found = frame(self.plant, link)
        return found.CalcSpatialVelocityInWorld(self._context).translational()

    def motion_W(self, body: Any, state: Any) -> tuple[Any, Any]:
        """Returns position [m] and velocity [m/s] (3,) in W of a body's origin.

        Faster than `p_W` and `v_W` after `set_state`.

        Args:
            body: of the plant.
            state: positions of base and arm, then velocities, 2 (3 + n,).
        """
        X_WB, V_WB = self._motion(body, state)
        return X_WB.translation(), V_WB.translational()

    def point_W(self, body: int, p_BQ: Any, state: Any) -> tuple[Any, Any]:
        """Returns position [m] and velocity [m/s] (3,) in W of a point Q of a body B.

        Args:
            body: index of B in the plant.
            p_BQ: position of Q in B (3,) [m].
            state: positions of base and arm, then velocities, 2 (3 + n,).
        """
        X_WB, V_WB = self._motion(self.plant.get_body(BodyIndex(body)), state)
        V_WQ = V_WB.Shift(X_WB.rotation() @ p_BQ)
        return X_WB @ p_BQ, V_WQ.translational()

    def _motion(self, body: Any, state: Any) -> tuple[Any, Any]:
        """Returns pose and spatial velocity in W of a body."""
        self.plant.SetPositionsAndVelocities(self._context, state)
        return (
            self.plant.EvalBodyPoseInWorld(self._context, body),
            self.plant.EvalBodySpatialVelocityInWorld(self._context, body),
        )

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
