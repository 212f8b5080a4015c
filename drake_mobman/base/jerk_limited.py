"""Limits of speed, acceleration and jerk of the base command.

Our own law. The smoothed command follows the raw one as fast as the limits allow. Its
slope is zero when it arrives: it does not overshoot a raw command that is held.
"""

import dataclasses as dc
from typing import Any, ClassVar

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_mobman import signals
from drake_mobman.arm.limits import braking_rate
from drake_mobman.blocks import cached, scalar_block
from drake_mobman.parameters import (
    ACCELERATION,
    JERK,
    SPEED,
    YAW_ACCELERATION,
    YAW_JERK,
    YAW_RATE,
    checked,
    checked_period,
    within,
)
from drake_mobman.robot_model import BaseLimits, RobotSetup
from drake_mobman.scalars import Scalar, Vector, finite_or_zero, saturated, smaller


@dc.dataclass
class JerkLimited:
    """The base command is limited in speed, acceleration and jerk."""

    max_speed: float = 0.5  # Of the base, forward and back [m/s].
    max_acceleration: float = 1.0  # [m/s^2].
    max_jerk: float = 10.0  # [m/s^3].
    max_yaw_rate: float = 1.0  # [rad/s].
    max_yaw_acceleration: float = 2.0  # [rad/s^2].
    max_yaw_jerk: float = 20.0  # [rad/s^3].
    states: ClassVar[int] = 4

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, SPEED, "max_speed")
        within(self, ACCELERATION, "max_acceleration")
        within(self, JERK, "max_jerk")
        within(self, YAW_RATE, "max_yaw_rate")
        within(self, YAW_ACCELERATION, "max_yaw_acceleration")
        within(self, YAW_JERK, "max_yaw_jerk")

    def limits(self) -> BaseLimits:
        """Returns the limits that the base keeps to."""
        return BaseLimits(**dc.asdict(self))

    def next(self, state: Vector, raw: Vector, period: float) -> list[Scalar]:
        """Returns the next state (4,): the smoothed command, and its slope."""
        limits = (
            (self.max_speed, self.max_acceleration, self.max_jerk),
            (self.max_yaw_rate, self.max_yaw_acceleration, self.max_yaw_jerk),
        )
        (v, v_slope), (omega, omega_slope) = (
            jerk_limited(state[i], state[2 + i], raw[i], limits[i], period)
            for i in range(2)
        )
        return [v, omega, v_slope, omega_slope]

    def build(self, setup: RobotSetup) -> "JerkLimiter":
        """Returns the block for a robot."""
        return JerkLimiter(self, setup.period)


def jerk_limited(
    last: Scalar,
    slope: Scalar,
    raw: Scalar,
    limits: tuple[float, float, float],
    period: float,
) -> tuple[Scalar, Scalar]:
    """Returns one component of the next smoothed command, and its slope.

    The slope is so small that the jerk can bring it to 0 before the command reaches the
    raw one. It is the law of a joint near the end of its range, one derivative higher.

    Args:
        last: the last smoothed command.
        slope: its rate of change then.
        raw: the controller's command now; a stop where it is not finite.
        limits: largest magnitude, slope, and change of slope in a second.
        period: for which a command is held, h [s].
    """
    limit, steepest, jerk = limits
    gap = saturated(finite_or_zero(raw), limit) - last
    bound = smaller(braking_rate(abs(gap), jerk, period), steepest)
    desired = saturated(gap / period, bound)
    slope = slope + saturated(desired - slope, jerk * period)
    return last + period * slope, slope


@scalar_block
class JerkLimiter(LeafSystem):
    """Turns a raw base command into one of bounded speed, acceleration and jerk.

    .. pydrake_system::

        name: JerkLimiter
        input_ports:
        - base_command
        output_ports:
        - base_command_smoothed

    The state is the last smoothed command (2,), and its slope (2,).

    Args:
        params: limits.
        period: control period [s].

    Raises:
        ParameterError: where a parameter is not valid.
    """

    def __init__(self, params: JerkLimited, period: float) -> None:
        self.params = checked(params)
        self.period = checked_period(period)
        self.raw = self.DeclareVectorInputPort(signals.BASE_COMMAND, 2)
        self.DeclareDiscreteState(4)
        self._next = cached(self, self._calc_next)
        self.DeclareVectorOutputPort(
            signals.BASE_COMMAND_SMOOTHED,
            2,
            self._calc_smoothed,
            prerequisites_of_calc={self._next.ticket},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._keep)

    def _calc_next(self, context: Any) -> list[Scalar]:
        """Returns the next state (4,)."""
        vector = context.get_discrete_state_vector()
        state = [vector.GetAtIndex(i) for i in range(4)]
        return self.params.next(state, self.raw.Eval(context).tolist(), self.period)

    def _calc_smoothed(self, context: Any, output: Any) -> None:
        output.SetFromVector(np.array(self._next(context)[:2]))

    def _keep(self, context: Any, state: Any) -> None:
        state.get_mutable_vector().SetFromVector(np.array(self._next(context)))


JerkLimiter_ = JerkLimiter.template
