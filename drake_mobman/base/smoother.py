"""Exponential smoothing and rate limit of the base command.

Petric & Zlajpah, eqs. 7-12.
"""

import dataclasses as dc
from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_mobman import signals
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
from drake_mobman.scalars import (
    Scalar,
    finite_or_zero,
    nearer_to_rest,
    saturated,
    where,
)


@dc.dataclass
class Smoother:
    """What the platform can follow."""

    enabled: bool = True  # If false, a command passes as it is, if it is finite.
    smoothing: float = 0.2  # alpha: share of the new command taken each period, (0, 1].
    max_speed: float = 0.5  # Of the base, forward and back [m/s].
    max_acceleration: float = 1.0  # [m/s^2].
    max_yaw_rate: float = 1.0  # [rad/s].
    max_yaw_acceleration: float = 2.0  # [rad/s^2].

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, Range(1e-4, 1.0), "smoothing")
        within(self, SPEED, "max_speed")
        within(self, ACCELERATION, "max_acceleration")
        within(self, YAW_RATE, "max_yaw_rate")
        within(self, YAW_ACCELERATION, "max_yaw_acceleration")


def smoothed(
    sent: Scalar, raw: Scalar, smoothing: float, step: float, limit: float
) -> Scalar:
    """Returns the next command sent, one component of it.

    Both the filter (eqs. 7, 8) and the rate limit (eqs. 9, 10) start from the command
    last sent: u_k = sat_limit(u_{k-1} + sat_step(alpha (raw_k - u_{k-1}))).

    A raw command of exactly zero is a stop, and a stop is not filtered: the filter's
    tail never ends, while without it the base is at rest within limit/step periods. A
    raw command that is not finite is a stop too.

    Args:
        sent: command last sent, u_{k-1}.
        raw: what the controller asks for now.
        smoothing: alpha, in (0, 1].
        step: largest change in a period.
        limit: largest magnitude.
    """
    raw = finite_or_zero(raw)
    # At rest the filter counts, so that the law is linearised there with it.
    stops = where(raw == 0, where(sent == 0, 0.0, 1.0), 0.0)
    filtered = sent + saturated(smoothing * (raw - sent), step)
    return saturated(where(stops > 0, nearer_to_rest(sent, step), filtered), limit)


@TemplateSystem.define("CommandSmoother_")
def CommandSmoother_(T: Any) -> Any:
    """Returns the block for scalars of type `T`."""

    class Impl(LeafSystem_[T]):
        """Turns a raw base command into one that the platform can follow.

        .. pydrake_system::

            name: CommandSmoother
            input_ports:
            - base_command
            output_ports:
            - base_command_smoothed

        Built as `CommandSmoother(params, period)`: a `Smoother` and the control
        period [s]. The state is the command last sent; without smoothing there is
        none. Raises `ParameterError` where a parameter is not valid.
        """

        def _construct(
            self, params: Smoother, period: float, converter: Any = None
        ) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            self.params = checked(params)
            self.period = checked_period(period)
            self.raw = self.DeclareVectorInputPort(signals.BASE_COMMAND, 2)
            # Not time: what depends on it is worked out twice a period.
            needs = {self.all_input_ports_ticket(), self.xd_ticket()}
            self.sent = self.DeclareVectorOutputPort(
                signals.BASE_COMMAND_SMOOTHED,
                2,
                self._calc_sent,
                prerequisites_of_calc=needs,
            )
            if params.enabled:
                self.DeclareDiscreteState(2)
                self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._keep_sent)

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(self, other.params, other.period, converter=converter)

        def _calc_sent(self, context: Any, output: Any) -> None:
            raw = self.raw.Eval(context).tolist()
            if not self.params.enabled:
                output.SetFromVector(np.array([finite_or_zero(x) for x in raw]))
                return
            p, last = self.params, context.get_discrete_state_vector()
            steps = p.max_acceleration, p.max_yaw_acceleration
            limits = p.max_speed, p.max_yaw_rate
            output.SetFromVector(
                np.array(
                    [
                        smoothed(
                            last.GetAtIndex(i),
                            raw[i],
                            p.smoothing,
                            steps[i] * self.period,
                            limits[i],
                        )
                        for i in range(2)
                    ]
                )
            )

        def _keep_sent(self, context: Any, state: Any) -> None:
            state.get_mutable_vector().SetFromVector(self.sent.Eval(context))

    return Impl


CommandSmoother = CommandSmoother_[None]
