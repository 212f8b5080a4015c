"""The planar robot of Kwon et al., table 1."""

import dataclasses as dc
from typing import Any

from drake_mobman.arm.closed_form_inverse import ClosedFormInverse
from drake_mobman.arm.planar import PlanarArm
from drake_mobman.parameters import LENGTH, OFFSET, within
from drake_mobman.robot_model import Reach, RobotSetup
from drake_mobman.robots.defaults import two_links
from drake_mobman.robots.urdf import filled_urdf


@dc.dataclass
class Planar:
    """Two links that turn about z, above the base's centre."""

    upper_link: float = 1.0  # From shoulder to elbow [m].
    lower_link: float = 1.0  # From elbow to tip [m].
    shoulder_ahead: float = 0.0  # Shoulder ahead of the base's centre, d [m].
    shoulder_aside: float = 0.0  # Shoulder left of it, e [m].
    shoulder_height: float = 0.5  # Shoulder above the floor, l_0 [m].

    def check(self) -> None:
        """Raises `ParameterError` where a length is not one."""
        within(self, LENGTH, "upper_link", "lower_link", "shoulder_height")
        within(self, OFFSET, "shoulder_ahead", "shoulder_aside")

    def defaults(self) -> list[Any]:
        """Returns what fits the robot where a scenario says nothing."""
        links = self.upper_link, self.lower_link
        return two_links(*links, self.shoulder_ahead, self.shoulder_height)

    def urdf(self) -> str:
        """Returns the robot as URDF."""
        return filled_urdf(
            "planar",
            upper=self.upper_link,
            lower=self.lower_link,
            ahead=self.shoulder_ahead,
            aside=self.shoulder_aside,
            height=self.shoulder_height,
        )

    def reach(self, _plant: Any = None) -> Reach:
        """Returns the arm as a base controller sees it."""
        r_f = self.upper_link + self.lower_link
        d, e, l_0 = self._p_BS
        return Reach(l_0, r_f, d, e)

    def arm(self, _plant: Any = None) -> PlanarArm:
        """Returns the arm's kinematics in closed form."""
        return PlanarArm(self.upper_link, self.lower_link, self._p_BS)

    def arm_inverse(self, setup: RobotSetup) -> Any:
        """Returns the arm's inverse, in closed form."""
        return ClosedFormInverse(
            setup.arm, setup.joint_limits, setup.period, by=setup.inverse
        )

    @property
    def _p_BS(self) -> tuple[float, float, float]:
        return self.shoulder_ahead, self.shoulder_aside, self.shoulder_height
