"""What is known of a robot from a file: each value, and where it is from."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.robot_model import RobotModel, WorkspaceLimits
from drake_mobman.robots.defaults import Start, default_of
from drake_mobman.robots.file.contents import RobotFile
from drake_mobman.robots.file.described import Described
from drake_mobman.robots.file.file import File
from drake_mobman.robots.file.placement import GIVEN


class Fact(NamedTuple):
    """A value that is known of a robot."""

    group: str  # The part of the robot that it is of.
    name: str  # Its key in a robot file, as far as it has one.
    value: str  # With its unit.
    source: str  # Given, or what it is derived from.


def facts(robot: File) -> list[Fact]:
    """Returns all that is known of a robot.

    Raises:
        ParameterError: where it cannot be used.
    """
    it, model = robot.described(), RobotModel(robot)
    return [*_base(it), *_arm(robot, it, model), *_limits(it, model), *_use(robot)]


def _base(it: Described) -> Iterator[Fact]:
    placed, limits = it.placement, it.contents.base.limits
    x, y, z = placed.X_FB.value.translation() + 0.0
    at = f"({x:.4g}, {y:.4g}, {z:.4g}) m in {it.layout.base}"
    yield Fact("base", "B", at, placed.X_FB.source)
    if placed.wheel_radius and placed.track:
        for name, found in (
            ("wheel_radius", placed.wheel_radius),
            ("track", placed.track),
        ):
            yield Fact("base", name, f"{found.value:.4g} m", found.source)
    usual = limits == type(limits)()
    source = "usual, as the file gives none" if usual else GIVEN
    linear = f"{limits.speed:g} m/s, {limits.acceleration:g} m/s^2"
    turning = f"{limits.yaw_rate:g} rad/s, {limits.yaw_acceleration:g} rad/s^2"
    yield Fact("base", "limits", f"{linear}; {turning}", source)
