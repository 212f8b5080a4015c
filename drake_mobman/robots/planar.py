"""The planar robot of Kwon et al., table 1."""

import dataclasses as dc
from typing import Any

from drake_mobman.arm.closed_form_inverse import ClosedFormInverse
from drake_mobman.arm.planar import PlanarArm
from drake_mobman.robot_model import RobotSetup
from drake_mobman.robots.two_links import TwoLinks
from drake_mobman.robots.urdf import add_urdf, filled_urdf


@dc.dataclass
class Planar(TwoLinks):
    """Two links that turn about z, above the base's centre; T is their tip."""

    def add_to(self, plant: Any) -> list[Any]:
        """Adds the robot to a plant; returns its model instances."""
        return add_urdf(plant, self.urdf())

    def urdf(self) -> str:
        """Returns the robot as URDF."""
        return filled_urdf("planar", **self.lengths())

    def arm(self, _plant: Any = None) -> PlanarArm:
        """Returns the arm's kinematics in closed form."""
        return PlanarArm(self.upper_link, self.lower_link, self.p_BS)

    def arm_inverse(self, setup: RobotSetup) -> Any:
        """Returns the arm's inverse, in closed form."""
        return ClosedFormInverse(
            setup.arm, setup.joint_limits, setup.period, by=setup.inverse
        )
