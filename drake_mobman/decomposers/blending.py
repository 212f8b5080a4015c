"""Authority blended about the workspace's limits (Kwon et al., eqs. 14-16)."""

import dataclasses as dc
from typing import Any

from pydrake.math import tanh

from drake_mobman.blocks import scalar_block
from drake_mobman.decomposers.decomposer import ShareDecomposer
from drake_mobman.decomposers.share import WorkspaceLimits
from drake_mobman.parameters import Range, one_of, within
from drake_mobman.scalars import Scalar, smoothstep, where


def blended_share(
    command: Scalar, x: Scalar, lower: float, upper: float, sharpness: float
) -> Scalar:
    """Returns the base's share, in [0, 1], of a command along one coordinate.

    Eqs. 14 and 15, with the second of each pair bracketed as in Algorithm 1.

    Args:
        command: rate commanded, `v_c` [m/s] or `omega_c` [rad/s].
        x: the coordinate that it changes, l [m] or psi [rad].
        lower: its lower limit.
        upper: its upper limit.
        sharpness: alpha [1/m] or beta [1/rad]; the larger, the narrower the transition.
    """
    outward = 0.5 * tanh(sharpness * (x - upper)) + 0.5
    inward = 0.5 - 0.5 * tanh(sharpness * (x - lower))
    return where(command >= 0, outward, inward)


def strict_share(
    command: Scalar, x: Scalar, lower: float, upper: float, sharpness: float
) -> Scalar:
    """Returns the base's share, in [0, 1], which is 1 from the limit on.

    Ours. The tanh share never quite stops the arm: x creeps past its limit as
    ln(1 + 2 sharpness c t) / (2 sharpness) under a command c. This one does, over a
    width of 3 / sharpness before the limit, where it is as steep as that at most; so
    what is inside the limits stays inside.

    Args:
        command: rate commanded, `v_c` [m/s] or `omega_c` [rad/s].
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


@dc.dataclass
class Blending:
    """Authority passes smoothly between arm and base (Kwon, table 1)."""

    alpha: float = 21.0  # Sharpness of the transition in l [1/m].
    beta: float = 21.0  # Sharpness of the transition in psi [1/rad].
    share: str = "tanh"  # As printed; or "smoothstep", which keeps the workspace.

    def check(self) -> None:
        """Raises `ParameterError` unless both are in range, and the share is one."""
        within(self, SHARPNESS_L, "alpha")
        within(self, SHARPNESS_PSI, "beta")
        one_of(self, "share", tuple(SHARES))


def blending_shares(
    params: Blending, limits: WorkspaceLimits, command: Any, at: Any
) -> tuple[Scalar, Scalar]:
    """Returns the base's shares of `v_c` and `omega_c` (eqs. 14 and 15)."""
    share = SHARES[params.share]
    return (
        share(command[0], at[0], limits.l_min, limits.l_max, params.alpha),
        share(command[1], at[1], limits.psi_min, limits.psi_max, params.beta),
    )


@scalar_block
class BlendingDecomposer(ShareDecomposer):
    """Authority passes smoothly from arm to base (Kwon, eqs. 14-16).

    .. pydrake_system::

        name: BlendingDecomposer
        input_ports:
        - ee_command
        - ee_cylindrical
        - arm_position
        - base_command_smoothed
        output_ports:
        - base_command
        - base_contribution
        - arm_command

    Args:
        params: of the law.
        workspace: that the arm is to keep, Kwon's unless given.
        projection: how the base's speed follows from its contribution.
        num_joints: of the arm.

    Raises:
        ParameterError: where a parameter is not valid.
    """

    shares = staticmethod(blending_shares)


BlendingDecomposer_ = BlendingDecomposer.template
