"""The robot of Petric & Zlajpah: a Franka Emika arm on a TIAGo base."""

import dataclasses as dc
import math
from typing import Any

import numpy as np

from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.base.velocity_field import Reach
from drake_mobman.parameters import positive
from drake_mobman.robots.model import RobotModel, filled_urdf

POSTURE = (0.0, 0.4, 0.0, -2.1, 0.0, 2.5, math.pi / 4)
"""Angles of joints 1 to 7 to start from and to fall back to [rad].

The elbow is near a right angle and T half a metre ahead of the shoulder, at its height:
far from either border, so that the base rests. The hand points straight down.
"""


@dc.dataclass
class FrankaTiago:
    """Seven joints on a base with two driven wheels, by their makers' numbers."""

    mount: float = 0.1  # From the base's top up to the arm's foot [m].

    def check(self) -> None:
        """Raises `ParameterError` where a length is not one."""
        positive(self, "mount")

    def urdf(self) -> str:
        """Returns the robot as URDF."""
        return filled_urdf("franka_tiago", mount=self.mount)

    def reach(self) -> Reach:
        """Returns the arm as a velocity field sees it, measured on the model."""
        arm = reduced_arm(RobotModel(self).plant)
        return Reach(arm.l_0, arm.r_f, arm.p_BS[0])

    def arm(self) -> JacobianArm:
        """Returns the arm's kinematics, by its Jacobian."""
        return JacobianArm(RobotModel(self).plant, POSTURE)


@dc.dataclass(frozen=True)
class ReducedArm:
    """The arm without its wrist: shoulder, elbow and wrist centre (fig. 1)."""

    p_BS: tuple[float, float, float]  # Shoulder, where axes 1, 2 and 3 meet, in B [m].
    l_1: float  # From the shoulder to the elbow, which is on axis 4 [m].
    l_2: float  # From the elbow to T, where axes 5 and 6 meet [m].

    @property
    def l_0(self) -> float:
        """Height of the shoulder above the floor [m]."""
        return self.p_BS[2]

    @property
    def r_f(self) -> float:
        """Farthest that T gets from the shoulder [m]."""
        return self.l_1 + self.l_2


def reduced_arm(plant: Any) -> ReducedArm:
    """Returns the arm's lengths, measured on a finished plant of this robot.

    The joints between two of the points turn about one of them, so that the lengths
    are the same in any position.
    """
    context = plant.CreateDefaultContext()

    def p(link: str, seen_from: str) -> Any:
        frame = plant.GetFrameByName(link)
        X = frame.CalcPose(context, plant.GetFrameByName(seen_from))
        return X.translation()

    return ReducedArm(
        p_BS=tuple(p("link2", "base").tolist()),
        l_1=float(np.linalg.norm(p("link4", "link2"))),
        l_2=float(np.linalg.norm(p("tee", "link4"))),
    )


@dc.dataclass(frozen=True)
class DriveBase:
    """The platform: what its wheels are, and how fast they may take it."""

    wheel_radius: float  # [m].
    track: float  # From wheel to wheel [m].
    max_speed: float  # [m/s].
    max_yaw_rate: float  # [rad/s].
    max_acceleration: float  # [m/s^2].
    max_yaw_acceleration: float  # [rad/s^2].


def drive_base(plant: Any) -> DriveBase:
    """Returns the base's numbers, read from a finished plant of this robot."""
    context = plant.CreateDefaultContext()
    base = plant.GetFrameByName("base")
    left, right = (
        plant.GetFrameByName(f"{side}_wheel").CalcPose(context, base).translation()
        for side in ("left", "right")
    )
    ahead, turn = plant.GetJointByName("x"), plant.GetJointByName("theta")
    return DriveBase(
        wheel_radius=float(left[2]),  # The floor is at z = 0.
        track=float(left[1] - right[1]),
        max_speed=float(ahead.velocity_upper_limits()[0]),
        max_yaw_rate=float(turn.velocity_upper_limits()[0]),
        max_acceleration=float(ahead.acceleration_upper_limits()[0]),
        max_yaw_acceleration=float(turn.acceleration_upper_limits()[0]),
    )
