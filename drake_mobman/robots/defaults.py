"""What a robot brings along: parameters that fit it, where a scenario says nothing."""

import dataclasses as dc
from collections.abc import Sequence
from typing import Any, TypeVar

from drake_mobman.parameters import (
    ANGLE,
    PLACE,
    REACH,
    ParameterError,
    Range,
    checked,
    within,
)
from drake_mobman.robot_model import RobotDescription

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
