"""Authority switched at the workspace's limits (Kwon et al., eqs. 12 and 13)."""

import dataclasses as dc

from drake_mobman.blocks import scalar_block
from drake_mobman.decomposers.decomposer import ShareDecomposer
from drake_mobman.decomposers.projection import Projection
from drake_mobman.robot_model import RobotSetup, WorkspaceLimits
from drake_mobman.scalars import Scalar, Vector, where


def switched_share(command: Scalar, x: Scalar, lower: float, upper: float) -> Scalar:
    """Returns the base's share, 0 or 1, of a command along one coordinate.

    The direction of the command selects the limit, so that an arm outside the limits
    can always move back in.

    Args:
        command: commanded rate, `v_c` [m/s] or `omega_c` [rad/s].
        x: the coordinate that it changes, l [m] or psi [rad].
        lower: its lower limit.
        upper: its upper limit.
    """
    # NaN is returned as NaN.
    outward = where(x < upper, 0.0, where(x >= upper, 1.0, x))
    inward = where(x < lower, 1.0, where(x >= lower, 0.0, x))
    return where(command >= 0, outward, inward)


@dc.dataclass
class Switching:
    """The base moves outside the workspace limits, the arm inside."""

    # How the base's speed follows from its contribution.
    projection: Projection = dc.field(default_factory=Projection)

    def shares(
        self, limits: WorkspaceLimits, command: Vector, at: Vector
    ) -> tuple[Scalar, Scalar]:
        """Returns the base's shares of `v_c` and `omega_c` (eqs. 12, 13)."""
        return (
            switched_share(command[0], at[0], limits.l_min, limits.l_max),
            switched_share(command[1], at[1], limits.psi_min, limits.psi_max),
        )

    def build(self, setup: RobotSetup) -> "SwitchingDecomposer":
        """Returns the block for a robot."""
        return SwitchingDecomposer(self, setup.workspace, setup.arm.num_joints)


@scalar_block
class SwitchingDecomposer(ShareDecomposer):
    """Switches authority at the workspace limits (Kwon, eqs. 12, 13)."""


SwitchingDecomposer_ = SwitchingDecomposer.template
