"""How the base moves about a hand at rest."""

import math
from collections.abc import Sequence

from drake_mobman.base import Smoothing
from drake_mobman.base.smoother import Smoother, smoothed
from drake_mobman.base.unicycle import unicycle_rates
from drake_mobman.base.velocity_field import VelocityField, field_velocity
from drake_mobman.robot_model import Reach

DURATION = 15.0
"""How long the base moves [s]."""

AT_REST = 1e-4
"""Speed [m/s] or [rad/s] below which the base is at rest."""

_PERIOD = 0.01  # Of the control loop [s].


def distances(
    start: float, phi: float, params: VelocityField, reach: Reach, smoother: Smoothing
) -> tuple[float, float, float]:
    """Returns the smallest, largest and last distance [m] to a hand at rest.

    Horizontal, from the shoulder to T at its height. The base is a unicycle integrated
    by Euler steps, as the kinematic robot is.

    Args:
        start: distance at the start [m].
        phi: bearing of T at the start [rad].
        params: of the field.
        reach: of the arm.
        smoother: of the base commands.
    """
    hand = reach.ahead + start * math.cos(phi), reach.aside + start * math.sin(phi)
    x = y = theta = 0.0
    command: Sequence[float] = (0.0, 0.0)
    nearest = farthest = start
    for _ in range(round(DURATION / _PERIOD)):
        dx, dy, c, s = hand[0] - x, hand[1] - y, math.cos(theta), math.sin(theta)
        p_BT = c * dx + s * dy, c * dy - s * dx, reach.l_0
        distance = math.hypot(p_BT[0] - reach.ahead, p_BT[1] - reach.aside)
        nearest, farthest = min(nearest, distance), max(farthest, distance)
        raw = field_velocity(p_BT, params, reach)
        command = _smoothed(command, raw, smoother)
        if max(map(abs, (*raw, *command))) < AT_REST:
            break
        rates = unicycle_rates(theta, *command)
        x, y, theta = (
            at + _PERIOD * rate for at, rate in zip((x, y, theta), rates, strict=True)
        )
    return nearest, farthest, distance


def _smoothed(
    last: Sequence[float], raw: Sequence[float], smoother: Smoothing
) -> Sequence[float]:
    """Returns the next base command (2,) after the last one."""
    if not isinstance(smoother, Smoother):
        return raw
    limits = smoother.max_speed, smoother.max_yaw_rate
    accelerations = smoother.max_acceleration, smoother.max_yaw_acceleration
    return [
        smoothed(u, to, smoother.smoothing, _PERIOD * acceleration, limit)
        for u, to, acceleration, limit in zip(
            last, raw, accelerations, limits, strict=True
        )
    ]
