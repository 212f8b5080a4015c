"""Exponential smoothing and rate limit of the base command.

Petric & Zlajpah, eqs. 7-12.
"""

import dataclasses as dc
from typing import Any, ClassVar

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_mobman import signals
from drake_mobman.blocks import scalar_block
from drake_mobman.parameters import (
    ACCELERATION,
    SPEED,
    YAW_ACCELERATION,
    YAW_RATE,
    Range,
    checked,
    checked_period,
    within,
)
from drake_mobman.robot_model import BaseLimits, RobotSetup
from drake_mobman.scalars import (
    Scalar,
    Vector,
    finite_or_zero,
    nearer_to_rest,
    saturated,
    where,
)


@dc.dataclass
class Smoother:
    """The base command is smoothed; the platform's own limits may be wider."""

    smoothing: float = 0.2  # alpha: share of the new command taken each period, (0, 1].
    max_speed: float = 0.5  # Of the base, forward and back [m/s].
    max_acceleration: float = 1.0  # [m/s^2].
    max_yaw_rate: float = 1.0  # [rad/s].
    max_yaw_acceleration: float = 2.0  # [rad/s^2].
    states: ClassVar[int] = 2

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, Range(1e-4, 1.0), "smoothing")
        within(self, SPEED, "max_speed")
        within(self, ACCELERATION, "max_acceleration")
        within(self, YAW_RATE, "max_yaw_rate")
        within(self, YAW_ACCELERATION, "max_yaw_acceleration")

    def limits(self) -> BaseLimits:
        """Returns the limits that the base keeps to."""
        return BaseLimits(
            self.max_speed,
            self.max_acceleration,
            self.max_yaw_rate,
            self.max_yaw_acceleration,
        )

    def next(self, state: Vector, raw: Vector, period: float) -> list[Scalar]:
        """Returns the next smoothed command (2,), from the last one (eqs. 7-11)."""
        steps = self.max_acceleration, self.max_yaw_acceleration
        limits = self.max_speed, self.max_yaw_rate
        return [
            smoothed(state[i], raw[i], self.smoothing, steps[i] * period, limits[i])
            for i in range(2)
        ]

    def build(self, setup: RobotSetup) -> "CommandSmoother":
        """Returns the block for a robot."""
        return CommandSmoother(self, setup.period)


def smoothed(
    last: Scalar, raw: Scalar, smoothing: float, step: float, limit: float
) -> Scalar:
    """Returns one component of the next smoothed command.

    Both the filter (eqs. 7, 8) and the rate limit (eqs. 9, 10) start from the last
    smoothed command: u_k = sat_limit(u_{k-1} + sat_step(alpha (raw_k - u_{k-1}))).

    A raw command of exactly zero is a stop, and a stop is not filtered: a filter never
    quite reaches zero, while without it the base is at rest within limit/step periods.
    A raw command that is not finite is a stop too.

    Args:
        last: the last smoothed command, u_{k-1}.
        raw: the controller's command now.
        smoothing: alpha, in (0, 1].
        step: largest change in a period.
        limit: largest magnitude.
    """
    raw = finite_or_zero(raw)
    # At rest the filter is used, so that a linearisation there contains it.
    stops = where(raw == 0, where(last == 0, 0.0, 1.0), 0.0)
    filtered = last + saturated(smoothing * (raw - last), step)
    return saturated(where(stops > 0, nearer_to_rest(last, step), filtered), limit)


@scalar_block
class CommandSmoother(LeafSystem):
    """Turns a raw base command into one that the platform can follow.

    .. pydrake_system::

        name: CommandSmoother
        input_ports:
        - base_command
        output_ports:
        - base_command_smoothed

    The state is the last smoothed command (2,).

    Args:
        params: of the filter and its limits.
        period: control period [s].

    Raises:
        ParameterError: where a parameter is not valid.
    """

    def __init__(self, params: Smoother, period: float) -> None:
        self.params = checked(params)
        self.period = checked_period(period)
        self.raw = self.DeclareVectorInputPort(signals.BASE_COMMAND, 2)
        # Without time: what depends on time is computed twice a period.
        needs = {self.all_input_ports_ticket(), self.xd_ticket()}
        self.smoothed = self.DeclareVectorOutputPort(
            signals.BASE_COMMAND_SMOOTHED,
            2,
            self._calc_smoothed,
            prerequisites_of_calc=needs,
        )
        self.DeclareDiscreteState(2)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._keep_smoothed)

    def _calc_smoothed(self, context: Any, output: Any) -> None:
        raw = self.raw.Eval(context).tolist()
        state = context.get_discrete_state_vector()
        last = state.GetAtIndex(0), state.GetAtIndex(1)
        output.SetFromVector(np.array(self.params.next(last, raw, self.period)))

    def _keep_smoothed(self, context: Any, state: Any) -> None:
        state.get_mutable_vector().SetFromVector(self.smoothed.Eval(context))


CommandSmoother_ = CommandSmoother.template
