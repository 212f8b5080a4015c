"""The spatial robot of Kwon et al., fig. 2 and section 3."""

import dataclasses as dc
import math
from typing import Any

from drake_mobman.arm.closed_form_inverse import ClosedFormInverse
from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.oriented_inverse import ORIENTATIONS, OrientedInverse
from drake_mobman.arm.pseudo_inverse import Damping
from drake_mobman.arm.spatial import SpatialArm
from drake_mobman.parameters import (
    LENGTH,
    OFFSET,
    one_of,
    within,
)
from drake_mobman.robot_model import Reach, RobotModel, RobotSetup
from drake_mobman.robots.defaults import two_links
from drake_mobman.robots.urdf import filled_urdf

POSTURE = (0.0, math.pi / 4, -math.pi / 2, 0.0, math.pi / 4, 0.0)
"""Joint angles with the hand level and ahead, and the elbow at a right angle [rad]."""


@dc.dataclass
class Spatial:
    """Six joints: three place the wrist, three keep the hand level."""

    upper_link: float = 1.0  # From shoulder to elbow [m].
    lower_link: float = 1.0  # From elbow to the wrist's centre [m].
    hand: float = 0.12  # From the wrist's centre to the tool [m].
    shoulder_ahead: float = 0.15  # Shoulder ahead of the base's centre, d [m].
    shoulder_aside: float = 0.0  # Shoulder left of it, e [m].
    shoulder_height: float = 0.7  # Shoulder above the floor, l_0 [m].
    # How the level hand is turned: along the `reach`, or apart from it and whatever the
    # base does, in W at omega_c (`turning`) or not at all (`held`).
    orientation: str = "reach"

    def check(self) -> None:
        """Raises `ParameterError` where a length or the orientation is not one."""
        one_of(self, "orientation", ORIENTATIONS)
        within(self, LENGTH, "upper_link", "lower_link", "hand", "shoulder_height")
        within(self, OFFSET, "shoulder_ahead", "shoulder_aside")

    def defaults(self) -> list[Any]:
        """Returns what fits the robot where a scenario says nothing."""
        links = self.upper_link, self.lower_link
        return two_links(*links, self.shoulder_ahead, self.shoulder_height)

    def urdf(self) -> str:
        """Returns the robot as URDF."""
        return filled_urdf(
            "spatial",
            upper=self.upper_link,
            lower=self.lower_link,
            hand=self.hand,
            ahead=self.shoulder_ahead,
            aside=self.shoulder_aside,
            height=self.shoulder_height,
        )

    def reach(self, _plant: Any = None) -> Reach:
        """Returns the arm as a base controller sees it."""
        r_f = self.upper_link + self.lower_link
        d, e, l_0 = self._p_BS
        return Reach(l_0, r_f, d, e)

    def arm(self, plant: Any = None) -> SpatialArm | JacobianArm:
        """Returns the arm's kinematics.

        In closed form for a hand along its reach; else by its Jacobian, T in closed
        form all the same.
        """
        arm = SpatialArm(self.upper_link, self.lower_link, self.hand, self._p_BS)
        if self.orientation == "reach":
            return arm
        damping = Damping(length=self.hand)
        return JacobianArm(
            plant or RobotModel(self).plant, POSTURE, damping, p_BT=arm.p_BT
        )

    def arm_inverse(self, setup: RobotSetup) -> Any:
        """Returns the arm's inverse: in closed form, or with the hand turned in W."""
        arm: Any = setup.arm
        limits, period = setup.joint_limits, setup.period
        if self.orientation == "reach":
            return ClosedFormInverse(arm, limits, period, by=setup.inverse)
        return OrientedInverse(arm, limits, period, self.orientation)

    @property
    def _p_BS(self) -> tuple[float, float, float]:
        return self.shoulder_ahead, self.shoulder_aside, self.shoulder_height
