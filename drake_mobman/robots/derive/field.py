"""Thresholds and gains of the velocity field, from base and reach."""

import math

import numpy as np

from drake_mobman.base.smoother import Smoother
from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.robot_model import Reach
from drake_mobman.robots.derive.derived import Derived

_WRIST = 0.03
"""Of the wrist, which is to stay out of the base's body [m]."""

_FORWARD, _RETREAT, _PASSIVE = 0.2, 0.13, 0.1
"""Widths of the zones, as shares of r_f; the last is the least."""

_GAIN = 4.0
"""Speed per depth [1/s]: the loop does not overshoot below 5."""

_ASIDE = 0.6
"""Largest bearing of T from the shoulder for which the body's edge counts [rad]."""

_LEAST = 0.02
"""Least radius [m]: T is not to cross the shoulder's axis."""


def field(
    reach: Reach, body_radius: float, nearest: float, height: float, base: Smoother
) -> Derived[VelocityField]:
    """Returns the velocity field that fits a robot.

    Args:
        reach: of its arm.
        body_radius: of its base about B's z axis [m].
        nearest: the least distance of T from the shoulder's axis at which the arm can
            still move well [m].
        height: of T above the shoulder at the posture [m]. Below it, the forward zone
            comes nearer to the shoulder's axis, and the retreat zone does not.
        base: limits of the base's command.
    """
    r_f = reach.r_f
    forward, retreat = _FORWARD * r_f, _RETREAT * r_f
    edge = body_edge(reach, body_radius) + _WRIST
    wanted = max(edge, nearest - retreat, _LEAST)
    ahead = math.sqrt(max((r_f - forward) ** 2 - min(height, 0.0) ** 2, 0.0))
    room = ahead - retreat - _PASSIVE * r_f
    b_d = max(min(wanted, room), _LEAST)
    found = VelocityField(
        K_f=_GAIN,
        K_r=_GAIN,
        K_omega=base.max_yaw_rate,
        Delta_f=round(forward, 4),
        Delta_r=round(retreat, 4),
        b_d=round(b_d, 4),
    )
    how = f"the body's edge {edge - _WRIST:.3f} m from the shoulder, and the wrist"
    if b_d < wanted:
        how = f"as large as the forward zone leaves; wanted {wanted:.3f} m"
    elif wanted > edge:
        how = f"as near as the arm moves well, {nearest:.3f} m"
    return Derived(found, how)


def body_edge(reach: Reach, body_radius: float) -> float:
    """Returns how far the body's edge is from the shoulder's axis, where the arm is.

    The body is a circle about B's z axis. The largest distance ahead and to the sides
    counts [m]; 0 where the shoulder is outside of the circle.

    Args:
        reach: of the arm, with its shoulder.
        body_radius: of the circle [m].
    """
    d, e = reach.ahead, reach.aside
    if math.hypot(d, e) >= body_radius:
        return 0.0
    bearing = np.linspace(-_ASIDE, _ASIDE, 25)
    along = d * np.cos(bearing) + e * np.sin(bearing)
    across = d * d + e * e - along**2
    return float(np.max(np.sqrt(body_radius**2 - across) - along))
