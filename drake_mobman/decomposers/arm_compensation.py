"""What the base's motion already does to the hand, and what is left for the arm.

Exact, where the papers leave the hand's sideways slip: with the shoulder at
p_BS = (d, e) and v_s = v_b - omega_b e,
l_dot = v_c - v_s cos psi - omega_b d sin psi and
psi_dot = omega_c + (v_s sin psi - omega_b (l + d cos psi)) / l.
"""

from typing import Any

from pydrake.math import cos, sin

from drake_mobman.scalars import Scalar, larger

LEAST_REACH = 0.01
"""Stands in for a shorter reach [m], where no rate of psi would do."""


def base_induced_rates(
    workspace: Any, v_b: Scalar, omega_b: Scalar, p_BS: Any
) -> tuple[Scalar, Scalar]:
    """Returns how the base moves a hand that keeps still on it.

    Args:
        workspace: l [m], psi [rad], z [m].
        v_b: forward speed of the base [m/s].
        omega_b: its yaw rate [rad/s].
        p_BS: shoulder in B (3,) [m].

    Returns:
        The hand's velocity in W along the reach [m/s], and the rate at which its
        velocity across the reach turns it about the shoulder [rad/s].
    """
    l, psi = workspace[0], workspace[1]
    d, e, _ = p_BS
    v_s = v_b - omega_b * e  # Of the shoulder, forward.
    across = omega_b * (l + d * cos(psi)) - v_s * sin(psi)
    along = v_s * cos(psi) + omega_b * d * sin(psi)
    return along, across / larger(l, LEAST_REACH)


def arm_compensation(
    command: Any, workspace: Any, sent: Any, p_BS: Any
) -> tuple[Scalar, Scalar, Scalar]:
    """Returns the `arm_command` that leaves the hand just as commanded.

    Args:
        command: `ee_command`.
        workspace: l [m], psi [rad], z [m].
        sent: `base_command_smoothed`, what the base gets.
        p_BS: shoulder in B (3,) [m].
    """
    along, turning = base_induced_rates(workspace, sent[0], sent[1], p_BS)
    return command[0] - along, command[1] - turning, command[2]
