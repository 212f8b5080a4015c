"""What robots with two links have in common (Kwon et al.)."""

import dataclasses as dc
from typing import Any

from drake_mobman.base.unsmoothed import Unsmoothed
from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.decomposers.blending import Blending
from drake_mobman.decomposers.exact import Exact
from drake_mobman.guidance.guiding_hand import Hand, Waypoint
from drake_mobman.parameters import LENGTH, OFFSET, within
from drake_mobman.robot_model import Reach, WorkspaceLimits
from drake_mobman.robot_model.rolling import RollingBase, no_wheels
from drake_mobman.robots.defaults import Start

_BODY = 0.3
"""Radius of the capsule that T is to stay out of, b_d [m]."""


@dc.dataclass
class TwoLinks:
    """Two links from shoulder to T, and the shoulder's position on the base."""

    upper_link: float = 1.0  # From shoulder to elbow [m].
    lower_link: float = 1.0  # From elbow to T [m].
    shoulder_ahead: float = 0.0  # Shoulder ahead of the base's centre, d [m].
    shoulder_aside: float = 0.0  # Shoulder left of it, e [m].
    shoulder_height: float = 0.5  # Shoulder above the floor, l_0 [m].

    def check(self) -> None:
        """Raises `ParameterError` where a length is not valid."""
        within(self, LENGTH, "upper_link", "lower_link", "shoulder_height")
        within(self, OFFSET, "shoulder_ahead", "shoulder_aside")

    def defaults(self) -> list[Any]:
        """Returns parameters that fit the robot, for what a scenario leaves out.

        Kwon's table 1, scaled: the paper's arm is 2 m long, with limits of its
        workspace at 0.4 and 1.6 m.
        """
        upper, lower = self.upper_link, self.lower_link
        nearest, room = abs(upper - lower), upper + lower - abs(upper - lower)
        l = nearest + 0.5 * room
        l_min, l_max = nearest + 0.2 * room, nearest + 0.8 * room
        sharpness = 42.0 / room
        return [
            Start(l=l),
            WorkspaceLimits(l_min=l_min, l_max=l_max),
            Unsmoothed(),  # As in the paper.
            Exact(alpha=sharpness),
            Blending(alpha=sharpness),
            # The base follows from l_max on.
            VelocityField(Delta_f=upper + lower - l_max, b_d=_BODY),
            Hand(path=[Waypoint(x=self.shoulder_ahead + l, z=self.shoulder_height)]),
        ]

    def lengths(self) -> dict[str, float]:
        """Returns the lengths [m] by their names in a URDF."""
        return {
            "upper": self.upper_link,
            "lower": self.lower_link,
            "ahead": self.shoulder_ahead,
            "aside": self.shoulder_aside,
            "height": self.shoulder_height,
        }

    def add_rolling_to(self, _plant: Any) -> RollingBase:
        """Raises `ParameterError`: its wheels are only drawn."""
        raise no_wheels(self)

    def reach(self, _plant: Any = None) -> Reach:
        """Returns shoulder and reach for a base controller."""
        d, e, l_0 = self.p_BS
        return Reach(l_0, self.upper_link + self.lower_link, d, e)

    @property
    def p_BS(self) -> tuple[float, float, float]:
        """Returns the shoulder's position in B [m]."""
        return self.shoulder_ahead, self.shoulder_aside, self.shoulder_height
