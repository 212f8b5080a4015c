"""The planar arm of Kwon et al., table 1: two links that turn about z."""

import dataclasses as dc
from typing import Any

from pydrake.math import cos, sin

from drake_mobman.arm import two_link
from drake_mobman.arm.two_link_arm import TwoLinkArm
from drake_mobman.scalars import Scalar, Vector, larger, smaller


@dc.dataclass(frozen=True)
class PlanarArm(TwoLinkArm):
    """Shoulder and elbow turn about z; T and E are one point, the tip.

    Joints: shoulder, elbow. psi comes from the joint angles, not from the tip's
    position, so that it keeps its value where the arm is folded up and l = 0.
    """

    upper: float  # From shoulder to elbow [m].
    lower: float  # From elbow to tip [m].
    p_BS: tuple[float, float, float]  # Shoulder in B [m].
    num_joints: int = 2

    def ee_cylindrical(self, q: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns l, psi, z; z is 0 throughout."""
        psi = q[0] + two_link.direction(q[1], self.upper, self.lower)
        return two_link.reach(q[1], self.upper, self.lower), psi, 0.0 * q[0]

    def p_BT(self, q: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns the tip's position in B."""
        l, psi, z = self.ee_cylindrical(q)
        d, y, l_0 = self.p_BS
        return d + l * cos(psi), y + l * sin(psi), l_0 + z

    def inverse(self, ee_cylindrical: Vector) -> list[Scalar]:
        """Returns shoulder and elbow; a reach below 0 counts as 0, z is ignored."""
        shoulder, elbow = two_link.inverse(
            larger(ee_cylindrical[0], 0.0), 0.0, self.upper, self.lower
        )
        return [ee_cylindrical[1] + shoulder, elbow]

    def joint_rates(
        self, q: Vector, ee_rates: Vector, reciprocal: two_link.Reciprocal
    ) -> list[Scalar]:
        """Returns all joint rates, with a given reciprocal of sin(theta_2)."""
        v_l, v_psi, _ = ee_rates
        # In axes along the reach. The shoulder turns the whole arm, at a singularity
        # too: an arm that is stretched still gives way to its base.
        from_reach = -two_link.direction(q[1], self.upper, self.lower)
        shoulder, elbow = two_link.rates(
            from_reach, q[1], v_l, 0.0, self.upper, self.lower, reciprocal
        )
        return [v_psi + shoulder, elbow]

    def is_near_singular(self, q: Vector) -> Scalar:
        """Returns 1 where the arm is nearly stretched or folded, else 0."""
        return two_link.is_near_singular(q[1])

    def is_in_reach(self, ee_cylindrical: Vector) -> Any:
        """Returns whether the tip can be at `ee_cylindrical`; z is ignored."""
        l = ee_cylindrical[0]
        return smaller(l, two_link.reach_margin(l, 0.0, self.upper, self.lower)) >= 0
