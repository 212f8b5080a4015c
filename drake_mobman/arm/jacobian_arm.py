"""Any arm with three joints or more, by the Jacobian of its chain.

With six joints or more, the end effector stays level. It turns with the reach, as that
of Kwon's spatial arm does in closed form, or independently of it. Joints that are left
keep the elbow near a posture meanwhile, in the null space of the Jacobian (Liegeois,
1977).
"""

import math
from typing import Any, NamedTuple

import numpy as np
from pydrake.math import atan2, cos, sin, sqrt

from drake_mobman.arm.chain import Row, chain_of
from drake_mobman.arm.inverse_kinematics import nearest_joint_angles
from drake_mobman.arm.orientation import rotation_about_z
from drake_mobman.arm.pseudo_inverse import (
    Damping,
    damped_pseudo_inverse,
    dot,
    pseudo_inverse,
)
from drake_mobman.arm.shoulder import shoulder_of
from drake_mobman.machine_code import FastLaw
from drake_mobman.parameters import checked
from drake_mobman.scalars import (
    Matrix,
    Rows,
    Scalar,
    Vector,
    larger,
    smaller,
    where,
)
from drake_mobman.tracing import all_named, named

LEVEL = 6
"""Joints that it takes to place the end effector and to keep it level."""

_PLACED = 3
"""Joints that it takes to place it."""

_REACHED = 1e-9
"""How far E may miss a point and still counts as there [m] and [rad]."""

_AT_BACK = 1e-9
"""How far past the back a posture still counts as at pi, not at -pi [rad]."""

_STILL = 1e-9
"""How fast a joint of the wrist moves its centre T at most [m/rad]."""

_TINY = 1e-30
"""Square of a rate [rad^2/s^2], in place of zero, so that nothing is divided by it."""


class OrientedParts(NamedTuple):
    """Joint rates of an end effector that turns independently of its reach.

    Only the first part moves E.
    """

    ee: list[Scalar]  # Move E as commanded, turning with its reach (n,) [rad/s].
    turns: list[Row]  # Turn it by 1 rad/s about each of B's axes (n, 3) [rad/s].
    level: list[Scalar]  # Turn it level, and to its yaw (n,) [rad/s].
    posture: list[Scalar]  # Bring the joints nearer to the posture (n,) [rad/s].
    damped: Scalar  # 1 where the rates are damped, else 0.


class JacobianArm:
    """An arm with three joints or more, for any scalar: an `ArmKinematics`.

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

    For floats, its laws are machine code, compiled when they are first used.

    Args:
        plant: finalized `MultibodyPlant` with frames `base` (B), `tee` (T) and `tool`
            (E); between B and E it has the arm's joints.
        posture: joint positions (n,) to stay near, with E level [rad], [m].
        damping: of the rates; by default, that for a Franka arm.
        level: whether E stays level; by default, where the arm has joints enough.

    Raises:
        ParameterError: where `damping` is not valid.
        ValueError: where the arm has too few joints, or others than `posture`.
    """

    def __init__(
        self,
        plant: Any,
        posture: Vector,
        damping: Damping | None = None,
        *,
        level: bool | None = None,
    ) -> None:
        self.damping = checked(damping or Damping())
        self.posture = np.array(posture, dtype=float)
        self.num_joints = n = len(self.posture)
        self.level = n >= LEVEL if level is None else level
        if n < (LEVEL if self.level else _PLACED):
            what = "level" if self.level else "placed"
            raise ValueError(f"the arm's {n} joints are too few for a {what} tool")
        self.chain = chain_of(plant)
        if self.chain.num_joints != n:
            raise ValueError(f"the arm has {self.chain.num_joints} joints, not {n}")
        self._rows = slice(0, 6) if self.level else slice(3, 6)
        self._lower, self._upper = self.chain.lower, self.chain.upper
        at = self.chain.at(self.posture.tolist())
        p_BS, self.turn, self.lift = shoulder_of(self.chain, self.posture)
        self.p_BS = tuple(p_BS.tolist())
        # Where the others are enough, they move E, and the lift follows.
        enough = n > (LEVEL if self.level else _PLACED)
        self._follows = self.lift.joint if self.lift and enough else None
        moved = np.abs(self.chain.J_v_BT(at)).max(axis=0) > _STILL
        self.wrist = tuple(np.flatnonzero(~moved).tolist()) if self.level else ()
        x, y, self._z = np.subtract(at.X_BE.p, p_BS).tolist()
        # Of the posture, at the turning joint's zero.
        psi = atan2(y, x)
        if psi < _AT_BACK - math.pi:
            psi += 2 * math.pi
        # Not wrapped, as the joint's angle is not: psi is the posture's bearing there.
        self._bearing = psi - self._turned(self.posture)
        # E's axes are B's where it is level, and its reach is along x.
        self.chain = self.chain.with_tool_turned(
            np.transpose(at.X_BE.R) @ rotation_about_z(psi)
        )
        self._fast_laws(n)

    def _fast_laws(self, n: int) -> None:
        """Makes its laws fast for floats."""
        self._cylindrical = FastLaw(self._cylindrical_law, n)
        self._yaw = FastLaw(self._yaw_law, n)
        self._p_BT = FastLaw(lambda q: self.chain.at(q).p_BT, n)
        self._pose = FastLaw(self._pose_law, n)
        self._undamped = [
            FastLaw(self._undamped_law, n, *[3] * count) for count in range(4)
        ]
        self._parts = FastLaw(self._parts_law, n, 3, 1)

    def ee_cylindrical(self, q: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns l [m], psi [rad], z [m] of E for joint angles `q` (n,) [rad]."""
        l, psi, z = self._cylindrical(q)
        return l, psi, z

    def yaw(self, q: Vector) -> Scalar:
        """Returns the yaw of E in B [rad], which is psi where E is turned to its reach.

        Where E is not level, it is that of the level orientation nearest to it.
        """
        return self._yaw(q)[0]

    def p_BT(self, q: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns the position of T in B [m]."""
        x, y, z = self._p_BT(q)
        return x, y, z

    def rates(self, q: Vector, ee_rates: Vector) -> list[Scalar]:
        """Returns the joint rates (n,) that move E and keep the posture [rad/s]."""
        ee, posture, _ = self.ee_and_posture_rates(q, ee_rates)
        return [a + b for a, b in zip(ee, posture, strict=True)]

    def undamped_rates(self, q: Vector, *ee_rates: Vector) -> list[list[Scalar]]:
        """Returns the joint rates (n,) [rad/s] for each of several `ee_rates`.

        E turns with its reach; the posture is not kept, and nothing is damped.
        """
        return _split(self._undamped[len(ee_rates)](q, *ee_rates), self.num_joints)

    def turn_rates(self, q: Vector) -> list[Row]:
        """Returns the joint rates (n, 3) that turn E in its place, damped."""
        return self.oriented_parts(q, (0.0, 0.0, 0.0), 0.0).turns

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
        parts = self.oriented_parts(q, ee_rates, self.ee_cylindrical(q)[1])
        ee = [a + b for a, b in zip(parts.ee, parts.level, strict=True)]
        return ee, parts.posture, parts.damped

    def oriented_parts(self, q: Vector, ee_rates: Vector, yaw: Scalar) -> OrientedParts:
        """Returns joint rates of an end effector that turns apart from its reach.

        Args:
            q: joint angles (n,) [rad].
            ee_rates: v_m [m/s], omega_m [rad/s], v_z [m/s].
            yaw: desired yaw of E in B [rad].
        """
        *found, damped = self._parts(q, ee_rates, [yaw])
        ee, level, posture, *by_axis = _split(found, self.num_joints)
        turns = [list(row) for row in zip(*by_axis, strict=True)]
        return OrientedParts(ee, turns, level, posture, damped)

    def is_near_singular(self, q: Vector) -> Scalar:
        """Returns 1 where `rates` is damped, else 0."""
        return self.oriented_parts(q, (0.0, 0.0, 0.0), 0.0).damped

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

    def pose_and_jacobian(self, q: Vector) -> tuple[Matrix, Matrix, Matrix]:
        """Returns E's axes (3, 3) and place (3,) in B, and the Jacobian (6, n); floats.

        The axes are B's where E is level and its reach is along x.
        """
        found = np.array(self._pose(q))
        return found[:9].reshape(3, 3), found[9:12], found[12:].reshape(6, -1)

    # The laws.

    def _cylindrical_law(self, q: Vector) -> list[Scalar]:
        return list(self._at(q).cylindrical)

    def _yaw_law(self, q: Vector) -> list[Scalar]:
        R = self.chain.at(q).X_BE.R
        return [atan2(R[1][0] - R[0][1], R[0][0] + R[1][1])]

    def _pose_law(self, q: Vector) -> list[Scalar]:
        at = self.chain.at(q)
        return [
            x for row in (*at.X_BE.R, at.X_BE.p, *self.chain.J_V_BE(at)) for x in row
        ]

    def _undamped_law(self, q: Vector, *ee_rates: Vector) -> list[Scalar]:
        at = self._at(q)
        J_plus = pseudo_inverse(self._moving(at.J), self.damping)
        return [x for each in ee_rates for x in self._joint_rates(at, J_plus, each)]

    def _parts_law(self, q: Vector, ee_rates: Vector, yaw: Vector) -> list[Scalar]:
        """Returns the `OrientedParts`, with `turns` by columns."""
        at = self._at(q)
        J_plus, damped = damped_pseudo_inverse(self._moving(at.J), self.damping)
        still = [[0.0] * 3] * self.num_joints
        turns = [row[:3] for row in J_plus] if self.level else still
        w = self._levelling(at.R, yaw[0])
        pull = self._pull(q, at)
        moved = all_named([dot(row, pull) for row in at.J])
        return [
            *self._joint_rates(at, J_plus, ee_rates),
            *all_named([dot(row, w) for row in turns]),
            *(
                all_named(
                    [a - dot(row, moved) for a, row in zip(pull, J_plus, strict=True)]
                )
            ),
            *(x for column in zip(*turns, strict=True) for x in column),
            damped,
        ]

    def _at(self, q: Vector) -> "_At":
        placed = self.chain.at(q)
        x, y, z = all_named(
            [a - b for a, b in zip(placed.X_BE.p, self.p_BS, strict=True)]
        )
        facing = self._turned(q) + self._bearing
        c, s = named(cos(facing)), named(sin(facing))
        beyond = named(atan2(c * y - s * x, c * x + s * y))
        return _At(
            R=placed.X_BE.R,
            J=self.chain.J_V_BE(placed)[self._rows],
            cylindrical=(named(sqrt(x * x + y * y)), named(facing + beyond), z),
            beyond=beyond,
        )

    def _turned(self, q: Vector) -> Scalar:
        """Returns how far the turning joint has turned the arm to the left [rad]."""
        return self.turn.sign * q[self.turn.joint] if self.turn else 0.0

    def _moving(self, J: Rows) -> Rows:
        """Returns the Jacobian of the joints that move E: a lift may only follow."""
        return [
            [0.0 if i == self._follows else x for i, x in enumerate(row)] for row in J
        ]

    def _joint_rates(self, at: "_At", J_plus: Rows, ee_rates: Vector) -> list[Scalar]:
        """Returns the joint rates (n,) that make `ee_rates`, E turned to its reach.

        The turning joint makes omega_m, at a singularity too; the others make the rest.
        """
        v_m, omega_m, v_z = ee_rates
        l, psi, _ = at.cylindrical
        c, s, across = named(cos(psi)), named(sin(psi)), named(l * omega_m)
        wanted = [0.0, 0.0, omega_m, v_m * c - across * s, v_m * s + across * c, v_z]
        wanted = wanted[self._rows]
        if self.turn is None:
            return all_named([dot(row, wanted) for row in J_plus])
        i, turning = self.turn.joint, self.turn.sign * omega_m
        left = all_named(
            [x - row[i] * turning for x, row in zip(wanted, at.J, strict=True)]
        )
        rates = [dot(row, left) for row in J_plus]
        rates[i] = rates[i] + turning
        return all_named(rates)

    def _levelling(self, R: Rows, yaw: Scalar) -> list[Scalar]:
        """Returns the angular velocity (3,) that turns E level and to `yaw` [rad/s].

        By the axis of the rotation that is left, times the sine of its angle.
        """
        c, s = named(cos(yaw)), named(sin(yaw))
        (xx, xy, xz), (yx, yy, yz), (zx, zy, _) = R
        gain = 0.5 * self.damping.level_gain
        return all_named(
            [
                gain * (yz - s * zx - c * zy),
                gain * (c * zx - s * zy - xz),
                gain * (s * xx + c * xy - c * yx + s * yy),
            ]
        )

    def _pull(self, q: Vector, at: "_At") -> list[Scalar]:
        """Returns the rates (n,) towards the posture, turned and lifted to E."""
        away = [a - b for a, b in zip(self.posture.tolist(), q, strict=True)]
        if self.turn:
            away[self.turn.joint] = self.turn.sign * at.beyond
        if self.lift:
            i, sign = self.lift
            to = self.posture[i] + sign * (at.cylindrical[2] - self._z)
            away[i] = larger(smaller(to, self._upper[i]), self._lower[i]) - q[i]
        gain, most = self.damping.posture_gain, self.damping.posture_speed
        pull = all_named([gain * x for x in away])
        squared = named(dot(pull, pull))
        shorter = most / sqrt(larger(squared, _TINY))
        share = named(where(squared > most**2, shorter, 1.0))
        return all_named([share * x for x in pull])

    def _nearest(self, ee_cylindrical: Vector) -> tuple[Matrix, float]:
        """Returns joint angles (n,), and the weighted error of E's pose [m]."""
        l, psi, z = map(float, ee_cylindrical)
        l = larger(l, 0.0)
        q = self.posture.copy()
        if self.turn:
            q[self.turn.joint] = self.turn.sign * (psi - self._bearing)
        if self.lift:
            q[self.lift.joint] += self.lift.sign * (z - self._z)
        return nearest_joint_angles(
            self.pose_and_jacobian,
            rotation_about_z(psi),
            np.add(self.p_BS, (l * cos(psi), l * sin(psi), z)),
            np.clip(q, self._lower, self._upper),
            np.array(self._lower),
            np.array(self._upper),
            self.damping.length if self.level else None,
        )


class _At(NamedTuple):
    """Where E is at some joint positions, and how the joints move it."""

    R: list[Row]  # Rows of its axes in B (3, 3).
    J: Rows  # Jacobian of V_BE (6, n), or of v_BE (3, n) where E is placed only.
    cylindrical: tuple[Scalar, Scalar, Scalar]  # l [m], psi [rad], z [m].
    beyond: Scalar  # Bearing of E from the posture's, turned to face it [rad].


def _split(flat: list[Scalar], size: int) -> list[list[Scalar]]:
    """Returns a list cut into lists of one size."""
    return [flat[i : i + size] for i in range(0, len(flat), size)]
