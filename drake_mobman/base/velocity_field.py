"""The base follows the end effector by a velocity field about itself.

Petric & Zlajpah, eqs. 1-6: as printed, except for the sign of d_r, or projected.
"""

import dataclasses as dc
import enum
import math
from typing import Any, Protocol

import numpy as np
from pydrake.math import atan2, cos, sqrt
from pydrake.systems.framework import LeafSystem

from drake_mobman import signals
from drake_mobman.arm.first_joint import (
    FirstJoint,
    first_joint,
    turning_share,
    unwound,
)
from drake_mobman.arm.limits import JointLimits
from drake_mobman.arm.shoulder import FIRST, Carrier
from drake_mobman.blocks import scalar_block
from drake_mobman.parameters import (
    GAIN,
    YAW_RATE,
    ParameterError,
    Range,
    checked,
    in_order,
    one_of,
    within,
)
from drake_mobman.robot_model import Reach, RobotSetup
from drake_mobman.scalars import Scalar, larger, smoothstep, where

LAWS = ("printed", "projected")
"""The field as printed, or with v times the cosine of the bearing."""


_NEAREST = 1e-12
"""Square of T's distance from the shoulder's axis, in place of zero [m^2]."""


class Zone(enum.IntFlag):
    """How the field moves the base (fig. 1)."""

    PASSIVE = 0
    FORWARD = 1
    """T is near the end of the arm's reach: the base drives forward."""
    RETREAT = 2
    """T is near the base: the base drives back."""
    ROTATION = 4
    """T is to one side: the base turns towards it."""
    HELD = 8
    """The arm's first joint is near its limit: the base turns less."""


@dc.dataclass
class VelocityField:
    """Gains and thresholds; the paper gives no values.

    The defaults are for a Franka arm (r_f = 0.7 m) on a TIAGo base (0.27 m in radius)
    that follows a hand of 0.35 m/s at up to 0.5 m/s and 1 rad/s.
    """

    # As printed, "forward" drives away from a T that is behind the base.
    law: str = "projected"  # `projected`: v times cos(phi); or `printed`.
    # A hand of 0.35 m/s goes 9 cm into a zone before the base is as fast, which is less
    # than the width of either. With the smoother's lag of about 0.05 s, the loop does
    # not overshoot for gains below 1 / (4 x 0.05 s) = 5.
    K_f: float = 4.0  # Forward speed per depth in the forward zone [1/s].
    K_r: float = 4.0  # Backward speed per depth in the retreat zone [1/s].
    # As fast as the base may turn: the bearing of a hand that moves sideways at
    # 0.35 m/s, 0.4 m from the base, turns at 0.9 rad/s.
    K_omega: float = 1.0  # Yaw rate at phi_max and beyond [rad/s].
    # Full speed is reached 2.5 cm before the arm is stretched, which is singular.
    Delta_f: float = 0.15  # Width of the forward zone, inwards from r_f [m].
    # Leaves 15 cm between the zones, where only the arm moves.
    Delta_r: float = 0.1  # Width of the retreat zone, outwards from b_d [m].
    # The base's radius, and 3 cm for the wrist.
    b_d: float = 0.3  # Radius of the capsule that T is to stay out of [m].
    # Motion 10 cm to either side, half a metre ahead, does not turn the base.
    phi_min: float = 0.2  # Heading error from which the base turns [rad].
    # Wide enough for the slope of omega, 1.5 K_omega / 0.4 rad, to stay below 5 too.
    phi_max: float = 0.6  # Heading error from which it turns at K_omega [rad].

    def check(self) -> None:
        """Raises `ParameterError` unless gains, widths and angles are in range."""
        one_of(self, "law", LAWS)
        within(self, GAIN, "K_f", "K_r")
        within(self, Range(0.0, YAW_RATE.high, "rad/s"), "K_omega")
        within(self, Range(1e-3, 10.0, "m"), "Delta_f", "Delta_r", "b_d")
        within(self, Range(0.0, math.pi, "rad"), "phi_min", "phi_max")
        in_order(self, "phi_min", "phi_max")

    def check_reach(self, reach: Reach) -> None:
        """Raises `ParameterError` unless the field fits an arm of this reach."""
        check_zones(self, reach)

    def build(self, setup: RobotSetup) -> "VelocityFieldController":
        """Returns the block for a robot."""
        turn = setup.arm.turn
        return VelocityFieldController(self, setup.reach, setup.joint_limits, turn)

    def command(
        self, p_BT: Any, reach: Reach, joint: FirstJoint | None
    ) -> tuple[Scalar, Scalar, Scalar]:
        """Returns v [m/s], omega [rad/s], and 1 where the first joint holds the base.

        Args:
            p_BT: position of T in B (3,) [m].
            reach: of the arm.
            joint: the arm's first; None where it has no limits.
        """
        v, omega = field_velocity(p_BT, self, reach, joint)
        if joint is None:
            return v, omega, 0.0 * v
        zone = field_zone(p_BT, self, reach, joint)
        return v, omega, where(zone >= float(Zone.HELD), 1.0, 0.0 * v)

    @property
    def label(self) -> str:
        """Returns the controller's name on the console."""
        return f"field, {self.law}"

    def variants(self) -> list["VelocityField"]:
        """Returns the same field by each law, for an operator to choose from."""
        return [dc.replace(self, law=law) for law in LAWS]


def check_zones(params: VelocityField, reach: Reach) -> None:
    """Raises `ParameterError` unless there is a passive zone between the other two.

    It is checked at the shoulder's height. Far below, where the capsule is a cylinder
    but the reach is a sphere, the two zones can meet, and v jumps there.
    """
    within, room = "r_f", reach.r_f
    for key in ("Delta_f", "b_d", "Delta_r"):
        value = getattr(params, key)
        if not value < room:
            valid = f"must be below {within} = {room:.6g} to leave a passive zone"
            raise ParameterError(key, value, valid)
        within, room = f"{within} - {key}", room - value


def signed_distances(p_BT: Any, reach: Reach, capsule: float) -> tuple[Scalar, Scalar]:
    """Returns d_f and d_r [m]: distances to the end of the reach and to the capsule.

    Eqs. 1-3. d_r is the distance less b_d; with the sign as printed, the base would
    drive away from a T that is far away.

    Args:
        p_BT: position of T in B (3,) [m].
        reach: of the arm.
        capsule: its radius b_d [m].
    """
    x, y, z = p_BT[0] - reach.ahead, p_BT[1] - reach.aside, p_BT[2] - reach.l_0
    level = x * x + y * y
    distance = sqrt(level + z * z)
    return reach.r_f - distance, where(z > 0, distance, sqrt(level)) - capsule


def linear_velocity(d_f: Scalar, d_r: Scalar, params: VelocityField) -> Scalar:
    """Returns v [m/s] as printed (eq. 4), from the signed distances [m]."""
    # Not a plain 0: a NaN position must not make a valid command.
    passive = 0.0 * d_f
    forward = where(d_f < params.Delta_f, params.K_f * (params.Delta_f - d_f), passive)
    backward = -params.K_r * (params.Delta_r - d_r)
    return where(d_r < params.Delta_r, backward, forward)


class Turning(Protocol):
    """How the base turns towards T."""

    K_omega: float  # Yaw rate at phi_max and beyond [rad/s].
    phi_min: float  # Heading error from which the base turns [rad].
    phi_max: float  # Heading error from which it turns at K_omega [rad].


def yaw_rate(phi: Scalar, params: Turning) -> Scalar:
    """Returns omega [rad/s] (eqs. 5, 6) at the heading error `phi` [rad]."""
    gamma = smoothstep(abs(phi), params.phi_min, params.phi_max)
    return params.K_omega * where(phi < 0, -gamma, gamma)


def bearing(p_BT: Any, reach: Reach) -> Scalar:
    """Returns the bearing of T from the shoulder [rad], in [-pi, pi].

    About B, the base would turn until an arm on its left reached over to the right: its
    first joint would be near an end where T is straight ahead.

    Args:
        p_BT: position of T in B (3,) [m].
        reach: of the arm.
    """
    return atan2(p_BT[1] - reach.aside, p_BT[0] - reach.ahead)


def turning_helps(p_BT: Any, reach: Reach) -> Scalar:
    """Returns the share of its yaw rate at which the base turns towards T, in [0, 1].

    Turning at omega changes the bearing of a T at rest by -omega (p_BT . p_ST) / l^2.
    Where T is between B and a shoulder that is ahead of it, that is the wrong way; near
    there, the base turns less, and in there not at all.

    Args:
        p_BT: position of T in B (3,) [m].
        reach: of the arm.
    """
    x, y = p_BT[0] - reach.ahead, p_BT[1] - reach.aside
    closing = p_BT[0] * x + p_BT[1] * y
    return smoothstep(closing / larger(x * x + y * y, _NEAREST), 0.0, 0.5)


def field_heading(
    p_BT: Any, params: Turning, reach: Reach, joint: FirstJoint | None
) -> tuple[Scalar, Scalar, Scalar]:
    """Returns the heading error phi [rad], omega [rad/s], and its scale in [0, 1].

    phi counts whole turns of the first joint. omega is scaled down where that joint is
    near its limit and cannot turn back as fast.

    Args:
        p_BT: position of T in B (3,) [m].
        params: how the base turns.
        reach: of the arm.
        joint: the arm's first; None where it has no limits.
    """
    phi = bearing(p_BT, reach)
    helps = turning_helps(p_BT, reach)
    if joint is None:
        return phi, helps * yaw_rate(phi, params), 1.0
    phi = unwound(phi, joint)
    omega = helps * yaw_rate(phi, params)
    share = turning_share(omega, joint, params.phi_max - params.phi_min)
    return phi, share * omega, share


def field_velocity(
    p_BT: Any, params: VelocityField, reach: Reach, joint: FirstJoint | None = None
) -> tuple[Scalar, Scalar]:
    """Returns v [m/s] and omega [rad/s] of the field at `p_BT` (3,) [m].

    Projected, v is multiplied by the cosine of the bearing: in whatever direction T is,
    the base does not drive away from a far T or towards a near one (exact where the
    shoulder is on B's z axis). That bearing is from abreast of B, in line with the
    shoulder. As printed, the base would circle about T while it unwinds the arm; so it
    turns on the spot until that is done.

    Args:
        p_BT: position of T in B (3,) [m].
        params: of the field.
        reach: of the arm.
        joint: the arm's first; None where it has no limits.
    """
    phi, omega, _ = field_heading(p_BT, params, reach, joint)
    v = linear_velocity(*signed_distances(p_BT, reach, params.b_d), params)
    if params.law == "projected":
        # From abreast of B: else a T between B and the shoulder would be circled.
        v = v * cos(atan2(p_BT[1] - reach.aside, p_BT[0]))
    elif joint is not None:
        v = where(abs(phi) > math.pi, 0.0, v)
    return v, omega


def field_zone(
    p_BT: Any, params: VelocityField, reach: Reach, joint: FirstJoint | None = None
) -> Scalar:
    """Returns the sum of the `Zone` flags that hold; arguments as `field_velocity`."""
    d_f, d_r = signed_distances(p_BT, reach, params.b_d)
    phi, _, share = field_heading(p_BT, params, reach, joint)
    forward = where(d_f < params.Delta_f, float(Zone.FORWARD), 0.0)
    linear = where(d_r < params.Delta_r, float(Zone.RETREAT), forward)
    aside = where(abs(phi) > params.phi_min, float(Zone.ROTATION), 0.0)
    held = where(aside > 0, where(share < 1, float(Zone.HELD), 0.0), 0.0)
    return linear + aside + held


def field_on(points: Any, params: VelocityField, reach: Reach) -> tuple[Any, Any, Any]:
    """Returns v, omega and zone on many points, for figures.

    Args:
        points: positions of T in B (..., 3) [m]; each result is (...).
        params: of the field.
        reach: of the arm.
    """
    points = np.asarray(points, dtype=float)
    # Python's floats take half the time of numpy's.
    rows = points.reshape(-1, 3).tolist()
    values = [
        (*field_velocity(p, params, reach), field_zone(p, params, reach)) for p in rows
    ]
    v, omega, zone = np.array(values).T.reshape(3, *points.shape[:-1])
    return v, omega, zone.astype(int)


@scalar_block
class VelocityFieldController(LeafSystem):
    """Drives the base by the position of T in the base's frame alone.

    .. pydrake_system::

        name: VelocityFieldController
        input_ports:
        - p_BT
        - arm_position (only where joint limits are given, and a joint turns the arm)
        output_ports:
        - base_command
        - field_zone

    Args:
        params: of the field.
        reach: of the arm.
        joint_limits: of the arm; None where its first joint has none.
        turn: the joint that turns all of the arm; None where none does.

    Raises:
        ParameterError: where a parameter is not valid, or there is no passive zone.
    """

    def __init__(
        self,
        params: VelocityField,
        reach: Reach,
        joint_limits: JointLimits | None = None,
        turn: Carrier | None = FIRST,
    ) -> None:
        self.params, self.reach = checked(params), checked(reach)
        self.joint_limits, self.turn = joint_limits if turn else None, turn
        check_zones(params, reach)
        self.p_BT = self.DeclareVectorInputPort(signals.P_BT, 3)
        if self.joint_limits is not None:
            n = len(self.joint_limits.lower)
            self.position = self.DeclareVectorInputPort(signals.ARM_POSITION, n)
        needs = {self.all_input_ports_ticket()}
        self.DeclareVectorOutputPort(
            signals.BASE_COMMAND, 2, self._calc_base, prerequisites_of_calc=needs
        )
        self.DeclareVectorOutputPort(
            signals.FIELD_ZONE, 1, self._calc_zone, prerequisites_of_calc=needs
        )

    def _at(self, context: Any) -> tuple[Any, VelocityField, Reach, FirstJoint | None]:
        joint = None
        if self.joint_limits is not None:
            q = self.position.Eval(context).tolist()
            joint = first_joint(q, self.joint_limits, self.turn)
        return self.p_BT.Eval(context).tolist(), self.params, self.reach, joint

    def _calc_base(self, context: Any, output: Any) -> None:
        output.SetFromVector(np.array(field_velocity(*self._at(context))))

    def _calc_zone(self, context: Any, output: Any) -> None:
        output.SetFromVector(np.array([field_zone(*self._at(context))]))


VelocityFieldController_ = VelocityFieldController.template
