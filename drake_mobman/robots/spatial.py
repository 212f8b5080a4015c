"""The spatial robot of Kwon et al., fig. 2 and section 3."""

import dataclasses as dc

from drake_mobman.arm.spatial import SpatialArm
from drake_mobman.base.velocity_field import Reach
from drake_mobman.parameters import not_negative, positive
from drake_mobman.robots.model import filled_urdf


@dc.dataclass
class Spatial:
    """Six joints: three place the wrist, three keep the hand level along the reach."""

    upper_link: float = 1.0  # From shoulder to elbow [m].
    lower_link: float = 1.0  # From elbow to the wrist's centre [m].
    hand: float = 0.12  # From the wrist's centre to the tool [m].
    shoulder_ahead: float = 0.15  # Shoulder ahead of the base's centre, d [m].
    shoulder_height: float = 0.7  # Shoulder above the floor, l_0 [m].

    def check(self) -> None:
        """Raises `ParameterError` where a length is not one."""
        positive(self, "upper_link", "lower_link", "hand")
        not_negative(self, "shoulder_height")

    def urdf(self) -> str:
        """Returns the robot as URDF."""
        return filled_urdf(
            "spatial",
            upper=self.upper_link,
            lower=self.lower_link,
            hand=self.hand,
            ahead=self.shoulder_ahead,
            height=self.shoulder_height,
        )

    def reach(self) -> Reach:
        """Returns the arm as a velocity field sees it."""
        r_f = self.upper_link + self.lower_link
        return Reach(self.shoulder_height, r_f, self.shoulder_ahead)

    def arm(self) -> SpatialArm:
        """Returns the arm's kinematics in closed form."""
        p_BS = (self.shoulder_ahead, 0.0, self.shoulder_height)
        return SpatialArm(self.upper_link, self.lower_link, self.hand, p_BS)
