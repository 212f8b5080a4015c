"""Where the end effector may be, by bisection from the posture outwards.

E is level there if need be, the joints are inside their ranges and far from
singularities, and quick enough for the largest command.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.limits import JointLimits
from drake_mobman.arm.orientation import rotation_about_z
from drake_mobman.robot_model import WorkspaceLimits
from drake_mobman.robots.derive.derived import Derived
from drake_mobman.robots.derive.ranges import Ranges
from drake_mobman.robots.derive.speeds import joint_shares
from drake_mobman.teleop.guard import Guard

_MISSED = 1e-9
"""How far E may miss a place and still counts as there [m], [rad]."""

_MARGIN = 0.02
"""Share of a joint's range that stays free at each end."""

_FAST = 0.9
"""Share of a joint's largest rate that the largest command may take."""

_WIDEST_PSI = 0.5
"""Largest |psi - psi of the posture| [rad]: further aside, the base is to turn."""

_SPARE = 0.2
"""Share of what the arm reaches that is left on both sides, where it slows down."""

_STEPS = 20
"""From the posture to the arm's reach, before bisection."""

_TO = 1e-3
"""What bisection ends at [m], [rad]."""


class Reached(NamedTuple):
    """How far E can go from the posture along each coordinate, the others kept."""

    l: tuple[float, float]  # [m].
    psi: tuple[float, float]  # [rad]; no further than is of use.
    z: tuple[float, float]  # Above the shoulder [m].


def reached(
    arm: JacobianArm, limits: JointLimits, ranges: Ranges, guard: Guard, r_f: float
) -> Derived[Reached]:
    """Returns how far E can go from the posture, level and as fast as commanded.

    Args:
        arm: its kinematics.
        limits: of its joints.
        ranges: of its joints.
        guard: the largest command.
        r_f: largest distance of T from the shoulder [m].
    """
    at = np.array(arm.ee_cylindrical(arm.posture), dtype=float)
    commands = np.diag(guard.largest)

    def is_good(place: np.ndarray) -> bool:
        q = np.array(arm.inverse(place))
        missed = np.abs(np.subtract(arm.ee_cylindrical(q), place)).max()
        if arm.level:
            tilt = arm.pose_and_jacobian(q)[0] - rotation_about_z(place[1])
            missed = max(missed, np.abs(tilt).max())
        if missed > _MISSED or ranges.margin(q) < _MARGIN or arm.is_near_singular(q):
            return False
        return max(joint_shares(arm, limits, q, commands)) < _FAST

    def ends(i: int, most: float) -> tuple[float, float]:
        def good(x: float) -> bool:
            place = at.copy()
            place[i] = x
            return is_good(place)

        x = float(at[i])
        low, high = (_end(good, x, sign * most) for sign in (-1.0, 1.0))
        return (max(low, 0.0), high) if i == 0 else (low, high)

    found = Reached(ends(0, 2 * r_f), ends(1, _WIDEST_PSI), ends(2, 2 * r_f))
    return Derived(found, "bisection from the posture, level, in range and quick")


def _end(good: Callable[[float], bool], start: float, way: float) -> float:
    """Returns the last good value on a way from a start."""
    step = way / _STEPS
    last = start
    for k in range(1, _STEPS + 1):
        if not good(start + k * step):
            break
        last = start + k * step
    else:
        return last
    bad = last + step
    while abs(bad - last) > _TO:
        middle = (last + bad) / 2
        last, bad = (middle, bad) if good(middle) else (last, middle)
    return last


def workspace(arm: JacobianArm, found: Reached) -> Derived[WorkspaceLimits]:
    """Returns the workspace: the middle of what is reached, with the posture inside.

    Args:
        arm: its kinematics.
        found: how far E can go from the posture.
    """
    l, psi, _ = map(float, arm.ee_cylindrical(arm.posture))
    (nearest, farthest), (right, left) = found.l, found.psi
    spare = _SPARE * (farthest - nearest)
    l_min = min(nearest + spare, (nearest + l) / 2)
    l_max = max(farthest - spare, (farthest + l) / 2)
    limits = WorkspaceLimits(
        l_min=round(l_min, 3),
        l_max=round(l_max, 3),
        psi_min=round(min(right, psi - _TO), 3),
        psi_max=round(max(left, psi + _TO), 3),
    )
    how = f"middle of l = {nearest:.3f} to {farthest:.3f} m that the arm reaches"
    return Derived(limits, how)
