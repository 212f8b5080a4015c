"""The spatial arm of Kwon et al., fig. 2 and section 3: six joints."""

import dataclasses as dc
from typing import Any

from pydrake.math import cos, sin

from drake_mobman.arm import two_link
from drake_mobman.arm.two_link_arm import TwoLinkArm
from drake_mobman.scalars import Scalar, Vector


@dc.dataclass(frozen=True)
class SpatialArm(TwoLinkArm):
    """Waist about z, shoulder and elbow in the vertical plane, wrist keeps E level.

    Joints: waist, shoulder, elbow, wrist roll, wrist pitch, wrist yaw. Shoulder, elbow
    and wrist pitch count upwards. T is the wrist's centre; E is `wrist_to_tool` ahead
    of it, level and along the reach.
    """

    upper: float  # From shoulder to elbow [m].
    lower: float  # From elbow to the wrist's centre [m].
    wrist_to_tool: float  # From the wrist's centre to the tool [m].
    p_BS: tuple[float, float, float]  # Shoulder in B [m].
    num_joints: int = 6

    def ee_cylindrical(self, q: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns l, psi, z of the level end effector."""
        l, z = two_link.forward(q[1], q[2], self.upper, self.lower)
        return l + self.wrist_to_tool, q[0], z

    def p_BT(self, q: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns the wrist centre's position in B."""
        l, z = two_link.forward(q[1], q[2], self.upper, self.lower)
        d, y, l_0 = self.p_BS
        return d + l * cos(q[0]), y + l * sin(q[0]), l_0 + z

    def inverse(self, ee_cylindrical: Vector) -> list[Scalar]:
        """Returns all joints: the wrist pitches against shoulder and elbow."""
        l, psi, z = ee_cylindrical
        l_T = l - self.wrist_to_tool
        shoulder, elbow = two_link.inverse(l_T, z, self.upper, self.lower)
        return [psi, shoulder, elbow, 0.0 * psi, -(shoulder + elbow), 0.0 * psi]

    def joint_rates(
        self, q: Vector, ee_rates: Vector, reciprocal: two_link.Reciprocal
    ) -> list[Scalar]:
        """Returns all joint rates, with a given reciprocal of sin(theta_2)."""
        v_l, v_psi, v_z = ee_rates
        shoulder, elbow = two_link.rates(
            q[1], q[2], v_l, v_z, self.upper, self.lower, reciprocal
        )
        return [v_psi, shoulder, elbow, 0.0 * v_psi, -(shoulder + elbow), 0.0 * v_psi]

    def is_near_singular(self, q: Vector) -> Scalar:
        """Returns 1 where the arm is nearly stretched or folded, else 0."""
        return two_link.is_near_singular(q[2])

    def is_in_reach(self, ee_cylindrical: Vector) -> Any:
        """Returns whether E can be at `ee_cylindrical`."""
        l, z = ee_cylindrical[0] - self.wrist_to_tool, ee_cylindrical[2]
        return two_link.reach_margin(l, z, self.upper, self.lower) >= 0
