"""What a robot brings along: parameters that fit it, where a scenario says nothing."""

import dataclasses as dc
from collections.abc import Sequence
from typing import Any, TypeVar

from drake_mobman.base.unsmoothed import Unsmoothed
from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.decomposers.blending import Blending
from drake_mobman.decomposers.exact import Exact
from drake_mobman.guidance.guiding_hand import Hand, Waypoint
from drake_mobman.parameters import (
    ANGLE,
    PLACE,
    REACH,
    ParameterError,
    Range,
    checked,
    within,
)
from drake_mobman.robot_model import RobotDescription, WorkspaceLimits

T = TypeVar("T")


@dc.dataclass
class Start:
    """Where base and hand are at time 0."""

    l: float = 1.0  # Reach of the hand from the shoulder's axis [m].
    psi: float = 0.0  # Angle of the reach in the base's axes [rad].
    z: float = 0.0  # Height of the hand above the shoulder [m].
    x: float = 0.0  # Base in W [m].
    y: float = 0.0  # Base in W [m].
    theta: float = 0.0  # Heading of the base in W [rad].

    def check(self) -> None:
        """Raises `ParameterError` unless it is in the world; the arm knows its own."""
        within(self, Range(-REACH.high, REACH.high, "m"), "l", "z")
        within(self, PLACE, "x", "y")
        within(self, ANGLE, "psi", "theta")


def own(robot: RobotDescription) -> dict[type, Any]:
    """Returns the robot's own parameters by their class.

    None of a robot that is not valid, as when it is refused later.
    """
    try:
        brought = checked(robot).defaults()
    except ParameterError:
        return {}
    return {type(params): params for params in brought}


def default_of(robot: RobotDescription, kind: type[T]) -> T:
    """Returns the robot's own parameters of a kind, or that kind's defaults."""
    return own(robot).get(kind) or kind()


def default_member(brought: dict[type, Any], members: Sequence[type]) -> Any:
    """Returns the first that a robot brings of some kinds; else the defaults of one.

    Args:
        brought: the robot's own parameters, by their class.
        members: of a union, or one class.
    """
    own_kinds = [kind for kind in brought if kind in members]
    return brought[own_kinds[0]] if own_kinds else members[0]()


def two_links(
    upper: float, lower: float, ahead: float, height: float, body: float = 0.3
) -> list[Any]:
    """Returns what fits an arm of two links on a base: Kwon's table 1, to scale.

    His arm is 2 m long and works from 0.4 to 1.6 m.

    Args:
        upper: from shoulder to elbow [m].
        lower: from elbow to wrist or tip [m].
        ahead: of the shoulder from the base's centre [m].
        height: of the shoulder above the floor [m].
        body: what the field keeps the hand off, b_d [m].
    """
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
        # The base comes along from l_max on.
        VelocityField(Delta_f=upper + lower - l_max, b_d=body),
        Hand(path=[Waypoint(x=ahead + l, z=height)]),
    ]
