"""Any arm, by the Jacobian of its model, damped where that is nearly singular.

The hand keeps level and turns with the reach, as that of Kwon's spatial arm does in
closed form, or apart from it; a seventh joint keeps the elbow near a posture meanwhile.
Damping after Nakamura & Hanafusa (1986), the null space after Liegeois (1977).
"""

import dataclasses as dc
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from pydrake.autodiffutils import AutoDiffXd
from pydrake.math import (
    RigidTransform,
    RotationMatrix,
    atan2,
    cos,
    inv,
    sin,
    sqrt,
)
from pydrake.multibody.tree import JacobianWrtVariable

from drake_mobman.parameters import GAIN, LENGTH, YAW_RATE, Range, checked, within
from drake_mobman.scalars import Scalar, larger

_EYE = np.eye(6)

_TINY = 1e-14
"""Square of a singular value [m^2] that an inverse is given to stay finite."""

_REACHED = 1e-9
"""How far from where it is told to be the hand counts as there [m] and [rad]."""

_AT_BACK = 1e-9
"""How far past the back a posture still counts as at pi, not at -pi [rad]."""

_STILL = 1e-9
"""How fast a joint of the wrist moves its centre T at most [m/rad]."""

_STEPS = 200
"""Most that `inverse` takes; in reach, it takes about ten."""


@dc.dataclass
class Damping:
    """How the rates are bounded, and how arm and hand come back to the posture.

    The defaults are for a Franka arm.
    """

    # From the wrist to the tool: one radian there moves it by about this much.
    length: float = 0.2  # Weighs turning the hand against moving it [m].
    # On the smallest singular value, with rotational rows times `length`.
    threshold: float = 0.02  # Below it the rates are damped [m].
    # Slow beside the hand, which the elbow is not to disturb.
    posture_gain: float = 1.0  # Joint rates per distance from the posture [1/s].
    posture_speed: float = 0.5  # Largest norm of these [rad/s].
    # Takes back what a servo's lag, or someone's hand on the arm, has tilted.
    level_gain: float = 1.0  # Turning rate of the hand per tilt [1/s].

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, LENGTH, "length")
        within(self, Range(1e-6, 1.0, "m"), "threshold")
        within(self, GAIN, "posture_gain", "level_gain")
        within(self, Range(0.0, YAW_RATE.high, "rad/s"), "posture_speed")


def tilt(R: Any, R_level: Any) -> Any:
    """Returns the rotation (3,) from `R` to `R_level`, axis times sine of angle."""
    M = R_level @ R.T
    return 0.5 * np.array([M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1]])


def damped_pseudo_inverse(J: Any, damping: Damping) -> tuple[Any, Scalar]:
    """Returns J^T (J J^T + lambda^2 I)^-1 (n, 6), and 1 where lambda > 0, else 0.

    How near to singular J is tells w = trace((J J^T)^-1)^(-1/2), which is at most the
    smallest singular value and at least 1/sqrt(6) of it. lambda is 0 down to
    w = threshold, whence it grows smoothly to the threshold itself at w = 0: nothing
    is ever multiplied by more than about 1 / threshold.

    Args:
        J: Jacobian (6, n) of V_BE, rotational rows first.
        damping: its `length` weighs these rows, its `threshold` bounds w.
    """
    scaled, weights = _scaled(J, damping)
    gram = scaled @ scaled.T
    inverse = inv(gram + _TINY * _EYE)
    w_squared = 1.0 / np.trace(inverse)
    near = larger(1.0 - w_squared / damping.threshold**2, 0.0)
    if near > 0:
        inverse = inv(gram + (near * damping.threshold) ** 2 * _EYE)
    return scaled.T @ inverse * weights, 1.0 if near > 0 else 0.0


def pseudo_inverse(J: Any, damping: Damping) -> Any:
    """Returns the same without damping, however large it is."""
    scaled, weights = _scaled(J, damping)
    return scaled.T @ inv(scaled @ scaled.T + _TINY * _EYE) * weights


def _scaled(J: Any, damping: Damping) -> tuple[Any, Any]:
    """Returns J with rotational rows in metres, and the weights (6,) of its rows."""
    weights = np.array([damping.length] * 3 + [1.0] * 3)
    return weights[:, None] * J, weights


class JacobianArm:
    """An arm of six joints or more, for float and AutoDiffXd: an `ArmKinematics`.

    S is where the model has the first joint, which turns about B's z axis. psi is that
    joint's angle, the posture's bearing from its zero, and how far beyond this the hand
    is. So it has no jump where the arm points backwards or is mounted backwards, but
    where the first joint has the posture right across from the hand.

    The hand is level where it is turned to its reach as at the posture. The posture
    turns with the reach, so that the arm moves alike in all directions.

    The model is asked in a context of its own that each call overwrites: one object is
    not for two threads.
    """

    def __init__(
        self,
        plant: Any,
        posture: Any,
        damping: Damping | None = None,
        p_BT: Callable[[Any], Any] | None = None,
        p_SE: Callable[[Any], Any] | None = None,
    ) -> None:
        """Takes a finished plant whose last positions are the arm's.

        Args:
            plant: `MultibodyPlant` with links `base` (B), `tee` (T) and `tool` (E).
            posture: joint angles (n,) to stay near, the hand level [rad].
            damping: that for a Franka arm unless given.
            p_BT: tells where T is in closed form, where the arm has one.
            p_SE: tells where E is in closed form, from S in any axes that turn with
                the first joint about B's z axis, where the arm has one.

        Raises:
            ParameterError: where `damping` is not valid.
            ValueError: where the arm has fewer than six joints, or its first joint
                does not turn about B's z axis.
        """
        self.damping = checked(damping or Damping())
        self._p_BT, self._p_SE = p_BT, p_SE
        self.posture = np.array(posture, dtype=float)
        self.num_joints = n = len(self.posture)
        if n < 6:
            raise ValueError(f"a level hand takes six joints, and the arm has {n}")
        self._lower = plant.GetPositionLowerLimits()[-n:]
        self._upper = plant.GetPositionUpperLimits()[-n:]
        model = _Model(plant, n)
        self._models = {float: model}
        model.set(self.posture)
        if not np.allclose(model.J_V_BE()[:3, 0], [0, 0, 1]):
            raise ValueError("the arm's first joint does not turn about B's z axis")
        self.p_BS = tuple(model.p_BS().tolist())
        moved = np.abs(model.J_v_BT()).max(axis=0) > _STILL
        self.wrist = tuple(np.flatnonzero(~moved).tolist())
        X_BE = model.X_BE()
        x, y, _ = X_BE.translation() - self.p_BS
        # Of the posture, from the first joint's zero.
        self._bearing = _wrapped(atan2(y, x) - self.posture[0])
        if self._bearing < _AT_BACK - math.pi:
            self._bearing += 2 * math.pi
        self._p_SE_bearing = 0.0
        if p_SE:
            x, y, _ = p_SE(self.posture)
            self._p_SE_bearing = atan2(y, x)
        turned_back = _turned(-self.posture[0] - self._bearing)
        self._R_level = turned_back @ X_BE.rotation().matrix()

    def ee_cylindrical(self, q: Any) -> tuple[Scalar, Scalar, Scalar]:
        """Returns l, psi, z of the tool."""
        if self._p_SE:
            x, y, z = self._p_SE(q)
            l, beyond = _polar(x, y, self._p_SE_bearing)
        else:
            l, beyond, z = self._hand(self._at(q).X_BE(), q)
        return l, q[0] + self._bearing + beyond, z

    def yaw(self, q: Any) -> Scalar:
        """Returns the hand's yaw in B, psi where it is turned to its reach [rad].

        Of a hand that is not level, that of the level one nearest to it.
        """
        M = self._at(q).X_BE().rotation().matrix() @ self._R_level.T
        return atan2(M[1, 0] - M[0, 1], M[0, 0] + M[1, 1])

    def p_BT(self, q: Any) -> tuple[Scalar, Scalar, Scalar]:
        """Returns the wrist centre's position in B."""
        if self._p_BT:
            return self._p_BT(q)
        x, y, z = self._at(q).p_BT().tolist()
        return x, y, z

    def rates(self, q: Any, workspace_rates: Any) -> list[Scalar]:
        """Returns the joint rates (n,) that move the hand and keep the posture."""
        hand, posture, _ = self.hand_and_posture_rates(q, workspace_rates)
        return [a + b for a, b in zip(hand, posture, strict=True)]

    def undamped_rates(self, q: Any, *workspace_rates: Any) -> list[list[Scalar]]:
        """Returns the joint rates (n,) of each, however fast; the posture is not kept.

        The hand turns with its reach.
        """
        model = self._at(q)
        psi = q[0] + self._bearing + self._hand(model.X_BE(), q)[1]
        J_plus = pseudo_inverse(model.J_V_BE(), self.damping)
        return [_hand_rates(psi, J_plus, each) for each in workspace_rates]

    def turn_rates(self, q: Any) -> Any:
        """Returns the joint rates (n, 3) that turn the hand, E in its place; damped."""
        J = self._at(q).J_V_BE()
        return damped_pseudo_inverse(J, self.damping)[0][:, :3]

    def hand_and_posture_rates(
        self, q: Any, workspace_rates: Any
    ) -> tuple[list[Scalar], list[Scalar], Scalar]:
        """Returns the joint rates in two parts, and 1 where they are damped, else 0.

        The first part (n,) moves the hand as told and takes back its tilt; the second
        (n,) brings the joints nearer to the posture and leaves the hand where it is.

        Args:
            q: joint angles (n,) [rad].
            workspace_rates: v_m [m/s], omega_m [rad/s], v_z [m/s].
        """
        stance = self._stance(q)
        w = self._levelling(stance, stance.psi)
        hand = _hand_rates(stance.psi, stance.J_plus, workspace_rates, w)
        return hand, stance.posture.tolist(), stance.damped

    def oriented_parts(
        self, q: Any, workspace_rates: Any, yaw: Scalar
    ) -> "OrientedParts":
        """Returns the joint rates of a hand that is turned apart from its reach.

        Args:
            q: joint angles (n,) [rad].
            workspace_rates: v_m [m/s], omega_m [rad/s], v_z [m/s].
            yaw: where the hand is to be turned to, in B [rad].
        """
        stance = self._stance(q)
        turns = stance.J_plus[:, :3]
        return OrientedParts(
            hand=_hand_rates(stance.psi, stance.J_plus, workspace_rates),
            turns=turns,
            level=(turns @ self._levelling(stance, yaw)).tolist(),
            posture=stance.posture.tolist(),
            damped=stance.damped,
        )

    def is_near_singular(self, q: Any) -> Scalar:
        """Returns 1 where `rates` is damped, else 0."""
        return damped_pseudo_inverse(self._at(q).J_V_BE(), self.damping)[1]

    def inverse(self, workspace: Any) -> list[float]:
        """Returns the joint angles (n,) of the level hand at `workspace`; of floats.

        By steps after Levenberg and Marquardt from the posture, turned to psi. Out of
        reach, what they end at is near in position and, weighted, in rotation.
        """
        return self._nearest(workspace)[0].tolist()

    def is_in_reach(self, workspace: Any) -> bool:
        """Returns whether `inverse` brings the hand to `workspace`, and level."""
        q, error = self._nearest(workspace)
        missed = np.abs(np.subtract(self.ee_cylindrical(q), workspace))
        return bool(max(error, *missed) < _REACHED)

    def _stance(self, q: Any) -> "_Stance":
        """Returns what rates are made of at `q`."""
        model = self._at(q)
        X_BE, J = model.X_BE(), model.J_V_BE()
        beyond = self._hand(X_BE, q)[1]
        J_plus, damped = damped_pseudo_inverse(J, self.damping)
        away = self.posture - q
        away[0] = beyond
        pull = _shortened(self.damping.posture_gain * away, self.damping.posture_speed)
        return _Stance(
            R_BE=X_BE.rotation().matrix(),
            psi=q[0] + self._bearing + beyond,
            J_plus=J_plus,
            posture=pull - J_plus @ (J @ pull),
            damped=damped,
        )

    def _levelling(self, stance: "_Stance", yaw: Scalar) -> Any:
        """Returns how the hand is to turn to be level and at `yaw` (3,) [rad/s]."""
        R_level = _turned(yaw) @ self._R_level
        return self.damping.level_gain * tilt(stance.R_BE, R_level)

    def _at(self, q: Any) -> "_Model":
        """Returns the model for the scalars of `q`, with its joints there."""
        scalar = AutoDiffXd if isinstance(q[0], AutoDiffXd) else float
        if scalar not in self._models:
            plant = self._models[float].plant.ToScalarType[scalar]()
            self._models[scalar] = _Model(plant, self.num_joints)
        model = self._models[scalar]
        model.set(q)
        return model

    def _hand(self, X_BE: Any, q: Any) -> tuple[Scalar, Scalar, Scalar]:
        """Returns reach of E, bearing from where the posture has it, and height.

        The posture turned with the first joint, that is.
        """
        x, y, z = (X_BE.translation() - self.p_BS).tolist()
        return *_polar(x, y, q[0] + self._bearing), z

    def _nearest(self, workspace: Any) -> tuple[Any, float]:
        """Returns joint angles (n,), and the weighted error of the hand's pose [m]."""
        l, psi, z = map(float, workspace)
        l = larger(l, 0.0)
        R = RotationMatrix(_turned(psi) @ self._R_level)
        X_BD = RigidTransform(R, np.add(self.p_BS, (l * cos(psi), l * sin(psi), z)))
        q = self.posture.copy()
        q[0] = psi - self._bearing
        q = np.clip(q, self._lower, self._upper)
        error, J = self._error(q, X_BD)
        mu = 1e-3
        for _ in range(_STEPS):
            free = np.where(J.T @ error > 0, q < self._upper, q > self._lower)
            J_free = J * free
            step = J_free.T @ inv(J_free @ J_free.T + mu * _EYE) @ error
            next_q = np.clip(q + step, self._lower, self._upper)
            next_error, next_J = self._error(next_q, X_BD)
            if next_error @ next_error < error @ error:
                q, error, J = next_q, next_error, next_J
                mu = max(0.1 * mu, 1e-8)
            elif mu > 1e3:
                break
            else:
                mu *= 10
        return q, float(np.linalg.norm(error))

    def _error(self, q: Any, X_BD: Any) -> tuple[Any, Any]:
        """Returns what E lacks to D (6,), and the Jacobian (6, n), both weighted."""
        model = self._at(q)
        X_BE = model.X_BE()
        turn = (X_BD.rotation() @ X_BE.rotation().inverse()).ToAngleAxis()
        weight = self.damping.length
        error = np.append(
            weight * turn.angle() * turn.axis(),
            X_BD.translation() - X_BE.translation(),
        )
        J = model.J_V_BE()
        J[:3] *= weight
        return error, J


class OrientedParts(NamedTuple):
    """Joint rates of a hand that is turned apart from its reach; one moves E."""

    hand: list[Scalar]  # Move it as told, turning with its reach (n,) [rad/s].
    turns: Any  # Turn it by 1 rad/s about each of B's axes (n, 3) [rad/s].
    level: list[Scalar]  # Bring it level, and to its yaw (n,) [rad/s].
    posture: list[Scalar]  # Bring the joints nearer to the posture (n,) [rad/s].
    damped: Scalar  # 1 where the rates are damped, else 0.


class _Stance(NamedTuple):
    """An arm at some joint angles, by what its rates are made of."""

    R_BE: Any  # (3, 3).
    psi: Scalar  # [rad].
    J_plus: Any  # Damped pseudo-inverse of J_V_BE (n, 6).
    posture: Any  # Rates that bring the joints nearer to the posture (n,) [rad/s].
    damped: Scalar  # 1 where J_plus is damped, else 0.


def _hand_rates(
    psi: Scalar, J_plus: Any, workspace_rates: Any, w: Any = (0.0, 0.0, 0.0)
) -> list[Scalar]:
    """Returns the joint rates (n,) [rad/s] that make `workspace_rates`.

    The first joint turns all with omega_m, which no singularity disturbs; the others
    make what is left of V_BE.

    Args:
        psi: of the hand [rad].
        J_plus: pseudo-inverse of J_V_BE (n, 6).
        workspace_rates: v_m [m/s], omega_m [rad/s], v_z [m/s].
        w: how the hand turns beside omega_m (3,) [rad/s].
    """
    v_m, omega_m, v_z = workspace_rates
    along = [v_m * cos(psi), v_m * sin(psi), v_z]
    rates = (J_plus @ np.array([*w, *along])).tolist()
    rates[0] += omega_m
    return rates


class _Model:
    """The robot at one scalar type, its base at rest at the origin of W."""

    def __init__(self, plant: Any, joints: int) -> None:
        self.plant = plant
        self._context = plant.CreateDefaultContext()
        self._q = plant.GetPositions(self._context)
        self._arm = slice(len(self._q) - joints, None)
        self._B, self._T, self._E = map(plant.GetFrameByName, ("base", "tee", "tool"))

    def set(self, q: Any) -> None:
        """Takes the arm's joint angles (n,)."""
        self._q[self._arm] = q
        self.plant.SetPositions(self._context, self._q)

    def p_BS(self) -> Any:
        """Returns where the first joint's child has it (3,)."""
        joints = map(self.plant.get_joint, self.plant.GetJointIndices())
        first = next(
            joint
            for joint in joints
            if joint.num_positions() and joint.position_start() == self._arm.start
        )
        return first.frame_on_child().CalcPose(self._context, self._B).translation()

    def p_BT(self) -> Any:
        """Returns the position of T (3,)."""
        return self._T.CalcPose(self._context, self._B).translation()

    def X_BE(self) -> Any:
        """Returns the pose of E."""
        return self._E.CalcPose(self._context, self._B)

    def J_v_BT(self) -> Any:
        """Returns the Jacobian (3, n) of T's velocity by the arm's joints."""
        return self.plant.CalcJacobianTranslationalVelocity(
            self._context,
            JacobianWrtVariable.kV,
            self._T,
            np.zeros(3),
            self._B,
            self._B,
        )[:, self._arm]

    def J_V_BE(self) -> Any:
        """Returns the Jacobian (6, n) by the arm's joints, rotational rows first."""
        return self.plant.CalcJacobianSpatialVelocity(
            self._context,
            JacobianWrtVariable.kV,
            self._E,
            np.zeros(3),
            self._B,
            self._B,
        )[:, self._arm]


def _turned(psi: Scalar) -> Any:
    """Returns the matrix (3, 3) of a rotation by `psi` about z."""
    c, s = cos(psi), sin(psi)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _polar(x: Scalar, y: Scalar, zero: Scalar) -> tuple[Scalar, Scalar]:
    """Returns the length of a vector, and its angle from `zero` [rad]."""
    c, s = cos(zero), sin(zero)
    return sqrt(x * x + y * y), atan2(c * y - s * x, c * x + s * y)


def _wrapped(angle: Scalar) -> Scalar:
    """Returns the same angle between -pi and pi."""
    return atan2(sin(angle), cos(angle))


def _shortened(vector: Any, longest: float) -> Any:
    """Returns `vector`, or the one in its direction that is `longest` long."""
    squared = vector @ vector
    return vector * (longest / sqrt(squared)) if squared > longest**2 else vector
