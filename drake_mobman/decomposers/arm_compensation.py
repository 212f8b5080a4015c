"""The end effector's motion by the base, and the arm command that makes up for it.

It is exact; the papers leave out that the base also moves the end effector sideways.
With the shoulder at p_BS = (d, e), v_s = v_b - omega_b e and the base's slip v_y,
l_dot = v_c - v_s cos psi - omega_b d sin psi - v_y sin psi and
psi_dot = omega_c + (v_s sin psi - omega_b (l + d cos psi) - v_y cos psi) / l.
"""

from pydrake.math import cos, sin

from drake_mobman.scalars import Scalar, Vector, larger

LEAST_REACH = 0.01
"""Used in place of a shorter reach [m], where no rate of psi is enough."""


def base_induced_rates(
    at: Vector, v_b: Scalar, omega_b: Scalar, p_BS: Vector, v_y: Scalar = 0.0
) -> tuple[Scalar, Scalar]:
    """Returns how the base moves an end effector that is at rest on it.

    Args:
        at: `ee_cylindrical` (3,).
        v_b: forward speed of the base [m/s].
        omega_b: its yaw rate [rad/s].
        p_BS: shoulder in B (3,) [m].
        v_y: speed of the base to its left, which slips [m/s].

    Returns:
        Its velocity in W along the reach [m/s]; and its velocity across the reach, as a
        rate of turning about the shoulder [rad/s].
    """
    l, psi = at[0], at[1]
    d, e, _ = p_BS
    v_s = v_b - omega_b * e  # Of the shoulder, forward.
    c, s = cos(psi), sin(psi)
    across = omega_b * (l + d * c) - v_s * s + v_y * c
    along = v_s * c + omega_b * d * s + v_y * s
    return along, across / larger(l, LEAST_REACH)


def arm_compensation(
    command: Vector, at: Vector, estimate: Vector, p_BS: Vector
) -> tuple[Scalar, Scalar, Scalar]:
    """Returns the `arm_command` that moves the end effector exactly as commanded.

    Args:
        command: `ee_command`.
        at: `ee_cylindrical` (3,).
        estimate: `base_estimate` (3,), how the base moves.
        p_BS: shoulder in B (3,) [m].
    """
    v, v_y, omega = estimate
    along, turning = base_induced_rates(at, v, omega, p_BS, v_y)
    return command[0] - along, command[1] - turning, command[2]
