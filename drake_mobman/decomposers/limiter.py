"""How much of the command the limits allow: one factor for end effector and base.

With both scaled alike, the end effector slows down but keeps its direction.
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
    known,
    larger,
    largest,
    smaller,
    smallest,
    smoothstep,
    where,
)
from drake_mobman.tracing import all_named, also_named, named

_RESERVE = 0.98
"""Share of a joint's limits that is used. The arm's inverse works with positions, not
rates; with this reserve it need not cut the arm's command."""

_LEAST_STOP = 0.2
"""Least time in which the end effector is stopped at the end of a joint's range [s]: an
elbow near full stretch turns ever faster at a constant speed of the end effector."""

_SLIGHT = 1e-9
"""Rate of a joint that no limit stops [rad/s]: rounding must not lock a joint."""

_TINY = 1e-15
"""Used in place of zero, so that nothing is divided by zero."""


Factors = dict[DecomposerStatus, Scalar]
"""The factor in [0, 1] by which each kind of limit scales the command."""


def least(factors: Factors, q: Any) -> Scalar:
    """Returns the smallest factor; NaN where an angle in `q` (n,) is NaN."""
    return also_named(smallest(*factors.values(), 1.0, made_of=tuple(q)))


def status(*several: Factors) -> Scalar:
    """Returns the sum of the flags of limits that are active in any of several."""
    flags = {flag: 0.0 for factors in several for flag in factors}
    for factors in several:
        for flag, s in factors.items():
            flags[flag] = also_named(where(s < 1, float(flag), flags[flag]))
    return functools.reduce(operator.add, flags.values())


def factor_within(rate: Scalar, induced: Scalar, bound: Scalar) -> Scalar:
    """Returns the largest s in [0, 1] that keeps s rate - induced within a bound.

    The bound is on the side of the sign of `rate`; 0 where no s is small enough.

    Args:
        rate: of a coordinate, for the whole command.
        induced: the part of that rate that the base's motion makes.
        bound: largest magnitude; may be infinite.
    """
    return factor_by(excess(rate, induced, bound))


def excess(rate: Scalar, induced: Scalar, bound: Scalar) -> Scalar:
    """Returns how many times too large `rate` is there; 0 for an infinite bound."""
    room = larger(bound + where(rate > 0, induced, -induced), _TINY)
    return also_named(abs(rate) / room)


def factor_by(*excesses: Scalar) -> Scalar:
    """Returns the largest factor in [0, 1] that undoes each excess.

    For Expressions, only `least` checks for NaN.
    """
    return also_named(1.0 / largest(1.0, *excesses, made_of=()))


def _joint_factors(by_rate: Iterable[Scalar], by_limit: Iterable[Scalar]) -> Factors:
    return {
        DecomposerStatus.JOINT_RATE: factor_by(*by_rate),
        DecomposerStatus.JOINT_LIMIT: factor_by(*by_limit),
    }


def _better_factors(new: Factors, old: Factors, q: Any) -> Factors:
    """Returns the new factors where the old are below 1 and the new leave more."""
    more = where(least(new, q) > least(old, q), 1.0, 0.0)
    better = named(where(old[DecomposerStatus.JOINT_LIMIT] < 1, more, 0.0))
    return {flag: named(where(better > 0.5, new[flag], old[flag])) for flag in old}


@dc.dataclass(frozen=True)
class Limiter:
    """The limits of a robot and of its arm's workspace."""

    arm: ArmKinematics
    joint_limits: JointLimits
    base_limits: BaseLimits
    workspace: WorkspaceLimits | None  # None where they may be exceeded.
    period: float  # For which a command is held [s].

    def __post_init__(self) -> None:
        """Converts limits to Python's floats, which take half the time of numpy's."""
        limits = (
            getattr(self.joint_limits, each.name)
            for each in dc.fields(self.joint_limits)
        )
        plain = JointLimits(*(list(map(float, each)) for each in limits))
        object.__setattr__(self, "joint_limits", plain)

    def steady_scaling(
        self, q: Any, arm_command: Any, v_b: Scalar, omega_b: Scalar
    ) -> Factors:
        """Returns the factors once the base moves as commanded.

        A joint comes to rest at the end of its range in the time that the base takes
        to stop, so that both stop together.

        Args:
            q: joint angles (n,) [rad].
            arm_command: rates of `ee_cylindrical` (3,) that the arm is to make.
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
        rates = self.arm.undamped_rates(q, arm_command)
        return factors | self._arm_factors(q, rates, excesses)

    def present_scaling(
        self, q: Any, at: Any, command: Any, smoothed: Any, estimate: Any
    ) -> Factors:
        """Returns the factors at the base's present velocity.

        Joints are judged by how the base moves, the edges of the workspace by how it is
        sent: where it falls short of that, the end effector goes on exactly, and the
        arm reaches past an edge meanwhile.

        Args:
            q: joint angles (n,) [rad].
            at: `ee_cylindrical` (3,).
            command: `ee_command` (3,).
            smoothed: `base_command_smoothed` (2,).
            estimate: `base_estimate` (3,).
        """
        v, v_y, omega = estimate
        along, turning = base_induced_rates(at, v, omega, self.arm.p_BS, v_y)
        induced = along, turning, 0.0

        def excesses(rates: Any, by_base: Any) -> tuple[list[Scalar], list[Scalar]]:
            by_rate, by_limit = [], []
            for i, (rate, part) in enumerate(zip(rates, by_base, strict=True)):
                fastest = _RESERVE * self.joint_limits.velocity[i]
                by_rate.append(excess(rate, part, fastest))
                towards_end = self._towards_end(self._room(q, i, rate), i)
                by_limit.append(excess(rate, part, towards_end))
            return by_rate, by_limit

        rates = self.arm.undamped_rates(q, command, induced)
        factors = self._arm_factors(q, rates, excesses)
        if self.workspace is not None:
            sent = base_induced_rates(at, smoothed[0], smoothed[1], self.arm.p_BS)
            by_edge = self._by_edges(self.workspace, at, command, sent)
            factors[DecomposerStatus.WORKSPACE] = factor_by(*by_edge)
        return factors

    def base_scaling(
        self, q: Any, v_b: Scalar, omega_b: Scalar
    ) -> tuple[Scalar, Scalar, Scalar]:
        """Returns as much of the base's motion as the arm can compensate for.

        The end effector is to stay at rest in W. Where a joint near its limit allows
        little of the motion, the base mostly turns on the spot, which may free the
        joint: if the joints can follow two motions, they can follow a mean of them. The
        base does not turn towards an end effector at the shoulder's axis, which has no
        bearing.

        Args:
            q: joint angles (n,) [rad].
            v_b: speed of the base [m/s].
            omega_b: its yaw rate [rad/s].

        Returns:
            v_b [m/s] and omega_b [rad/s] as far as the joints' ranges allow; and 1
            where that is all of both, else less.
        """
        at, p_BS = self.arm.ee_cylindrical(q), self.arm.p_BS
        away = smoothstep(at[0], LEAST_REACH, 2 * LEAST_REACH)
        omega = away * omega_b
        induced = (base_induced_rates(at, v, omega, p_BS) for v in (v_b, 0.0))
        commands = ((-along, -turning, 0.0) for along, turning in induced)

        def excesses(rates: Any) -> tuple[list[Scalar], list[Scalar]]:
            return [], self._towards_ends(q, rates)

        both, turning = (
            self._arm_factors(q, [rates], excesses)[DecomposerStatus.JOINT_LIMIT]
            for rates in self.arm.undamped_rates(q, *commands)
        )
        both = smallest(both, 1.0, made_of=tuple(q))
        share = both * both + (1.0 - both) * turning
        return both * both * v_b, share * omega, both * away

    def _arm_factors(self, q: Any, rates: Any, excesses: Any) -> Factors:
        """Returns the joints' factors on the position; the orientation comes second.

        A wrist joint whose limit would slow the end effector is kept at rest, which
        changes the orientation, where that leaves more: the arm's inverse does the
        same.

        Args:
            q: joint angles (n,) [rad].
            rates: one or more joint rates (n,) [rad/s], as `undamped_rates` returns.
            excesses: returns how many times too fast each joint is at such rates: for
                its largest rate, and for its range.
        """
        by_rate, by_limit = excesses(*rates)
        best, wrist = _joint_factors(by_rate, by_limit), self.arm.wrist
        if not wrist or known(best[DecomposerStatus.JOINT_LIMIT] >= 1):
            return best
        turns, held, at_rest = (
            self.arm.turn_rates(q),
            [0.0] * len(wrist),
            [0.0] * len(wrist),
        )
        for _ in wrist:
            more = [
                where(h > 0.5, 0.0, where(by_limit[i] > 1, 1.0, 0.0))
                for i, h in zip(wrist, held, strict=True)
            ]
            if known(sum(more) == 0):
                break
            held = all_named([h + m for h, m in zip(held, more, strict=True)])
            eased = [relieved(each, wrist, held, at_rest, turns) for each in rates]
            by_rate, by_limit = excesses(*eased)
            best = _better_factors(_joint_factors(by_rate, by_limit), best, q)
        return best

    def _towards_ends(self, q: Any, rates: Any) -> list[Scalar]:
        """Returns how many times too fast each joint approaches the end of its range.

        It is to come to rest there in the time that the base takes to stop, and no
        faster than it can brake, where that is known.

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
            found.append(also_named(speed / bound))
        return found

    @property
    def _slowing(self) -> float:
        """Returns the share of its speed that the base can lose in a second [1/s]."""
        base, most = self.base_limits, 1.0 / _LEAST_STOP
        if base.follows_at_once:
            return most
        return min(
            base.max_acceleration / base.max_speed,
            base.max_yaw_acceleration / base.max_yaw_rate,
            most,
        )

    def _room(self, q: Any, i: int, rate: Scalar) -> Scalar:
        """Returns half the angle from joint `i` to its limit, along its rate [rad].

        Half, as an elbow near full stretch turns twice as far as its rate predicts.
        """
        upper, lower = self.joint_limits.upper[i], self.joint_limits.lower[i]
        return 0.5 * where(rate > 0, upper - q[i], q[i] - lower)

    def _towards_end(self, room: Scalar, i: int) -> Scalar:
        most = self.joint_limits.acceleration[i]
        return larger(_RESERVE * braking_rate(room, most, self.period), _SLIGHT)

    def _by_edges(
        self, edges: WorkspaceLimits, at: Any, command: Any, induced: Any
    ) -> Iterable[Scalar]:
        """Yields how many times too fast the command is for the limits of l and psi."""
        ends = (edges.l_min, edges.l_max), (edges.psi_min, edges.psi_max)
        base = self.base_limits
        brakes = base.max_acceleration, base.max_yaw_acceleration
        for i in range(2):
            lower, upper = ends[i]
            x, rate = at[i], command[i]
            room = where(rate > 0, upper - x, x - lower)
            bound = braking_rate(room, brakes[i], self.period)
            yield excess(rate, induced[i], bound)
