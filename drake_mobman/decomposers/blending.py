"""Authority blended about the workspace's limits (Kwon et al., eqs. 14-16)."""

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
    share: str = "tanh"  # As printed; or "smoothstep", which keeps the workspace.
    # How the base's speed follows from its contribution.
    projection: Projection = dc.field(default_factory=Projection)

    def check(self) -> None:
        """Raises `ParameterError` unless both are in range, and the share is one."""
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
    """Authority passes smoothly between arm and base (Kwon, eqs. 14-16).

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
        workspace: that the arm is to keep; Kwon's unless given.
        num_joints: of the arm.

    Raises:
        ParameterError: where a parameter is not valid.
    """

    def __init__(
        self,
        params: Blending,
        workspace: WorkspaceLimits | None = None,
        num_joints: int = 2,
    ) -> None:
        self.declare(params, workspace, num_joints)


BlendingDecomposer_ = BlendingDecomposer.template
