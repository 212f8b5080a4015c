"""The planar arm of Kwon et al., table 1: two links that turn about z."""

import dataclasses as dc
from typing import Any

from pydrake.math import cos, sin

from drake_mobman.arm import two_link
from drake_mobman.scalars import Scalar, larger, smaller


@dc.dataclass(frozen=True)
class PlanarArm:
    """Shoulder and elbow turn about z; T and E are one point, the tip.

    Joints: shoulder, elbow. psi is told from the joints, not from the tip's position,
    so that it holds its value where the arm is folded up and l = 0.
    """

    upper: float  # From shoulder to elbow [m].
    lower: float  # From elbow to tip [m].
    p_BS: tuple[float, float, float]  # Shoulder in B [m].
    num_joints: int = 2
    wrist: tuple[int, ...] = ()  # None: the orientation is given by the place.

    def ee_cylindrical(self, q: Any) -> tuple[Scalar, Scalar, Scalar]:
        """Returns l, psi, z; z is 0 throughout."""
        psi = q[0] + two_link.direction(q[1], self.upper, self.lower)
        return two_link.reach(q[1], self.upper, self.lower), psi, 0.0 * q[0]

    def p_BT(self, q: Any) -> tuple[Scalar, Scalar, Scalar]:
        """Returns the tip's position in B."""
        l, psi, z = self.ee_cylindrical(q)
        d, y, l_0 = self.p_BS
        return d + l * cos(psi), y + l * sin(psi), l_0 + z

    def inverse(self, workspace: Any) -> list[Scalar]:
        """Returns shoulder and elbow; a reach below 0 counts as 0, z not at all."""
        shoulder, elbow = two_link.inverse(
            larger(workspace[0], 0.0), 0.0, self.upper, self.lower
        )
        return [workspace[1] + shoulder, elbow]

    def rates(self, q: Any, workspace_rates: Any) -> list[Scalar]:
        """Returns the rates of shoulder and elbow; the rate of z counts not at all."""
        return self._by(two_link.rates, q, workspace_rates)

    def undamped_rates(self, q: Any, *workspace_rates: Any) -> list[list[Scalar]]:
        """Returns the same for each of several, however fast."""
        return [self._by(two_link.undamped_rates, q, each) for each in workspace_rates]

    def _by(self, law: Any, q: Any, workspace_rates: Any) -> list[Scalar]:
        v_l, v_psi, _ = workspace_rates
        # Seen from axes that lie along the reach. The shoulder turns all, which no
        # singularity disturbs: an arm that is stretched still gives way to its base.
        from_reach = -two_link.direction(q[1], self.upper, self.lower)
        shoulder, elbow = law(from_reach, q[1], v_l, 0.0, self.upper, self.lower)
        return [v_psi + shoulder, elbow]

    def turn_rates(self, q: Any) -> Any:
        """Raises `NotImplementedError`: the hand is not turned by itself."""
        raise NotImplementedError

    def is_near_singular(self, q: Any) -> Scalar:
        """Returns 1 where the arm is nearly stretched or folded, else 0."""
        return two_link.is_near_singular(q[1])

    def is_in_reach(self, workspace: Any) -> Any:
        """Returns whether the tip can be at `workspace`."""
        l = workspace[0]
        return smaller(l, two_link.reach_margin(l, 0.0, self.upper, self.lower)) >= 0
