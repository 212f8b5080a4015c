"""Authority switched at the workspace's limits (Kwon et al., eqs. 12 and 13)."""

import dataclasses as dc

from drake_mobman.blocks import scalar_block
from drake_mobman.decomposers.decomposer import ShareDecomposer
from drake_mobman.decomposers.projection import Projection
from drake_mobman.robot_model import RobotSetup, WorkspaceLimits
from drake_mobman.scalars import Scalar, Vector, where


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
    """The base moves outside the workspace, the arm inside."""

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
    """The base moves outside the workspace, the arm inside (Kwon, eqs. 12, 13).

    .. pydrake_system::

        name: SwitchingDecomposer
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
        params: Switching,
        workspace: WorkspaceLimits | None = None,
        num_joints: int = 2,
    ) -> None:
        self.declare(params, workspace, num_joints)


SwitchingDecomposer_ = SwitchingDecomposer.template
