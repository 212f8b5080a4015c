"""What arms of two links have in common, beside what their wrists do."""

from drake_mobman.arm import two_link
from drake_mobman.arm.shoulder import FIRST
from drake_mobman.scalars import Matrix, Scalar, Vector


class TwoLinkArm:
    """An arm whose joint rates follow from those of its two links, in closed form."""

    turn = FIRST
    wrist: tuple[int, ...] = ()  # The orientation follows from the position.

    def joint_rates(
        self, q: Vector, ee_rates: Vector, reciprocal: two_link.Reciprocal
    ) -> list[Scalar]:
        """Returns all joint rates (n,), with a given reciprocal of sin(theta_2)."""
        raise NotImplementedError

    def rates(self, q: Vector, ee_rates: Vector) -> list[Scalar]:
        """Returns the joint rates that make `ee_rates`, damped."""
        return self.joint_rates(q, ee_rates, two_link.damped_reciprocal)

    def undamped_rates(self, q: Vector, *ee_rates: Vector) -> list[list[Scalar]]:
        """Returns the same for each of several, without damping."""
        undamped = two_link.undamped_reciprocal
        return [self.joint_rates(q, each, undamped) for each in ee_rates]

    def turn_rates(self, q: Vector) -> Matrix:
        """Raises `NotImplementedError`: this arm has no `wrist`."""
        raise NotImplementedError
