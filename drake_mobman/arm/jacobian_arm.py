"""Any arm with three joints or more, by the Jacobian of its model.

With six joints or more, the end effector stays level. It turns with the reach, as that
of Kwon's spatial arm does in closed form, or independently of it. Joints that are left
keep the elbow near a posture meanwhile, in the null space of the Jacobian (Liegeois,
1977).
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from pydrake.autodiffutils import AutoDiffXd
from pydrake.math import RigidTransform, RotationMatrix, atan2, cos, sin, sqrt

from drake_mobman.arm.chain import chain_of
from drake_mobman.arm.inverse_kinematics import nearest_joint_angles
from drake_mobman.arm.orientation import orientation_error, rotation_about_z
from drake_mobman.arm.plant_kinematics import PlantKinematics
from drake_mobman.arm.pseudo_inverse import (
    Damping,
    damped_pseudo_inverse,
    pseudo_inverse,
)
from drake_mobman.arm.shoulder import Carrier, shoulder_of
from drake_mobman.parameters import checked
from drake_mobman.scalars import (
    Matrix,
    Scalar,
    Vector,
    clamped_norm,
    larger,
    smaller,
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


LEVEL = 6
"""Joints that it takes to place the end effector and to keep it level."""

_PLACED = 3
"""Joints that it takes to place it."""


class JacobianArm:
    """An arm with three joints or more, for float and AutoDiffXd: an `ArmKinematics`.

    Its joints turn or slide, in any order and about any axes. S is on its first axis of
    rotation, and stays there where a lift moves the arm as a whole.

    Where that axis is vertical, psi is the angle of its joint, plus the bearing that
    the posture has at its zero, plus how far E is beyond the posture's bearing. So psi
    has no jump where the arm points backwards or is mounted backwards, but only where
    the posture, turned by the joint, points right away from E. Where the axis is
    tilted, psi is counted from the posture's bearing, without any joint.

    The end effector is level where its orientation to the reach is that at the posture.
    The posture turns with the reach, so that the arm moves alike in all directions; and
    it rises with a lift, which follows the end effector up and down to its ends.

    An arm of fewer than six joints places E, and its orientation follows. So does any
    arm that is not to be `level`.

    The model has one context, which each call overwrites: one object is not for two
    threads.

    Args:
        plant: finalized `MultibodyPlant` with links `base` (B), `tee` (T) and `tool`
            (E), whose last positions are those of the arm's joints.
        posture: joint positions (n,) to stay near, with E level [rad], [m].
        damping: of the rates; by default, that for a Franka arm.
        level: whether E stays level; by default, where the arm has joints enough.
        p_BT: returns p_BT (3,) [m] for joint angles (n,), where the arm has a closed
            form of it.
        p_SE: returns p_SE (3,) [m] for joint angles (n,), where the arm has a closed
            form of it, in any axes that turn with the first joint about B's z axis.

    Raises:
        ParameterError: where `damping` is not valid.
        ValueError: where the arm has too few joints.
    """

    def __init__(
        self,
        plant: Any,
        posture: Vector,
        damping: Damping | None = None,
        *,
        level: bool | None = None,
        p_BT: Callable[[Any], Any] | None = None,
        p_SE: Callable[[Any], Any] | None = None,
    ) -> None:
        self.damping = checked(damping or Damping())
        self._p_BT, self._p_SE = p_BT, p_SE
        self.posture = np.array(posture, dtype=float)
        self.num_joints = n = len(self.posture)
        self.level = n >= LEVEL if level is None else level
        if n < (LEVEL if self.level else _PLACED):
            what = "level" if self.level else "placed"
            raise ValueError(f"the arm's {n} joints are too few for a {what} tool")
        self._rows = slice(0, 6) if self.level else slice(3, 6)
        self._lower = plant.GetPositionLowerLimits()[-n:]
        self._upper = plant.GetPositionUpperLimits()[-n:]
        model = PlantKinematics(plant, n)
        self._models = {float: model}
        model.set(self.posture)
        found = shoulder_of(chain_of(plant), self.posture)
        self.p_BS = tuple(found.p_BS.tolist())
        self.turn, self.lift = found.turn, found.lift
        # Where the others are enough, they move E, and the lift follows.
        enough = n > (LEVEL if self.level else _PLACED)
        self._moving = np.ones(n)
        if self.lift and enough:
            self._moving[self.lift.joint] = 0.0
        moved = np.abs(model.J_v_BT()).max(axis=0) > _STILL
        self.wrist = tuple(np.flatnonzero(~moved).tolist()) if self.level else ()
        X_BE = model.X_BE()
        x, y, self._z = (X_BE.translation() - self.p_BS).tolist()
        # Of the posture, at the turning joint's zero.
        self._bearing = wrapped_angle(atan2(y, x) - self._turned(self.posture))
        if self._bearing < _AT_BACK - math.pi:
            self._bearing += 2 * math.pi
        self._p_SE_bearing = 0.0
        if p_SE:
            x, y, _ = p_SE(self.posture)
            self._p_SE_bearing = atan2(y, x)
        turned_back = rotation_about_z(-self._turned(self.posture) - self._bearing)
        self._R_level = turned_back @ X_BE.rotation().matrix()

    def ee_cylindrical(self, q: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns l [m], psi [rad], z [m] of E for joint angles `q` (n,) [rad]."""
        if self._p_SE:
            x, y, z = self._p_SE(q)
            l, beyond = _polar(x, y, self._p_SE_bearing)
        else:
            l, beyond, z = self._beyond_posture(self._model(q).X_BE(), q)
        return l, self._turned(q) + self._bearing + beyond, z

    def yaw(self, q: Vector) -> Scalar:
        """Returns the yaw of E in B [rad], which is psi where E is turned to its reach.

        Where E is not level, it is that of the level orientation nearest to it.
        """
        M = self._model(q).X_BE().rotation().matrix() @ self._R_level.T
        return atan2(M[1, 0] - M[0, 1], M[0, 0] + M[1, 1])

    def p_BT(self, q: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns the position of T in B [m]."""
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
        l, beyond, _ = self._beyond_posture(model.X_BE(), q)
        psi = self._turned(q) + self._bearing + beyond
        J = model.J_V_BE()[self._rows]
        J_plus = pseudo_inverse(J * self._moving, self.damping)
        at = _Jacobian(l, psi, J, J_plus, self.turn)
        return [_joint_rates(at, each).tolist() for each in ee_rates]

    def turn_rates(self, q: Vector) -> Matrix:
        """Returns the joint rates (n, 3) that turn E in its place, damped."""
        return self._rate_parts(q).turns

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
        level = parts.turns @ self._levelling(parts, parts.at.psi)
        ee = _joint_rates(parts.at, ee_rates) + level
        return ee.tolist(), parts.posture.tolist(), parts.damped

    def oriented_parts(self, q: Vector, ee_rates: Vector, yaw: Scalar) -> OrientedParts:
        """Returns joint rates of an end effector that turns apart from its reach.

        Args:
            q: joint angles (n,) [rad].
            ee_rates: v_m [m/s], omega_m [rad/s], v_z [m/s].
            yaw: desired yaw of E in B [rad].
        """
        parts = self._rate_parts(q)
        return OrientedParts(
            ee=_joint_rates(parts.at, ee_rates).tolist(),
            turns=parts.turns,
            level=(parts.turns @ self._levelling(parts, yaw)).tolist(),
            posture=parts.posture.tolist(),
            damped=parts.damped,
        )

    def is_near_singular(self, q: Vector) -> Scalar:
        """Returns 1 where `rates` is damped, else 0."""
        J = self._model(q).J_V_BE()[self._rows] * self._moving
        return damped_pseudo_inverse(J, self.damping)[1]

    def inverse(self, ee_cylindrical: Vector) -> list[float]:
        """Returns the joint positions (n,) with E level at `ee_cylindrical`; floats.

        Out of reach, those that come near in position and, weighted, in rotation.
        """
        return self._nearest(ee_cylindrical)[0].tolist()

    def is_in_reach(self, ee_cylindrical: Vector) -> bool:
        """Returns whether `inverse` brings E to `ee_cylindrical`, level if need be."""
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

    def _turned(self, q: Vector) -> Scalar:
        """Returns how far the turning joint has turned the arm to the left [rad]."""
        return self.turn.sign * q[self.turn.joint] if self.turn else 0.0 * q[0]

    def _beyond_posture(self, X_BE: Any, q: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns l and z of E, and between them its bearing from the posture's.

        From that of the posture turned by the turning joint.
        """
        x, y, z = (X_BE.translation() - self.p_BS).tolist()
        return *_polar(x, y, self._turned(q) + self._bearing), z

    def _rate_parts(self, q: Vector) -> "_RateParts":
        """Returns what the rates at `q` are made of."""
        model = self._model(q)
        X_BE, J = model.X_BE(), model.J_V_BE()[self._rows]
        l, beyond, z = self._beyond_posture(X_BE, q)
        J_plus, damped = damped_pseudo_inverse(J * self._moving, self.damping)
        pull = clamped_norm(
            self.damping.posture_gain * self._away(q, beyond, z),
            self.damping.posture_speed,
        )
        psi = self._turned(q) + self._bearing + beyond
        return _RateParts(
            R_BE=X_BE.rotation().matrix(),
            at=_Jacobian(l, psi, J, J_plus, self.turn),
            turns=J_plus[:, :3] if self.level else np.zeros((self.num_joints, 3)),
            posture=pull - J_plus @ (J @ pull),
            damped=damped,
        )

    def _away(self, q: Vector, beyond: Scalar, z: Scalar) -> Matrix:
        """Returns how far the joints are from the posture, turned and lifted to E (n,).

        Args:
            q: joint positions (n,) [rad], [m].
            beyond: bearing of E from the posture's [rad].
            z: height of E above S [m].
        """
        away = self.posture - q
        if self.turn:
            away[self.turn.joint] = self.turn.sign * beyond
        if self.lift:
            i, sign = self.lift
            to = self.posture[i] + sign * (z - self._z)
            away[i] = larger(smaller(to, self._upper[i]), self._lower[i]) - q[i]
        return away

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
        if self.turn:
            q[self.turn.joint] = self.turn.sign * (psi - self._bearing)
        if self.lift:
            q[self.lift.joint] += self.lift.sign * (z - self._z)
        return nearest_joint_angles(
            self._models[float],
            X_BD,
            np.clip(q, self._lower, self._upper),
            self._lower,
            self._upper,
            self.damping.length if self.level else None,
        )


class _Jacobian(NamedTuple):
    """How an arm moves E at some joint positions."""

    l: Scalar  # [m].
    psi: Scalar  # [rad].
    J: Matrix  # Of V_BE (6, n), or of v_BE (3, n) where E is placed only.
    J_plus: Matrix  # Its pseudo-inverse (n, 6) or (n, 3).
    turn: Carrier | None  # The joint that turns the whole arm.


class _RateParts(NamedTuple):
    """What the rates of an arm at some joint positions are made of."""

    R_BE: Matrix  # (3, 3).
    at: _Jacobian
    turns: Matrix  # Joint rates that turn E by 1 rad/s about B's axes (n, 3).
    posture: Matrix  # Rates that bring the joints nearer to the posture (n,) [rad/s].
    damped: Scalar  # 1 where J_plus is damped, else 0.


def _joint_rates(at: _Jacobian, ee_rates: Vector) -> Matrix:
    """Returns the joint rates (n,) [rad/s] that make `ee_rates`, E turned to its reach.

    The turning joint makes omega_m, at a singularity too; the others make the rest.

    Args:
        at: how the arm moves E.
        ee_rates: v_m [m/s], omega_m [rad/s], v_z [m/s].
    """
    v_m, omega_m, v_z = ee_rates
    c, s, across = cos(at.psi), sin(at.psi), at.l * omega_m
    wanted = np.array(
        [0.0 * v_m, 0.0 * v_m, omega_m, v_m * c - across * s, v_m * s + across * c, v_z]
    )[-len(at.J) :]
    if at.turn is None:
        return np.asarray(at.J_plus @ wanted)
    i, sign = at.turn
    rates: Matrix = at.J_plus @ (wanted - at.J[:, i] * (sign * omega_m))
    rates[i] += sign * omega_m
    return rates


def _polar(x: Scalar, y: Scalar, zero: Scalar) -> tuple[Scalar, Scalar]:
    """Returns the length of the vector (x, y), and its angle from `zero` [rad]."""
    c, s = cos(zero), sin(zero)
    return sqrt(x * x + y * y), atan2(c * y - s * x, c * x + s * y)
