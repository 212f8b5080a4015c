"""How far a robot may reach, and how fast its base may change, before it tips over.

All of the robot is taken to accelerate as its base does, in any posture of its
workspace, with all that its limits allow at once.
"""

import dataclasses as dc
import itertools
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import (
    BASE_JOINTS,
    BaseLimits,
    RobotSetup,
    WorkspaceLimits,
)
from drake_mobman.robot_model.tipping import SupportPolygon, zero_moment_point

_HALVINGS = 12
"""By which a limit is found, to one part in 4000."""

_HEADINGS = 8
"""In which the base may stand on a slope."""

_STILL = BaseLimits(0.0, 0.0, 0.0, 0.0)

_MOVING = {
    "max_acceleration": "m/s^2",
    "max_yaw_rate": "rad/s",
    "max_yaw_acceleration": "rad/s^2",
}
"""Limits of a base that let it tip over, with their units."""

Place = tuple[float, float, float]
"""Of a centre of mass in B (3,) [m]."""


@dc.dataclass(frozen=True)
class Footing:
    """What a robot stands on."""

    polygon: SupportPolygon
    g_W: list[float]  # Gravity (3,) [m/s^2].
    grip: float  # Largest acceleration that wheels and floor allow the base [m/s^2].
    margin: float  # Least distance of the zero-moment point from the edge [m].

    def gravities(self) -> list[tuple[float, float, float]]:
        """Returns gravity in B's axes (3,) [m/s^2], for any heading."""
        x, y, down = self.g_W
        steep, turns = math.hypot(x, y), np.linspace(0.0, 2 * math.pi, _HEADINGS)
        if not steep:
            return [(0.0, 0.0, down)]
        return [(steep * math.cos(t), steep * math.sin(t), down) for t in turns]


def check_upright(setup: RobotSetup, z: float, footing: Footing) -> None:
    """Raises `ParameterError` on the first limit that lets the robot tip over.

    Args:
        setup: of the robot, with workspace and limits of its base.
        z: height of the end effector above the shoulder [m].
        footing: what it stands on.
    """
    reach, limits = setup.workspace.l_max, setup.base_limits
    robot = setup.arm, setup.model.plant, setup.workspace

    def at_rest(l: float) -> float:
        return inside(centres_of_mass(*robot, l, z), _STILL, footing)

    _check("workspace.l_max", "m", reach, footing.margin, at_rest)
    centres, allowed = centres_of_mass(*robot, reach, z), _STILL
    for key, unit in _MOVING.items():
        also = {"max_speed": limits.max_speed} if key == "max_yaw_rate" else {}
        value, others = getattr(limits, key), dc.replace(allowed, **also)

        def moving(x: float, key: str = key, others: BaseLimits = others) -> float:
            return inside(centres, dc.replace(others, **{key: x}), footing)

        _check(f"smoother.{key}", unit, value, footing.margin, moving)
        allowed = dc.replace(others, **{key: value})


def upright_limits(
    centres: Sequence[Place], limits: BaseLimits, footing: Footing
) -> BaseLimits:
    """Returns limits of a base, narrowed by one factor so that the robot does not tip.

    As given where it tips over at rest already.

    Args:
        centres: of the robot's mass in B, each (3,) [m].
        limits: of the base, finite.
        footing: what it stands on.
    """

    def scaled(share: float) -> BaseLimits:
        narrowed = {key: share * getattr(limits, key) for key in _MOVING}
        return dc.replace(limits, **narrowed)

    def law(share: float) -> float:
        return inside(centres, scaled(share), footing)

    if law(1.0) >= footing.margin or law(0.0) < footing.margin:
        return limits
    return scaled(_largest(1.0, footing.margin, law))


def centres_of_mass(
    arm: ArmKinematics, plant: Any, workspace: WorkspaceLimits, reach: float, z: float
) -> list[Place]:
    """Returns the robot's centres of mass in B [m], at the ends of its workspace.

    Args:
        arm: its kinematics.
        plant: of the robot, its base at the origin.
        workspace: of its end effector.
        reach: the largest of the end effector, instead of the workspace's [m].
        z: height of the end effector above the shoulder [m].
    """
    context, centres = plant.CreateDefaultContext(), []
    low, high = workspace.psi_min, workspace.psi_max
    for l in (workspace.l_min, reach):
        for psi in (low, (low + high) / 2, high):
            q = arm.inverse((l, psi, z))
            plant.SetPositions(context, [*[0.0] * BASE_JOINTS, *q])
            x, y, h = plant.CalcCenterOfMassPositionInWorld(context).tolist()
            centres.append((x, y, h))
    return centres


def inside(centres: Sequence[Place], limits: BaseLimits, footing: Footing) -> float:
    """Returns how far the zero-moment point stays inside its polygon [m].

    The base accelerates and turns, both as fast as it may: a point at (x, y) in it has
    accelerations of up to a + alpha |y| + omega^2 |x| along it, and v omega +
    alpha |x| + omega^2 |y| across. Neither is above what wheels and floor can give.

    Args:
        centres: of the robot's mass in B, each (3,) [m].
        limits: of the base.
        footing: what it stands on.
    """
    omega, grip = limits.max_yaw_rate, footing.grip
    alpha = limits.max_yaw_acceleration
    circling = limits.max_speed * omega if omega else 0.0
    points = []
    for (x, y, h), g_B in itertools.product(centres, footing.gravities()):
        ahead = limits.max_acceleration + _times(alpha, y) + _times(omega**2, x)
        aside = circling + _times(alpha, x) + _times(omega**2, y)
        for s, t in itertools.product((-1, 1), (-1, 1)):
            a_BC = (s * min(ahead, grip), t * min(aside, grip), 0.0)
            points.append(zero_moment_point((x, y, h), a_BC, g_B))
    return float(np.min(footing.polygon.inside(np.array(points))))


def _times(limit: float, distance: float) -> float:
    """Returns a limit, which may be infinite, times a distance from the axis."""
    return limit * abs(distance) if distance else 0.0


def _check(
    key: str, unit: str, value: float, margin: float, law: Callable[[float], float]
) -> None:
    """Raises `ParameterError` where a value is too large, naming the largest."""
    if law(value) >= margin:
        return
    low = _largest(value, margin, law)
    valid = f"must be at most {low:.3g} {unit}, or the robot tips over on its wheels"
    raise ParameterError(key, value, valid)


def _largest(value: float, margin: float, law: Callable[[float], float]) -> float:
    """Returns the largest value that keeps a margin, below one that does not."""
    low, high = 0.0, value if math.isfinite(value) else 100.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if law(middle) >= margin else (low, middle)
    return low
