"""The spatial robot of Kwon et al., fig. 2 and section 3."""

import dataclasses as dc
import math
from typing import Any

from drake_mobman.arm.closed_form_inverse import ClosedFormInverse
from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.oriented_inverse import ORIENTATIONS, OrientedInverse
from drake_mobman.arm.pseudo_inverse import Damping
from drake_mobman.arm.spatial import SpatialArm
from drake_mobman.parameters import LENGTH, one_of, within
from drake_mobman.robot_model import RobotModel, RobotSetup
from drake_mobman.robots.two_links import TwoLinks
from drake_mobman.robots.urdf import add_urdf, filled_urdf

POSTURE = (0.0, math.pi / 4, -math.pi / 2, 0.0, math.pi / 4, 0.0)
"""Joint angles with the end effector level, straight ahead, and the elbow at a right
angle [rad]."""


@dc.dataclass
class Spatial(TwoLinks):
    """Six joints: three place the wrist, T; three keep the end effector level."""

    hand: float = 0.12  # From the wrist's centre to the tool [m].
    shoulder_ahead: float = 0.15  # Shoulder ahead of the base's centre, d [m].
    shoulder_height: float = 0.7  # Shoulder above the floor, l_0 [m].
    # Yaw of the level end effector: along the `reach`; or, independent of reach and
    # base, turned in W at omega_c (`turning`) or held in W (`held`).
    orientation: str = "reach"

    def check(self) -> None:
        """Raises `ParameterError` where a length or the orientation is not valid."""
        one_of(self, "orientation", ORIENTATIONS)
        super().check()
        within(self, LENGTH, "hand")

    def add_to(self, plant: Any) -> list[Any]:
        """Adds the robot to a plant; returns its model instances."""
        return add_urdf(plant, self.urdf())

    def urdf(self) -> str:
        """Returns the robot as URDF."""
        return filled_urdf("spatial", hand=self.hand, **self.lengths())

    def arm(self, plant: Any = None) -> SpatialArm | JacobianArm:
        """Returns the arm's kinematics.

        In closed form for an end effector along its reach; else by its Jacobian.
        """
        if self.orientation == "reach":
            links = self.upper_link, self.lower_link
            return SpatialArm(*links, self.hand, self.p_BS)
        plant = plant or RobotModel(self).plant
        return JacobianArm(plant, POSTURE, Damping(length=self.hand))

    def arm_inverse(self, setup: RobotSetup) -> Any:
        """Returns the arm's inverse: in closed form, or with a yaw in W."""
        arm: Any = setup.arm
        limits, period = setup.joint_limits, setup.period
        if self.orientation == "reach":
            return ClosedFormInverse(arm, limits, period, by=setup.inverse)
        return OrientedInverse(arm, limits, period, self.orientation)
