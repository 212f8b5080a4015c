"""What blocks ask of an arm."""

from typing import Any, Protocol

from drake_mobman.scalars import Scalar


class ArmKinematics(Protocol):
    """An arm by its kinematics: all angles in rad, lengths in m.

    In closed form for any scalar; by a model for float and AutoDiffXd.
    """

    @property
    def num_joints(self) -> int:
        """Returns n."""

    @property
    def p_BS(self) -> tuple[float, float, float]:
        """Returns the shoulder's position in B."""

    @property
    def wrist(self) -> tuple[int, ...]:
        """Returns the joints that only the orientation needs, where that can give."""

    def ee_cylindrical(self, q: Any) -> tuple[Scalar, Scalar, Scalar]:
        """Returns l, psi, z of the end effector E for joint angles `q` (n,)."""

    def p_BT(self, q: Any) -> tuple[Scalar, Scalar, Scalar]:
        """Returns the translational end effector's position in B."""

    def inverse(self, workspace: Any) -> list[Scalar]:
        """Returns the joint angles (n,) at `workspace`, or at the nearest in reach."""

    def rates(self, q: Any, workspace_rates: Any) -> list[Scalar]:
        """Returns the joint rates (n,) that make `workspace_rates`, damped."""

    def undamped_rates(self, q: Any, *workspace_rates: Any) -> list[list[Scalar]]:
        """Returns for each of several the joint rates that it takes, however fast.

        Linear in each: what tells how much of a command the joints can make.
        """

    def turn_rates(self, q: Any) -> Any:
        """Returns the joint rates (n, 3) that turn the hand, E in its place.

        By 1 rad/s about each of B's axes. Asked only where there is a `wrist`.
        """

    def is_near_singular(self, q: Any) -> Scalar:
        """Returns 1 where `rates` falls short of what it is asked, else 0."""

    def is_in_reach(self, workspace: Any) -> Any:
        """Returns whether the arm reaches `workspace`, as a truth or a formula."""
