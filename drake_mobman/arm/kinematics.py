"""What blocks need to know of an arm."""

from typing import Any, Protocol

from drake_mobman.arm.shoulder import Carrier
from drake_mobman.scalars import Rows, Scalar, Vector


class ArmKinematics(Protocol):
    """An arm's kinematics: all angles in rad, lengths in m.

    In closed form for any scalar; by a model for float and AutoDiffXd. `ee_cylindrical`
    and its rates are (3,): l, psi, z of the end effector E, and v_m, omega_m, v_z.
    """

    @property
    def num_joints(self) -> int:
        """Returns n."""

    @property
    def p_BS(self) -> tuple[float, float, float]:
        """Returns the shoulder's position in B."""

    @property
    def turn(self) -> Carrier | None:
        """Returns the joint that turns all of the arm about S; None without one."""

    @property
    def wrist(self) -> tuple[int, ...]:
        """Returns the indices of the joints that move E only by turning it.

        Empty for an arm whose orientation follows from its position.
        """

    def ee_cylindrical(self, q: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns l, psi, z of E for joint angles `q` (n,)."""

    def p_BT(self, q: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns the position of the translational end effector T in B."""

    def inverse(self, ee_cylindrical: Vector) -> list[Scalar]:
        """Returns the joint angles (n,) there, or at the nearest point in reach."""

    def rates(self, q: Vector, ee_rates: Vector) -> list[Scalar]:
        """Returns the joint rates (n,) that make `ee_rates`, damped."""

    def undamped_rates(self, q: Vector, *ee_rates: Vector) -> list[list[Scalar]]:
        """Returns the joint rates (n,) for each of several `ee_rates`, however fast.

        They are linear in each: limits use them to find how much of a command the
        joints can make.
        """

    def turn_rates(self, q: Vector) -> Rows:
        """Returns the joint rates (n, 3) that turn E in its place.

        By 1 rad/s about each of B's axes. Used only where there is a `wrist`.
        """

    def is_near_singular(self, q: Vector) -> Scalar:
        """Returns 1 where `rates` falls short of its command, else 0."""

    def is_in_reach(self, ee_cylindrical: Vector) -> Any:
        """Returns whether the arm reaches a point, as a bool or a `Formula`."""
