"""The wheels that drive, told from a model's joints."""

import dataclasses as dc
import math
from collections.abc import Collection
from typing import Any

import numpy as np

from drake_mobman.parameters import ParameterError
from drake_mobman.robots.derive.wheels import track, wheel_radius
from drake_mobman.robots.file.contents import DrivenWheels, PlatformLimits
from drake_mobman.robots.file.loose import Loose

_ACROSS = 0.99
"""Least share of an axis that is along y, or that is upright."""

_TURNS = 4 * np.pi
"""Least range of a joint that turns on and on [rad]."""

_LEVEL = 0.01
"""Largest difference of wheels in height [m]."""


def driven_wheels(model: Loose, base: Any, taken: Collection[str]) -> DrivenWheels:
    """Returns the joints of the wheels that drive; none on either side if not found.

    They turn on and on about axes along y, in pairs, one left and one right of the
    middle; what swivels is a caster.

    Args:
        model: as it comes.
        base: frame of the base, x ahead and z up.
        taken: joints that are something else.
    """
    places = {}
    for name, joint in model.parsed.joints.items():
        if name in taken or not _turns_on(joint) or _swivels(model, joint, base):
            continue
        X = joint.frame_on_child().CalcPose(model.context, base)
        if abs((X.rotation() @ joint.revolute_axis())[1]) > _ACROSS:
            places[name] = X.translation()
    left = {name: p for name, p in places.items() if p[1] > 0 and _mirrored(p, places)}
    right = {name: p for name, p in places.items() if p[1] < 0 and _mirrored(p, places)}
    return DrivenWheels([*left], [*right])


def wheel_speeds(
    model: Loose, wheels: DrivenWheels, base: Any
) -> PlatformLimits | None:
    """Returns what a base can do as far as its wheels turn; None where all is usual.

    Args:
        model: as it comes.
        wheels: that drive.
        base: frame of the base.
    """
    joints, usual = model.parsed.joints, PlatformLimits()
    left, right = ([joints[name] for name in x] for x in (wheels.left, wheels.right))
    fastest = min(float(x.velocity_upper_limits()[0]) for x in (*left, *right))
    try:
        radius = wheel_radius(model.plant, model.inspector, model.context, left[0])
    except ParameterError:
        return None  # It has to be given.
    speed = radius.value * fastest
    if not 0 < speed < usual.speed:
        return None
    half = track(model.context, left, right, base).value / 2
    yaw_rate = min(speed / half, usual.yaw_rate)
    return dc.replace(usual, speed=_floor(speed), yaw_rate=_floor(yaw_rate))


def _floor(x: float) -> float:
    """Returns a number of two digits after the point, not larger."""
    return math.floor(100.0 * x + 1e-6) / 100.0


def _turns_on(joint: Any) -> bool:
    """Returns whether a joint is one that turns without an end."""
    if joint.type_name() != "revolute":
        return False
    return bool(joint.position_upper_limits() - joint.position_lower_limits() > _TURNS)


def _swivels(model: Loose, joint: Any, base: Any) -> bool:
    """Returns whether a joint before another turns it about an upright axis."""
    before = (model.parsed.joints[n] for n in model.way(joint.parent_body()))
    turning = [each for each in before if each.type_name() == "revolute"]
    axes = (
        x.frame_on_parent().CalcPose(model.context, base).rotation() @ x.revolute_axis()
        for x in turning
    )
    return any(abs(axis[2]) > _ACROSS for axis in axes)


def _mirrored(place: Any, places: dict[str, Any]) -> bool:
    """Returns whether there is a wheel on the other side too."""
    other = place * [1, -1, 1]
    return any(np.abs(p - other).max() < _LEVEL for p in places.values())
