"""Any arm, by the Jacobian of its model: damped where it is nearly singular.

The hand keeps level and turns with the reach, as Kwon's spatial arm does in closed
form; an arm of seven joints keeps its elbow near a posture meanwhile. Damping after
Nakamura & Hanafusa (1986), null space after Liegeois (1977).
"""

import dataclasses as dc
from typing import Any

import numpy as np
from pydrake.autodiffutils import AutoDiffXd
from pydrake.math import RotationMatrix, atan2, cos, inv, sin, sqrt
from pydrake.multibody.tree import JacobianWrtVariable

from drake_mobman.parameters import checked, not_negative, positive
from drake_mobman.scalars import Scalar, larger

_TINY = 1e-14
"""Squared singular value [m^2] that keeps the inverse of a singular matrix finite."""

_CONVERGED = 1e-9
"""Error of the hand's pose [m] up to which a pose counts as reached."""

_ITERATIONS = 300
"""Of `inverse`; poses in reach take five to ten, those out of reach creep."""


@dc.dataclass
class Damping:
    """How bounded rates stay, and how fast elbow and hand come back to the posture.

    The defaults are for a Franka arm.
    """

    # The wrist's scale: a joint there moves the tool about as far as it turns it.
    length: float = 0.2  # Weighs a radian of the hand's turning against its way [m].
    # The singular value is that of the Jacobian with its angular rows in metres.
    threshold: float = 0.02  # Singular value below which rates are damped [m/rad].
    # Slow beside the hand: the elbow takes a second, and no rate to speak of.
    posture_gain: float = 1.0  # Joint rates per distance from the posture [1/s].
    posture_speed: float = 0.5  # Largest norm of these, before projection [rad/s].
    # What Euler steps at 100 Hz tilt the hand by is taken back as fast as it grows.
    level_gain: float = 1.0  # Turning of a hand that is not level, per tilt [1/s].

    def check(self) -> None:
        """Raises `ParameterError` where a gain is negative or nothing is damped."""
        positive(self, "length", "threshold")
        not_negative(self, "posture_gain", "posture_speed", "level_gain")


def hand_twist(l: Scalar, psi: Scalar, workspace_rates: Any) -> Any:
    """Returns V_BE (6,), rotational [rad/s] then translational [m/s], in B.

    The hand goes along the reach, across it and up, and turns with it.

    Args:
        l: reach of E [m].
        psi: its direction in B [rad].
        workspace_rates: v_m [m/s], omega_m [rad/s], v_z [m/s].
    """
    v_m, omega_m, v_z = workspace_rates
    c, s, across = cos(psi), sin(psi), l * omega_m
    nil = 0.0 * omega_m
    return np.array([nil, nil, omega_m, c * v_m - s * across, s * v_m + c * across, v_z])


def damped_pseudo_inverse(J: Any, length: float, threshold: float) -> tuple[Any, bool]:
    """Returns J^T (J J^T + lambda^2 I)^-1 (n, 6), and whether lambda is above 0.

    What is told from singular is w = trace((J J^T)^-1)^(-1/2): it lies between the
    smallest singular value and that over sqrt(6). lambda grows smoothly from 0 at
    w = threshold to the threshold itself at w = 0, so that no row is ever multiplied
    by more than 1 / (2 lambda).

    Args:
        J: Jacobian of V_BE (6, n), rotational rows first.
        length: what rotational rows are multiplied by, so that all are in metres [m].
        threshold: on w [m/rad].
    """
    weights = np.array([length] * 3 + [1.0] * 3)
    scaled = J * weights[:, None]
    gram = scaled @ scaled.T
    inverse = inv(gram + _TINY * _EYE)
    near = larger(1.0 - 1.0 / (np.trace(inverse) * threshold**2), 0.0)
    if near > 0:
        inverse = inv(gram + (threshold * near) ** 2 * _EYE)
    return scaled.T @ inverse * weights, bool(near > 0)


_EYE = np.eye(6)


class JacobianArm:
    """An arm of six joints or more, for float and AutoDiffXd: an `ArmKinematics`.

    S is where the model has the first joint, which turns about B's z axis. psi is
    told from that joint on, so that it goes on where the arm turns past the back.

    The model is asked in a context that is overwritten with each call: one object is
    not for two threads.
    """

    def __init__(
        self, plant: Any, posture: Any, damping: Damping | None = None
    ) -> None:
        """Takes a finished plant whose last positions are the arm's joints.

        Args:
            plant: `MultibodyPlant` with links `base` (B), `tee` (T) and `tool` (E).
            posture: joint angles (n,) [rad] to stay near; the hand is level there.
            damping: by default, that for a Franka arm.

        Raises:
            ParameterError: where `damping` is not valid.
            ValueError: where the arm has fewer than six joints, or its first does not
                turn about B's z axis.
        """
        self.damping = checked(damping or Damping())
        self.posture = np.array(posture, dtype=float)
        self.joints = n = len(self.posture)
        if n < 6:
            raise ValueError(f"a level hand takes 6 joints or more, not {n}")
        self._lower = plant.GetPositionLowerLimits()[-n:]
        self._upper = plant.GetPositionUpperLimits()[-n:]
        self._models = {float: (plant, plant.CreateDefaultContext())}

        context, B, E = self._at(self.posture)
        if not np.allclose(self._J(context, B, E)[:3, 0], [0, 0, 1]):
            raise ValueError("the arm's first joint does not turn about B's z axis")
        first = next(
            joint
            for joint in map(plant.get_joint, plant.GetJointIndices())
            if joint.num_positions() and joint.position_start() == len(self._base)
        )
        S = first.frame_on_child().CalcPose(context, B)
        self.p_BS = tuple(S.translation().tolist())
        _, self._psi, _, R_BE = self._hand(self.posture, context, B, E)
        self._R_level = _turned(-self._psi) @ R_BE
