"""The robot of Petric & Zlajpah: a Franka Emika arm on a TIAGo base."""

import dataclasses as dc
import math
from typing import Any

import numpy as np
from pydrake.math import RollPitchYaw, cos, sin

from drake_mobman.arm.damped_inverse import DampedInverse
from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.oriented_inverse import ORIENTATIONS, OrientedInverse
from drake_mobman.base.smoother import Smoother
from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.decomposers.blending import Blending
from drake_mobman.decomposers.exact import Exact
from drake_mobman.guidance.guiding_hand import Hand, Waypoint
from drake_mobman.parameters import ANGLE, OFFSET, Range, one_of, within
from drake_mobman.robot_model import Reach, RobotModel, RobotSetup, WorkspaceLimits
from drake_mobman.robot_model.rolling import RollingBase
from drake_mobman.robots.base_joints import rolling_base, weld_wheels
from drake_mobman.robots.defaults import Start
from drake_mobman.robots.urdf import add_urdf, filled_urdf
from drake_mobman.scalars import Scalar

POSTURE = (0.0, 0.4, 0.0, -2.1, 0.0, 2.5, math.pi / 4)
"""Angles of joints 1 to 7 at the start, which the arm returns to [rad].

The elbow is near a right angle and T half a metre ahead of the shoulder, at its height:
far from both zones of the field, so that the base rests. The end effector points
straight down.
"""

_CASTERS = [(x, y, 0.025) for x in (0.1695, -0.1735) for y in (0.102, -0.102)]
"""x, y and radius of each, as drawn [m]."""


@dc.dataclass
class FrankaTiago:
    """Seven joints on a base with two driven wheels, with the makers' data."""

    mount: float = 0.1  # From the base's top up to the arm's foot [m].
    mount_ahead: float = 0.0  # Of the arm's foot from the base's centre [m].
    mount_aside: float = 0.0  # The same to the left [m].
    mount_yaw: float = 0.0  # Turns the arm's foot about its axis [rad].
    # Yaw of the level end effector: along the `reach`; or, independent of reach and
    # base, turned in W at omega_c (`turning`) or held in W (`held`).
    orientation: str = "turning"

    def check(self) -> None:
        """Raises `ParameterError` where a length or the orientation is not valid."""
        one_of(self, "orientation", ORIENTATIONS)
        within(self, Range(0.01, 2.0, "m"), "mount")
        within(self, OFFSET, "mount_ahead", "mount_aside")
        within(self, ANGLE, "mount_yaw")

    def defaults(self) -> list[Any]:
        """Returns parameters that fit the robot, for what a scenario leaves out.

        At the posture's height the end effector can be level from l = 0.25 to 0.8 m,
        but the arm is slow near both ends.
        """
        return [
            Start(l=0.58, z=-0.21),
            WorkspaceLimits(l_min=0.48, l_max=0.66, psi_min=-0.5, psi_max=0.5),
            # The transition is 5 cm wide: the base has authority at the limit.
            Exact(alpha=60.0, phi_min=0.15, phi_max=0.5),
            Blending(alpha=60.0),
            VelocityField(Delta_f=0.15, Delta_r=0.1, b_d=0.3, phi_min=0.2, phi_max=0.6),
            # Half of what the TIAGo base can do.
            Smoother(
                max_speed=0.5,
                max_acceleration=1.0,
                max_yaw_rate=1.0,
                max_yaw_acceleration=2.0,
            ),
            Hand(path=[Waypoint(x=0.58, z=0.42 + self.mount)]),
        ]

    def add_to(self, plant: Any) -> list[Any]:
        """Adds the robot to a plant; returns its model instances."""
        instances = add_urdf(plant, self.urdf())
        weld_wheels(plant)
        return instances

    def add_rolling_to(self, plant: Any) -> RollingBase:
        """Adds the robot to a plant, on its own wheels."""
        return rolling_base(plant, add_urdf(plant, self.urdf()), _CASTERS)

    def urdf(self) -> str:
        """Returns the robot as URDF."""
        return filled_urdf(
            "franka_tiago",
            mount=self.mount,
            ahead=self.mount_ahead,
            aside=self.mount_aside,
            yaw=self.mount_yaw,
        )

    def reach(self, plant: Any = None) -> Reach:
        """Returns shoulder and reach for a base controller, measured on the model."""
        arm = reduced_arm(plant or RobotModel(self).plant)
        d, e, l_0 = arm.p_BS
        return Reach(l_0, arm.r_f, d, e)

    def arm(self, plant: Any = None) -> JacobianArm:
        """Returns the arm's kinematics, by its Jacobian; T and E in closed form."""
        return JacobianArm(plant or RobotModel(self).plant, POSTURE)

    def arm_inverse(self, setup: RobotSetup) -> Any:
        """Returns the arm's inverse, by its Jacobian."""
        arm: Any = setup.arm
        limits, period = setup.joint_limits, setup.period
        if self.orientation == "reach":
            return DampedInverse(arm, limits, period)
        return OrientedInverse(arm, limits, period, self.orientation)


@dc.dataclass(frozen=True)
class ReducedArm:
    """Shoulder, elbow, wrist centre (fig. 1) and end effector in closed form.

    The first three axes meet in the shoulder; the fourth goes through the elbow; the
    next two meet in the wrist centre, and the end effector is on the last. At zero, the
    arm lies in the x-z plane of its foot.
    """

    p_BS: tuple[float, float, float]  # Shoulder in B [m].
    yaw: float  # Of the arm's foot in B [rad].
    elbow: tuple[float, float]  # Ahead of and above the shoulder, arm at zero [m].
    wrist: tuple[float, float]  # T ahead of and above the elbow, arm at zero [m].
    tool: tuple[float, float]  # E ahead of and above T, arm at zero [m].

    @property
    def l_0(self) -> float:
        """Height of the shoulder above the floor [m]."""
        return self.p_BS[2]

    @property
    def l_1(self) -> float:
        """Distance from the shoulder to the elbow [m]."""
        return math.hypot(*self.elbow)

    @property
    def l_2(self) -> float:
        """Distance from the elbow to T [m]."""
        return math.hypot(*self.wrist)

    @property
    def r_f(self) -> float:
        """Largest distance of T from the shoulder [m]."""
        return self.l_1 + self.l_2

    def p_BT(self, q: Any) -> tuple[Scalar, Scalar, Scalar]:
        """Returns the position of T in B [m] at joint angles `q` (4 or more,) [rad].

        S + R_z(yaw + q_1) R_y(q_2) R_z(q_3) (elbow + R_y(-q_4) wrist), for any scalar.
        """
        x, y, z = self._from_elbow(q, self.wrist[0], 0.0, self.wrist[1])
        x, y = _rotated(x, y, self.yaw + q[0])
        d, e, l_0 = self.p_BS
        return d + x, e + y, l_0 + z

    def p_SE(self, q: Any) -> tuple[Scalar, Scalar, Scalar]:
        """Returns the position of E from S in the first link's axes [m].

        As `p_BT`, but with wrist + R_z(q_5) R_y(-q_6) tool, for any scalar.

        Args:
            q: joint angles (6 or more,) [rad].
        """
        out, above = _rotated(*self.tool, q[5])
        ahead, aside = out * cos(q[4]), out * sin(q[4])
        wrist = self.wrist
        return self._from_elbow(q, wrist[0] + ahead, aside, wrist[1] + above)

    def _from_elbow(
        self, q: Any, x: Scalar, y: Scalar, z: Scalar
    ) -> tuple[Scalar, Scalar, Scalar]:
        """Returns the position from S of a point of the forearm.

        From a position `x`, `y`, `z` from the elbow, in the forearm's axes, to one in
        the first link's axes.
        """
        x, z = _rotated(x, z, q[3])
        x, y = _rotated(self.elbow[0] + x, y, q[2])
        z, x = _rotated(self.elbow[1] + z, x, q[1])
        return x, y, z


def _rotated(a: Scalar, b: Scalar, angle: Scalar) -> tuple[Scalar, Scalar]:
    """Returns the vector (a, b) rotated in its plane by `angle` [rad]."""
    c, s = cos(angle), sin(angle)
    return c * a - s * b, s * a + c * b


def reduced_arm(plant: Any) -> ReducedArm:
    """Returns the reduced arm, measured on a finalized plant of this robot at zero."""
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, np.zeros(plant.num_positions()))
    base = plant.GetFrameByName("base")
    X_BF, X_BS, X_BL, X_BT, X_BE = (
        plant.GetFrameByName(link).CalcPose(context, base)
        for link in ("link0", "link2", "link4", "tee", "tool")
    )
    R_FB = X_BF.rotation().inverse()
    elbow, wrist, tool = (
        tuple((R_FB @ (to.translation() - by.translation()))[[0, 2]].tolist())
        for by, to in ((X_BS, X_BL), (X_BL, X_BT), (X_BT, X_BE))
    )
    p_BS, yaw = X_BS.translation(), RollPitchYaw(X_BF.rotation()).yaw_angle()
    return ReducedArm(tuple(p_BS.tolist()), yaw, elbow, wrist, tool)
