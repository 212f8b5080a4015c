"""Authority blended near the workspace's limits (Kwon et al., eqs. 14-16)."""

import dataclasses as dc

from drake_mobman.blocks import scalar_block
from drake_mobman.decomposers.decomposer import ShareDecomposer
from drake_mobman.decomposers.projection import Projection
from drake_mobman.decomposers.share import (
    SHARES,
    SHARPNESS_L,
    SHARPNESS_PSI,
    authority_shares,
)
from drake_mobman.parameters import one_of, within
from drake_mobman.robot_model import RobotSetup, WorkspaceLimits
from drake_mobman.scalars import Scalar, Vector


@dc.dataclass
class Blending:
    """Authority passes smoothly between arm and base (Kwon, table 1)."""

    alpha: float = 21.0  # Sharpness of the transition in l [1/m].
    beta: float = 21.0  # Sharpness of the transition in psi [1/rad].
    share: str = "tanh"  # As printed; or "smoothstep", which keeps to the limits.
    # How the base's speed follows from its contribution.
    projection: Projection = dc.field(default_factory=Projection)

    def check(self) -> None:
        """Raises `ParameterError` unless both are in range and the share law exists."""
        within(self, SHARPNESS_L, "alpha")
        within(self, SHARPNESS_PSI, "beta")
        one_of(self, "share", tuple(SHARES))

    def shares(
        self, limits: WorkspaceLimits, command: Vector, at: Vector
    ) -> tuple[Scalar, Scalar]:
        """Returns the base's shares of `v_c` and `omega_c` (eqs. 14, 15)."""
        return authority_shares(self, limits, command, at)

    def build(self, setup: RobotSetup) -> "BlendingDecomposer":
        """Returns the block for a robot."""
        return BlendingDecomposer(self, setup.workspace, setup.arm.num_joints)


@scalar_block
class BlendingDecomposer(ShareDecomposer):
    """Authority passes smoothly between arm and base (Kwon, eqs. 14-16)."""


BlendingDecomposer_ = BlendingDecomposer.template
