"""Any arm with six joints or more, by the Jacobian of its model.

The end effector stays level. It turns with the reach, as that of Kwon's spatial arm
does in closed form, or independently of it. A seventh joint keeps the elbow near a
posture meanwhile, in the null space of the Jacobian (Liegeois, 1977).
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from pydrake.autodiffutils import AutoDiffXd
from pydrake.math import RigidTransform, RotationMatrix, atan2, cos, sin, sqrt

from drake_mobman.arm.inverse_kinematics import nearest_joint_angles
from drake_mobman.arm.orientation import orientation_error, rotation_about_z
from drake_mobman.arm.plant_kinematics import PlantKinematics
from drake_mobman.arm.pseudo_inverse import (
    Damping,
    damped_pseudo_inverse,
    pseudo_inverse,
)
from drake_mobman.arm.shoulder import FIRST
from drake_mobman.parameters import checked
from drake_mobman.scalars import (
    Matrix,
    Scalar,
    Vector,
    clamped_norm,
    larger,
    wrapped_angle,
)

_REACHED = 1e-9
"""How far E may miss a point and still counts as there [m] and [rad]."""

_AT_BACK = 1e-9
"""How far past the back a posture still counts as at pi, not at -pi [rad]."""

_STILL = 1e-9
"""How fast a joint of the wrist moves its centre T at most [m/rad]."""


class OrientedParts(NamedTuple):
    """Joint rates of an end effector that turns independently of its reach.

    Only the first part moves E.
    """

    ee: list[Scalar]  # Move E as commanded, turning with its reach (n,) [rad/s].
    turns: Matrix  # Turn it by 1 rad/s about each of B's axes (n, 3) [rad/s].
    level: list[Scalar]  # Turn it level, and to its yaw (n,) [rad/s].
    posture: list[Scalar]  # Bring the joints nearer to the posture (n,) [rad/s].
    damped: Scalar  # 1 where the rates are damped, else 0.


class JacobianArm:
    """An arm with six joints or more, for float and AutoDiffXd: an `ArmKinematics`.

    S is where the model has the first joint, which turns about B's z axis. psi is the
    angle of that joint, plus the bearing that the posture has at its zero, plus how far
    E is beyond the posture's bearing. So psi has no jump where the arm points
    backwards or is mounted backwards, but only where the posture, turned by the first
    joint, points right away from E.

    The end effector is level where its orientation to the reach is that at the posture.
    The posture turns with the reach, so that the arm moves alike in all directions.

    The model has one context, which each call overwrites: one object is not for two
    threads.

    Args:
        plant: finalized `MultibodyPlant` with links `base` (B), `tee` (T) and `tool`
            (E), whose last positions are the arm's joint angles.
        posture: joint angles (n,) to stay near, with E level [rad].
        damping: of the rates; by default, that for a Franka arm.
        p_BT: returns p_BT (3,) [m] for joint angles (n,), where the arm has a closed
            form of it.
        p_SE: returns p_SE (3,) [m] for joint angles (n,), where the arm has a closed
            form of it, in any axes that turn with the first joint about B's z axis.

    Raises:
        ParameterError: where `damping` is not valid.
        ValueError: where the arm has fewer than six joints, or its first joint does not
            turn about B's z axis.
    """

    def __init__(
        self,
        plant: Any,
        posture: Vector,
        damping: Damping | None = None,
        p_BT: Callable[[Any], Any] | None = None,
        p_SE: Callable[[Any], Any] | None = None,
    ) -> None:
        self.damping = checked(damping or Damping())
        self._p_BT, self._p_SE = p_BT, p_SE
        self.posture = np.array(posture, dtype=float)
        self.num_joints = n = len(self.posture)
        if n < 6:
            raise ValueError(f"a level tool takes six joints, and the arm has {n}")
        self._lower = plant.GetPositionLowerLimits()[-n:]
        self._upper = plant.GetPositionUpperLimits()[-n:]
        model = PlantKinematics(plant, n)
        self._models = {float: model}
        model.set(self.posture)
        if not np.allclose(model.J_V_BE()[:3, 0], [0, 0, 1]):
            raise ValueError("the arm's first joint does not turn about B's z axis")
        self.p_BS = tuple(model.p_BS().tolist())
        self.turn = FIRST
        moved = np.abs(model.J_v_BT()).max(axis=0) > _STILL
        self.wrist = tuple(np.flatnonzero(~moved).tolist())
        X_BE = model.X_BE()
        x, y, _ = X_BE.translation() - self.p_BS
        # Of the posture, at the first joint's zero.
        self._bearing = wrapped_angle(atan2(y, x) - self.posture[0])
        if self._bearing < _AT_BACK - math.pi:
            self._bearing += 2 * math.pi
        self._p_SE_bearing = 0.0
        if p_SE:
            x, y, _ = p_SE(self.posture)
            self._p_SE_bearing = atan2(y, x)
        turned_back = rotation_about_z(-self.posture[0] - self._bearing)
        self._R_level = turned_back @ X_BE.rotation().matrix()

    def ee_cylindrical(self, q: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns l [m], psi [rad], z [m] of E for joint angles `q` (n,) [rad]."""
        if self._p_SE:
            x, y, z = self._p_SE(q)
            l, beyond = _polar(x, y, self._p_SE_bearing)
        else:
            l, beyond, z = self._beyond_posture(self._model(q).X_BE(), q)
        return l, q[0] + self._bearing + beyond, z

    def yaw(self, q: Vector) -> Scalar:
        """Returns the yaw of E in B [rad], which is psi where E is turned to its reach.

        Where E is not level, it is that of the level orientation nearest to it.
        """
        M = self._model(q).X_BE().rotation().matrix() @ self._R_level.T
        return atan2(M[1, 0] - M[0, 1], M[0, 0] + M[1, 1])

    def p_BT(self, q: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns the position of the wrist's centre T in B [m]."""
        if self._p_BT:
            return self._p_BT(q)
        x, y, z = self._model(q).p_BT().tolist()
        return x, y, z

    def rates(self, q: Vector, ee_rates: Vector) -> list[Scalar]:
        """Returns the joint rates (n,) that move E and keep the posture [rad/s]."""
        ee, posture, _ = self.ee_and_posture_rates(q, ee_rates)
        return [a + b for a, b in zip(ee, posture, strict=True)]

    def undamped_rates(self, q: Vector, *ee_rates: Vector) -> list[list[Scalar]]:
        """Returns the joint rates (n,) [rad/s] for each of several `ee_rates`.

        E turns with its reach; the posture is not kept, and nothing is damped.
        """
        model = self._model(q)
        psi = q[0] + self._bearing + self._beyond_posture(model.X_BE(), q)[1]
        J_plus = pseudo_inverse(model.J_V_BE(), self.damping)
        return [_joint_rates(psi, J_plus, each) for each in ee_rates]

    def turn_rates(self, q: Vector) -> Matrix:
        """Returns the joint rates (n, 3) that turn E in its place, damped."""
        J = self._model(q).J_V_BE()
        return damped_pseudo_inverse(J, self.damping)[0][:, :3]

    def ee_and_posture_rates(
        self, q: Vector, ee_rates: Vector
    ) -> tuple[list[Scalar], list[Scalar], Scalar]:
        """Returns the joint rates in two parts, and 1 where they are damped, else 0.

        The first part (n,) moves E as commanded and levels it; the second (n,) brings
        the joints nearer to the posture and leaves E where it is. Both in [rad/s].

        Args:
            q: joint angles (n,) [rad].
            ee_rates: v_m [m/s], omega_m [rad/s], v_z [m/s].
        """
        parts = self._rate_parts(q)
        w = self._levelling(parts, parts.psi)
        ee = _joint_rates(parts.psi, parts.J_plus, ee_rates, w)
        return ee, parts.posture.tolist(), parts.damped

    def oriented_parts(self, q: Vector, ee_rates: Vector, yaw: Scalar) -> OrientedParts:
        """Returns joint rates of an end effector that turns apart from its reach.

        Args:
            q: joint angles (n,) [rad].
            ee_rates: v_m [m/s], omega_m [rad/s], v_z [m/s].
            yaw: desired yaw of E in B [rad].
        """
        parts = self._rate_parts(q)
        turns = parts.J_plus[:, :3]
        return OrientedParts(
            ee=_joint_rates(parts.psi, parts.J_plus, ee_rates),
            turns=turns,
            level=(turns @ self._levelling(parts, yaw)).tolist(),
            posture=parts.posture.tolist(),
            damped=parts.damped,
        )

    def is_near_singular(self, q: Vector) -> Scalar:
        """Returns 1 where `rates` is damped, else 0."""
        return damped_pseudo_inverse(self._model(q).J_V_BE(), self.damping)[1]

    def inverse(self, ee_cylindrical: Vector) -> list[float]:
        """Returns the joint angles (n,) [rad] with E level at `ee_cylindrical`; floats.

        Out of reach, those that come near in position and, weighted, in rotation.
        """
        return self._nearest(ee_cylindrical)[0].tolist()

    def is_in_reach(self, ee_cylindrical: Vector) -> bool:
        """Returns whether `inverse` brings E to `ee_cylindrical`, and level."""
        q, error = self._nearest(ee_cylindrical)
        missed = np.abs(np.subtract(self.ee_cylindrical(q), ee_cylindrical))
        return bool(max(error, *missed) < _REACHED)

    def _model(self, q: Vector) -> PlantKinematics:
        """Returns the model for the scalars of `q`, with its joint angles set."""
        scalar = AutoDiffXd if isinstance(q[0], AutoDiffXd) else float
        if scalar not in self._models:
            plant = self._models[float].plant.ToScalarType[scalar]()
            self._models[scalar] = PlantKinematics(plant, self.num_joints)
        model = self._models[scalar]
        model.set(q)
        return model

    def _beyond_posture(self, X_BE: Any, q: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns l and z of E, and between them its bearing from the posture's.

        From that of the posture turned by the first joint.
        """
        x, y, z = (X_BE.translation() - self.p_BS).tolist()
        return *_polar(x, y, q[0] + self._bearing), z

    def _rate_parts(self, q: Vector) -> "_RateParts":
        """Returns what the rates at `q` are made of."""
        model = self._model(q)
        X_BE, J = model.X_BE(), model.J_V_BE()
        beyond = self._beyond_posture(X_BE, q)[1]
        J_plus, damped = damped_pseudo_inverse(J, self.damping)
        away = self.posture - q
        away[0] = beyond
        pull = clamped_norm(
            self.damping.posture_gain * away, self.damping.posture_speed
        )
        return _RateParts(
            R_BE=X_BE.rotation().matrix(),
            psi=q[0] + self._bearing + beyond,
            J_plus=J_plus,
            posture=pull - J_plus @ (J @ pull),
            damped=damped,
        )

    def _levelling(self, parts: "_RateParts", yaw: Scalar) -> Matrix:
        """Returns the angular velocity (3,) that turns E level and to `yaw` [rad/s]."""
        R_level = rotation_about_z(yaw) @ self._R_level
        return self.damping.level_gain * orientation_error(parts.R_BE, R_level)

    def _nearest(self, ee_cylindrical: Vector) -> tuple[Matrix, float]:
        """Returns joint angles (n,), and the weighted error of E's pose [m]."""
        l, psi, z = map(float, ee_cylindrical)
        l = larger(l, 0.0)
        R = RotationMatrix(rotation_about_z(psi) @ self._R_level)
        X_BD = RigidTransform(R, np.add(self.p_BS, (l * cos(psi), l * sin(psi), z)))
        q = self.posture.copy()
        q[0] = psi - self._bearing
        return nearest_joint_angles(
            self._models[float],
            X_BD,
            np.clip(q, self._lower, self._upper),
            self._lower,
            self._upper,
            self.damping.length,
        )


class _RateParts(NamedTuple):
    """What the rates of an arm at some joint angles are made of."""

    R_BE: Matrix  # (3, 3).
    psi: Scalar  # [rad].
    J_plus: Matrix  # Damped pseudo-inverse of J_V_BE (n, 6).
    posture: Matrix  # Rates that bring the joints nearer to the posture (n,) [rad/s].
    damped: Scalar  # 1 where J_plus is damped, else 0.


def _joint_rates(
    psi: Scalar, J_plus: Matrix, ee_rates: Vector, w: Vector = (0.0, 0.0, 0.0)
) -> list[Scalar]:
    """Returns the joint rates (n,) [rad/s] that make `ee_rates`.

    The first joint turns the whole arm by omega_m, at a singularity too; the others
    make the rest of V_BE.

    Args:
        psi: of E [rad].
        J_plus: pseudo-inverse of J_V_BE (n, 6).
        ee_rates: v_m [m/s], omega_m [rad/s], v_z [m/s].
        w: angular velocity of E beside omega_m (3,) [rad/s].
    """
    v_m, omega_m, v_z = ee_rates
    along = [v_m * cos(psi), v_m * sin(psi), v_z]
    rates: list[Scalar] = (J_plus @ np.array([*w, *along])).tolist()
    rates[0] += omega_m
    return rates


def _polar(x: Scalar, y: Scalar, zero: Scalar) -> tuple[Scalar, Scalar]:
    """Returns the length of the vector (x, y), and its angle from `zero` [rad]."""
    c, s = cos(zero), sin(zero)
    return sqrt(x * x + y * y), atan2(c * y - s * x, c * x + s * y)
