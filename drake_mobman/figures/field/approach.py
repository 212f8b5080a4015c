"""How the base moves about a hand at rest."""

import math

from drake_mobman.base import Smoothing
from drake_mobman.base.unicycle import unicycle_rates
from drake_mobman.base.velocity_field import VelocityField, field_velocity
from drake_mobman.robot_model import Reach
from drake_mobman.scalars import Vector

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
    state: Vector = [0.0] * smoother.states
    nearest = farthest = start
    for _ in range(round(DURATION / _PERIOD)):
        dx, dy, c, s = hand[0] - x, hand[1] - y, math.cos(theta), math.sin(theta)
        p_BT = c * dx + s * dy, c * dy - s * dx, reach.l_0
        distance = math.hypot(p_BT[0] - reach.ahead, p_BT[1] - reach.aside)
        nearest, farthest = min(nearest, distance), max(farthest, distance)
        raw = field_velocity(p_BT, params, reach)
        state = smoother.next(state, raw, _PERIOD)
        command = state[:2]
        if max(map(abs, (*raw, *command))) < AT_REST:
            break
        rates = unicycle_rates(theta, *command)
        x, y, theta = (
            at + _PERIOD * rate for at, rate in zip((x, y, theta), rates, strict=True)
        )
    return nearest, farthest, distance
