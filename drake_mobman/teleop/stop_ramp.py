"""The base stops where the gate stops the operator's command.

A velocity field makes the base follow the end effector, commanded or not. The gate
stops the end effector only: without a ramp, the base would still come closer to it.
"""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_mobman import signals
from drake_mobman.parameters import checked, checked_period
from drake_mobman.scalars import Scalar, nearer_to_rest
from drake_mobman.teleop.gate import GateStatus
from drake_mobman.teleop.guard import Guard


def next_share(share: Scalar, is_open: bool, guard: Guard, period: float) -> Scalar:
    """Returns the share of its command that the base gets, one `period` [s] on.

    1 while the gate is open; then it falls to 0 within the guard's `stop_time`.
    """
    if is_open:
        return 1.0
    return nearer_to_rest(share, period / max(guard.stop_time, period))


class StopRamp(LeafSystem):
    """Passes the base's command while the gate is open, and ramps it down otherwise.

    .. pydrake_system::

        name: StopRamp
        input_ports:
        - base_command
        - gate_status
        output_ports:
        - base_command

    The state is the share of the command that the base gets.

    Args:
        guard: its `stop_time` is the duration of the ramp.
        period: control period [s].

    Raises:
        ParameterError: where a parameter is not valid.
    """

    def __init__(self, guard: Guard, period: float) -> None:
        super().__init__()
        self.guard = checked(guard)
        self.period = checked_period(period)
        self.command = self.DeclareVectorInputPort(signals.BASE_COMMAND, 2)
        self.status = self.DeclareVectorInputPort(signals.GATE_STATUS, 1)
        self.DeclareVectorOutputPort(
            signals.BASE_COMMAND,
            2,
            self._calc,
            prerequisites_of_calc={self.all_input_ports_ticket(), self.xd_ticket()},
        )
        self.DeclareDiscreteState(1)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._advance)

    def _share(self, context: Any) -> float:
        last = context.get_discrete_state_vector().GetAtIndex(0)
        is_open = self.status.Eval(context)[0] == GateStatus.OK
        return next_share(last, is_open, self.guard, self.period)

    def _calc(self, context: Any, output: Any) -> None:
        share = self._share(context)
        # A share of 0 gives exactly 0, which the smoother takes for a stop.
        command = self.command.Eval(context)
        output.SetFromVector(share * command if share > 0 else np.zeros(2))

    def _advance(self, context: Any, state: Any) -> None:
        state.get_mutable_vector().SetAtIndex(0, self._share(context))
