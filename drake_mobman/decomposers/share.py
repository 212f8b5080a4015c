"""The base's share of a command, by where the arm is within its workspace limits."""

from typing import Protocol

from pydrake.math import tanh

from drake_mobman.parameters import Range
from drake_mobman.robot_model import WorkspaceLimits
from drake_mobman.scalars import Scalar, Vector, smoothstep, where


def blended_share(
    command: Scalar, x: Scalar, lower: float, upper: float, sharpness: float
) -> Scalar:
    """Returns the base's share, in [0, 1], of a command along one coordinate.

    Kwon et al., eqs. 14 and 15; the second of each pair with Algorithm 1's brackets.

    Args:
        command: commanded rate, `v_c` [m/s] or `omega_c` [rad/s].
        x: the coordinate that it changes, l [m] or psi [rad].
        lower: its lower limit.
        upper: its upper limit.
        sharpness: alpha [1/m] or beta [1/rad]; larger for a narrower transition.
    """
    outward = 0.5 * tanh(sharpness * (x - upper)) + 0.5
    inward = 0.5 - 0.5 * tanh(sharpness * (x - lower))
    return where(command >= 0, outward, inward)


def strict_share(
    command: Scalar, x: Scalar, lower: float, upper: float, sharpness: float
) -> Scalar:
    """Returns the base's share, in [0, 1], which is 1 from the limit on.

    Our own law. The tanh share never quite stops the arm: x creeps past its limit as
    ln(1 + 2 sharpness c t) / (2 sharpness) under a command c. This share stops it, over
    a width of 3 / sharpness before the limit, and is nowhere steeper than tanh. So the
    end effector stays inside the limits.

    Args:
        command: commanded rate, `v_c` [m/s] or `omega_c` [rad/s].
        x: the coordinate that it changes, l [m] or psi [rad].
        lower: its lower limit.
        upper: its upper limit.
        sharpness: alpha [1/m] or beta [1/rad].
    """
    width = 3.0 / sharpness
    outward = smoothstep(x, upper - width, upper)
    inward = smoothstep(-x, -(lower + width), -lower)
    return where(command >= 0, outward, inward)


SHARES = {"tanh": blended_share, "smoothstep": strict_share}
"""The share laws, by name."""

SHARPNESS_L = Range(0.1, 1e4, "1/m")
SHARPNESS_PSI = Range(0.1, 1e4, "1/rad")


class ShareLawParams(Protocol):
    """Parameters of a share law, for l and for psi."""

    share: str  # One of `SHARES`.
    alpha: float  # Sharpness of the transition in l [1/m].
    beta: float  # Sharpness of the transition in psi [1/rad].


def authority_shares(
    params: ShareLawParams, limits: WorkspaceLimits, command: Vector, at: Vector
) -> tuple[Scalar, Scalar]:
    """Returns the base's shares, in [0, 1], of `v_c` and of `omega_c` (eqs. 14, 15).

    Args:
        params: of the law.
        limits: of the workspace.
        command: `ee_command` (3,).
        at: `ee_cylindrical` (3,).
    """
    share = SHARES[params.share]
    return (
        share(command[0], at[0], limits.l_min, limits.l_max, params.alpha),
        share(command[1], at[1], limits.psi_min, limits.psi_max, params.beta),
    )
