"""How much of the command the limits leave: one factor for hand and base.

Scaled together, the hand slows down in its direction instead of turning out of it.
"""

import dataclasses as dc
import functools
import math
import operator
from collections.abc import Iterable
from typing import Any

from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.arm.limits import JointLimits, braking_rate
from drake_mobman.arm.place_first import relieved
from drake_mobman.decomposers.arm_compensation import LEAST_REACH, base_induced_rates
from drake_mobman.decomposers.status import DecomposerStatus
from drake_mobman.robot_model import BaseLimits, WorkspaceLimits
from drake_mobman.scalars import (
    Scalar,
    larger,
    largest,
    smaller,
    smallest,
    smoothstep,
    where,
)

_RESERVE = 0.98
"""How much of a joint's limits is used, that the arm's inverse, which goes by positions
and not by rates, need not cut what is left to the arm."""

_LEAST_STOP = 0.2
"""Least time in which a hand is slowed down to rest at the end of a joint's range [s],
as an elbow that is stretched turns ever faster for a hand that goes on."""

_SLIGHT = 1e-9
"""Rate of a joint that no limit is held against [rad/s]: rounding must not lock it."""

_TINY = 1e-15
"""Stands for no rate, or no room at all, so that nothing is divided by zero."""


Factors = dict[DecomposerStatus, Scalar]
"""What each kind of limit leaves of the command, in [0, 1]."""


def least(factors: Factors, q: Any) -> Scalar:
    """Returns what all limits leave of the command; NaN where `q` is not all numbers.

    Where a command is none, it is none however little is left of it.
    """
    return smallest(*factors.values(), 1.0, made_of=tuple(q))


def status(*several: Factors) -> Scalar:
    """Returns the sum of the flags of those that bind in any of several."""
    flags = {flag: 0.0 for factors in several for flag in factors}
    for factors in several:
        for flag, s in factors.items():
            flags[flag] = where(s < 1, float(flag), flags[flag])
    return functools.reduce(operator.add, flags.values())


def factor_within(wanted: Scalar, carried: Scalar, bound: Scalar) -> Scalar:
    """Returns the largest s in [0, 1] that keeps s wanted - carried within a bound.

    On the side that `wanted` leads to; 0 where no s does.

    Args:
        wanted: rate of a coordinate that the whole command takes.
        carried: what the base's motion takes of it off.
        bound: largest rate to that side; may be infinite.
    """
    return factor_by(excess(wanted, carried, bound))


def excess(wanted: Scalar, carried: Scalar, bound: Scalar) -> Scalar:
    """Returns how many times too large `wanted` is there; 0 for an infinite bound."""
    room = larger(bound + where(wanted > 0, carried, -carried), _TINY)
    return abs(wanted) / room


def factor_by(*excesses: Scalar) -> Scalar:
    """Returns the largest factor in [0, 1] that undoes each excess.

    In Expressions NaN is not told before `least`.
    """
    return 1.0 / largest(1.0, *excesses, made_of=())


def _by_joints(by_rate: Iterable[Scalar], by_limit: Iterable[Scalar]) -> Factors:
    return {
        DecomposerStatus.JOINT_RATE: factor_by(*by_rate),
        DecomposerStatus.JOINT_LIMIT: factor_by(*by_limit),
    }


@dc.dataclass(frozen=True)
class Limiter:
    """The limits of a robot, and of the workspace that its arm is to keep."""

    arm: ArmKinematics
    joint_limits: JointLimits
    base_limits: BaseLimits
    workspace: WorkspaceLimits | None  # None where it may be left.
    period: float  # For which a command is held [s].

    def __post_init__(self) -> None:
        """Takes the limits as Python's own floats, which take half numpy's time."""
        limits = (
            getattr(self.joint_limits, each.name)
            for each in dc.fields(self.joint_limits)
        )
        plain = JointLimits(*(list(map(float, each)) for each in limits))
        object.__setattr__(self, "joint_limits", plain)

    def steady_scaling(
        self, q: Any, rest: Any, v_b: Scalar, omega_b: Scalar
    ) -> Factors:
        """Returns what the limits leave of a command that the base keeps up with.

        A joint comes to rest at the end of its range in the time that the base takes
        to stop, so that both can.

        Args:
            q: joint angles (n,) [rad].
            rest: rates of `workspace` that are left to the arm.
            v_b: speed of the base [m/s].
            omega_b: its yaw rate [rad/s].
        """
        base = self.base_limits
        by_base = abs(v_b) / base.max_speed, abs(omega_b) / base.max_yaw_rate

        def excesses(rates: Any) -> tuple[list[Scalar], list[Scalar]]:
            by_rate = [
                abs(rate) / (_RESERVE * fastest)
                for rate, fastest in zip(rates, self.joint_limits.velocity, strict=True)
            ]
            return by_rate, self._towards_ends(q, rates)

        factors = {DecomposerStatus.BASE_RATE: factor_by(*by_base)}
        return factors | self._placed(q, self.arm.undamped_rates(q, rest), excesses)

    def present_scaling(self, q: Any, at: Any, command: Any, smoothed: Any) -> Factors:
        """Returns what the limits leave of a command while the base moves as sent.

        Args:
            q: joint angles (n,) [rad].
            at: `ee_cylindrical` (3,).
            command: `ee_command` (3,).
            smoothed: `base_command_smoothed` (2,).
        """
        along, turning = base_induced_rates(at, smoothed[0], smoothed[1], self.arm.p_BS)
        carried = along, turning, 0.0

        def excesses(rates: Any, taken: Any) -> tuple[list[Scalar], list[Scalar]]:
            by_rate, by_limit = [], []
            for i, (wanted, off) in enumerate(zip(rates, taken, strict=True)):
                fastest = _RESERVE * self.joint_limits.velocity[i]
                by_rate.append(excess(wanted, off, fastest))
                towards_end = self._towards_end(self._room(q, i, wanted), i)
                by_limit.append(excess(wanted, off, towards_end))
            return by_rate, by_limit

        rates = self.arm.undamped_rates(q, command, carried)
        factors = self._placed(q, rates, excesses)
        if self.workspace is not None:
            by_edge = self._by_edges(self.workspace, at, command, carried)
            factors[DecomposerStatus.WORKSPACE] = factor_by(*by_edge)
        return factors

    def given_way(
        self, q: Any, v_b: Scalar, omega_b: Scalar
    ) -> tuple[Scalar, Scalar, Scalar]:
        """Returns how much of the base's motion the arm can give way to.

        While the hand keeps still in W, that is. The less of it a joint near its end
        leaves, the more of the rest is turning alone, which may be what frees it: a
        mean of two motions that the joints can follow is one. A hand at the shoulder's
        axis has no bearing to be turned to.

        Args:
            q: joint angles (n,) [rad].
            v_b: speed of the base [m/s].
            omega_b: its yaw rate [rad/s].

        Returns:
            Both as far as the joints' ranges leave room, and 1 if that is all of them,
            else less.
        """
        at, p_BS = self.arm.ee_cylindrical(q), self.arm.p_BS
        away = smoothstep(at[0], LEAST_REACH, 2 * LEAST_REACH)
        omega = away * omega_b
        off = (base_induced_rates(at, v, omega, p_BS) for v in (v_b, 0.0))
        left = ((-along, -turning, 0.0) for along, turning in off)
        both, turning = (
            self._placed(q, [rates], lambda rates: ([], self._towards_ends(q, rates)))[
                DecomposerStatus.JOINT_LIMIT
            ]
            for rates in self.arm.undamped_rates(q, *left)
        )
        both = smallest(both, 1.0, made_of=tuple(q))
        share = both * both + (1.0 - both) * turning
        return both * both * v_b, share * omega, both * away

    def _placed(self, q: Any, rates: Any, excesses: Any) -> Factors:
        """Returns what the joints leave of the hand's place, however it is turned.

        A joint of the wrist that its end would slow is left at rest instead, and the
        hand turned otherwise, where that leaves more: the arm's inverse does likewise.

        Args:
            q: joint angles (n,) [rad].
            rates: of the joints (n,) [rad/s], one or more of them, as the arm has them.
            excesses: returns of such rates how many times too fast each joint is for
                its speed, and for its end.
        """
        by_rate, by_limit = excesses(*rates)
        best, held, turns = _by_joints(by_rate, by_limit), set[int](), None
        while self.arm.wrist and best[DecomposerStatus.JOINT_LIMIT] < 1:
            more = {i for i in self.arm.wrist if by_limit[i] > 1} - held
            if not more:
                break
            held |= more
            turns = self.arm.turn_rates(q) if turns is None else turns
            at_rest = dict.fromkeys(held, 0.0)
            eased = [relieved(each, at_rest, turns) for each in rates]
            by_rate, by_limit = excesses(*eased)
            factors = _by_joints(by_rate, by_limit)
            if least(factors, q) > least(best, q):
                best = factors
        return best

    def _towards_ends(self, q: Any, rates: Any) -> list[Scalar]:
        """Returns how many times too fast each joint nears the end of its range.

        To come to rest there in the time that the base takes to stop, and no faster
        than it can brake, where that is known.

        Args:
            q: joint angles (n,) [rad].
            rates: of the joints (n,) [rad/s].
        """
        slowing, found = self._slowing, []
        for i, rate in enumerate(rates):
            room, speed = self._room(q, i, rate), larger(abs(rate), _SLIGHT)
            in_time = speed * braking_rate(room / speed, slowing, self.period)
            bound = larger(in_time, _SLIGHT)
            if math.isfinite(self.joint_limits.acceleration[i]):
                bound = smaller(bound, self._towards_end(room, i))
            found.append(speed / bound)
        return found

    @property
    def _slowing(self) -> float:
        """Returns what share of its speed a hand with its base can lose in a second."""
        base, most = self.base_limits, 1.0 / _LEAST_STOP
        if base.follows_at_once:
            return most
        return min(
            base.max_acceleration / base.max_speed,
            base.max_yaw_acceleration / base.max_yaw_rate,
            most,
        )

    def _room(self, q: Any, i: int, rate: Scalar) -> Scalar:
        """Returns half the angle left to joint `i` where its rate leads to [rad].

        Half, as an elbow that is stretched goes twice as far as its rate said.
        """
        upper, lower = self.joint_limits.upper[i], self.joint_limits.lower[i]
        return 0.5 * where(rate > 0, upper - q[i], q[i] - lower)

    def _towards_end(self, room: Scalar, i: int) -> Scalar:
        most = self.joint_limits.acceleration[i]
        return larger(_RESERVE * braking_rate(room, most, self.period), _SLIGHT)

    def _by_edges(
        self, edges: WorkspaceLimits, at: Any, command: Any, carried: Any
    ) -> Iterable[Scalar]:
        """Returns how much too fast the command is for the ends of l and of psi."""
        ends = (edges.l_min, edges.l_max), (edges.psi_min, edges.psi_max)
        base = self.base_limits
        brakes = base.max_acceleration, base.max_yaw_acceleration
        for i in range(2):
            lower, upper = ends[i]
            x, wanted = at[i], command[i]
            room = where(wanted > 0, upper - x, x - lower)
            bound = braking_rate(room, brakes[i], self.period)
            yield excess(wanted, carried[i], bound)
