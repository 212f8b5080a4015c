"""The spatial arm of Kwon et al., fig. 2 and section 3: six joints."""

import dataclasses as dc
from typing import Any

from pydrake.math import cos, sin

from drake_mobman.arm import two_link
from drake_mobman.scalars import Scalar


@dc.dataclass(frozen=True)
class SpatialArm:
    """Waist about z, shoulder and elbow in the vertical plane, wrist keeps E level.

    Joints: waist, shoulder, elbow, wrist roll, wrist pitch, wrist yaw. Shoulder, elbow
    and wrist pitch count upwards. T is the wrist's centre; E lies `hand` ahead of it,
    level and along the reach.
    """

    upper: float  # From shoulder to elbow [m].
    lower: float  # From elbow to the wrist's centre [m].
    hand: float  # From the wrist's centre to the tool [m].
    p_BS: tuple[float, float, float]  # Shoulder in B [m].
    num_joints: int = 6
    wrist: tuple[int, ...] = ()  # None: the orientation is given by the place.

    def ee_cylindrical(self, q: Any) -> tuple[Scalar, Scalar, Scalar]:
        """Returns l, psi, z of the level hand."""
        l, z = two_link.forward(q[1], q[2], self.upper, self.lower)
        return l + self.hand, q[0], z

    def p_BT(self, q: Any) -> tuple[Scalar, Scalar, Scalar]:
        """Returns the wrist centre's position in B."""
        l, z = two_link.forward(q[1], q[2], self.upper, self.lower)
        d, y, l_0 = self.p_BS
        return d + l * cos(q[0]), y + l * sin(q[0]), l_0 + z

    def inverse(self, workspace: Any) -> list[Scalar]:
        """Returns all joints: the wrist pitches against shoulder and elbow."""
        l, psi, z = workspace
        shoulder, elbow = two_link.inverse(l - self.hand, z, self.upper, self.lower)
        return [psi, shoulder, elbow, 0.0 * psi, -(shoulder + elbow), 0.0 * psi]

    def rates(self, q: Any, workspace_rates: Any) -> list[Scalar]:
        """Returns the rates of all joints; the wrist pitches against the arm."""
        return self._by(two_link.rates, q, workspace_rates)

    def undamped_rates(self, q: Any, *workspace_rates: Any) -> list[list[Scalar]]:
        """Returns the same for each of several, however fast."""
        return [self._by(two_link.undamped_rates, q, each) for each in workspace_rates]

    def _by(self, law: Any, q: Any, workspace_rates: Any) -> list[Scalar]:
        v_l, v_psi, v_z = workspace_rates
        shoulder, elbow = law(q[1], q[2], v_l, v_z, self.upper, self.lower)
        return [v_psi, shoulder, elbow, 0.0 * v_psi, -(shoulder + elbow), 0.0 * v_psi]

    def turn_rates(self, q: Any) -> Any:
        """Raises `NotImplementedError`: the hand is not turned by itself."""
        raise NotImplementedError

    def is_near_singular(self, q: Any) -> Scalar:
        """Returns 1 where the arm is nearly stretched or folded, else 0."""
        return two_link.is_near_singular(q[2])

    def is_in_reach(self, workspace: Any) -> Any:
        """Returns whether the hand can be at `workspace`."""
        l, z = workspace[0] - self.hand, workspace[2]
        return two_link.reach_margin(l, z, self.upper, self.lower) >= 0
