"""A robot's defaults: parameters that fit it, for what a scenario leaves out."""

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
    """Where base and end effector are at time 0."""

    l: float = 1.0  # Reach of the end effector from the shoulder's axis [m].
    psi: float = 0.0  # Angle of the reach in the base's axes [rad].
    z: float = 0.0  # Height of the end effector above the shoulder [m].
    x: float = 0.0  # Base in W [m].
    y: float = 0.0  # Base in W [m].
    theta: float = 0.0  # Heading of the base in W [rad].

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range; the arm checks its reach."""
        within(self, Range(-REACH.high, REACH.high, "m"), "l", "z")
        within(self, PLACE, "x", "y")
        within(self, ANGLE, "psi", "theta")


def robot_defaults(robot: RobotDescription) -> dict[type, Any]:
    """Returns the robot's default parameters by their class.

    Empty for a robot that is not valid: a later check refuses it.
    """
    try:
        defaults = checked(robot).defaults()
    except ParameterError:
        return {}
    return {type(params): params for params in defaults}


def default_of(robot: RobotDescription, kind: type[T]) -> T:
    """Returns the robot's default parameters of a class, or the class's own."""
    return robot_defaults(robot).get(kind) or kind()


def default_member(defaults: dict[type, Any], members: Sequence[type]) -> Any:
    """Returns the robot's default for a union, or else that of its first member.

    Args:
        defaults: as `robot_defaults` returns them.
        members: of the union, or one class.
    """
    kinds = [kind for kind in defaults if kind in members]
    return defaults[kinds[0]] if kinds else members[0]()
