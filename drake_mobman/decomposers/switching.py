"""Authority switched at the workspace's limits (Kwon et al., eqs. 12 and 13)."""

import dataclasses as dc
from typing import Any

from drake_mobman.decomposers.decomposer import share_decomposer
from drake_mobman.decomposers.share import Workspace
from drake_mobman.scalars import Scalar, where


def switched_share(command: Scalar, x: Scalar, lower: float, upper: float) -> Scalar:
    """Returns the base's share, 0 or 1, of a command along one coordinate.

    Which limit counts goes by the direction of the command, so that an arm that
    stands outside its workspace can always turn back in.

    Args:
        command: rate commanded, `v_c` [m/s] or `omega_c` [rad/s].
        x: the coordinate that it changes, l [m] or psi [rad].
        lower: its lower limit.
        upper: its upper limit.
    """
    # An angle that is not a number must not pass for one on either side.
    outward = where(x < upper, 0.0, where(x >= upper, 1.0, x))
    inward = where(x < lower, 1.0, where(x >= lower, 0.0, x))
    return where(command >= 0, outward, inward)


@dc.dataclass
class Switching:
    """The base moves outside the workspace, the arm inside. No parameters."""


def switching_shares(
    _params: Switching, limits: Workspace, command: Any, workspace: Any
) -> tuple[Scalar, Scalar]:
    """Returns the base's shares of `v_c` and `omega_c` (eqs. 12 and 13)."""
    return (
        switched_share(command[0], workspace[0], limits.l_min, limits.l_max),
        switched_share(command[1], workspace[1], limits.psi_min, limits.psi_max),
    )


SwitchingDecomposer_ = share_decomposer("SwitchingDecomposer_", switching_shares)
SwitchingDecomposer = SwitchingDecomposer_[None]
