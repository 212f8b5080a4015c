"""The command gate: nothing moves unless a present operator wants it to.

A live command comes over a link that may freeze, break or lie. The gate is the last
block before the controllers, and knows of the link only what `operator_input` tells.
"""

import dataclasses as dc
import enum
import math
from typing import Any, NamedTuple

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_mobman import signals
from drake_mobman.parameters import (
    ParameterError,
    Range,
    checked,
    checked_period,
    within,
)
from drake_mobman.teleop.drag import NO_BODY, NOTHING, Draggable, drag_status
from drake_mobman.teleop.guard import (
    Guard,
    GuardStatus,
    braked,
    command_status,
    cut_off,
)
from drake_mobman.teleop.live import SIZE, OperatorSample


class GateStatus(enum.IntEnum):
    """Why the robot is held still; goes on from `GuardStatus`."""

    OK = 0
    NOT_FINITE = 1
    """The command was not finite."""
    OVER_RANGE = 2
    """The command was larger than a command may be."""
    NOT_ARMED = 3
    """The dead-man has not been pressed yet."""
    RELEASED = 4
    """The dead-man was let go."""
    STALE = 5
    """The operator was not heard in time."""
    STOPPED = 6
    """Someone asked for a stop."""
    GONE = 7
    """There is no operator any more: he handed over, left, or was cut off."""


class Arming(enum.IntEnum):
    """How far the operator has come in arming."""

    LATCHED = 0
    """A neutral stick is wanted, with the dead-man let go."""
    READY = 1
    """That was seen a period ago: a press of the dead-man arms."""
    ARMED = 2
    """Commands pass."""


@dc.dataclass
class Gate:
    """What makes a command one of an operator who is there."""

    fresh: float = 0.25  # Oldest that a command may be [s].
    neutral: float = 0.05  # What counts as no command, as a share of the largest.

    def check(self) -> None:
        """Raises `ParameterError` unless times and shares are such."""
        within(self, Range(1e-3, 60.0, "s"), "fresh")
        if not 0 <= self.neutral < 1:
            raise ParameterError("neutral", self.neutral, "must be within [0, 1)")


class GateState(NamedTuple):
    """Where the gate stands."""

    arming: Arming = Arming.LATCHED
    status: GateStatus = GateStatus.NOT_ARMED


def input_status(
    said: OperatorSample, gate: Gate, guard: Guard, draggable: Draggable = NO_BODY
) -> GateStatus:
    """Returns why what is said may not pass, the gravest reason, or OK."""
    # Comparisons are such that a NaN never counts as held, fresh, or no stop.
    if said.stop != 0:
        return GateStatus.STOPPED
    if said.age == math.inf:
        return GateStatus.GONE
    if not 0 <= said.age <= gate.fresh:
        return GateStatus.STALE
    whys = command_status(said.command, guard), drag_status(said.dragged, draggable)
    for grave in (GuardStatus.NOT_FINITE, GuardStatus.OVER_RANGE):
        if grave in whys:
            return GateStatus(int(grave))
    return GateStatus.OK if said.dead_man > 0.5 else GateStatus.RELEASED


def is_at_rest(said: OperatorSample, gate: Gate, guard: Guard) -> bool:
    """Returns whether an operator is there, and neither presses nor commands."""
    # No body may be dragged here: to drag is to command.
    let_go = input_status(said, gate, guard) == GateStatus.RELEASED
    return let_go and all(
        abs(c) <= gate.neutral * most
        for c, most in zip(said.command, guard.largest, strict=True)
    )


def next_state(
    last: GateState,
    said: OperatorSample,
    gate: Gate,
    guard: Guard,
    draggable: Draggable = NO_BODY,
) -> GateState:
    """Returns where the gate stands a period on, given what is said now.

    The reason of a stop stays until the gate is armed again; but for a stop that anyone
    asks for, which is told in any case, and a press that does not arm.
    """
    why = input_status(said, gate, guard, draggable)
    if why == GateStatus.OK and last.arming != Arming.LATCHED:
        return GateState(Arming.ARMED, GateStatus.OK)
    if is_at_rest(said, gate, guard) and last.arming != Arming.ARMED:
        return GateState(Arming.READY, last.status)
    pressed = last.arming == Arming.READY and said.dead_man > 0.5
    told = last.arming == Arming.ARMED or pressed or why == GateStatus.STOPPED
    return GateState(Arming.LATCHED, why if told else last.status)


class CommandGate(LeafSystem):
    """Passes the commands of an armed operator, and brakes to rest otherwise.

    .. pydrake_system::

        name: CommandGate
        input_ports:
        - operator_input
        output_ports:
        - ee_command
        - guard_status
        - gate_status
        - gate_arming
        - drag (where anything may be dragged)

    A command passes, bit for bit, if the operator has armed the gate and the command is
    fresh, finite and in range. The first that is not ends as a stop from the command
    last passed, within the guard's `stop_time`, and latches the reason; to arm again,
    the operator lets dead-man and stick go, and then presses the dead-man afresh.
    `guard_status` tells of the command as it comes, as the guard does. A drag passes
    as a command does; with the first that may not, the point is let go.

    The state is the command last passed, `Arming` and `GateStatus`. There is no clock
    in it: the age of a command is measured where it comes in, and is data here.

    Args:
        params: what arms.
        guard: what a command may be, and how it is stopped.
        period: control period [s].
        draggable: what of the robot may be dragged.

    Raises:
        ParameterError: where a parameter is not valid.
    """

    def __init__(
        self,
        params: Gate,
        guard: Guard,
        period: float,
        draggable: Draggable = NO_BODY,
    ) -> None:
        super().__init__()
        self.params = checked(params)
        self.guard = checked(guard)
        self.period = checked_period(period)
        self.draggable = draggable
        checked(draggable.params)
        self.said = self.DeclareVectorInputPort(signals.OPERATOR_INPUT, SIZE)
        said = {self.input_port_ticket(self.said.get_index())}
        both = said | {self.xd_ticket()}
        ports = [
            (signals.EE_COMMAND, 3, self._calc_passed, both),
            (signals.GUARD_STATUS, 1, self._calc_guard_status, said),
            (signals.GATE_STATUS, 1, self._calc_gate_status, both),
            (signals.GATE_ARMING, 1, self._calc_arming, both),
        ]
        if draggable.bodies:
            ports.append((signals.DRAG, len(NOTHING), self._calc_drag, both))
        for name, size, calc, needs in ports:
            self.DeclareVectorOutputPort(name, size, calc, prerequisites_of_calc=needs)
        self.DeclareDiscreteState(np.array([0.0, 0.0, 0.0, *GateState()]))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._keep)

    def _said(self, context: Any) -> OperatorSample:
        return OperatorSample(*self.said.Eval(context).tolist())

    def _next(self, context: Any) -> tuple[list[float], GateState]:
        """Returns the command that passes, and where the gate stands then."""
        said = self._said(context)
        *passed, arming, status = context.get_discrete_state_vector().value()
        last = GateState(Arming(int(arming)), GateStatus(int(status)))
        state = next_state(last, said, self.params, self.guard, self.draggable)
        if state.arming == Arming.ARMED:
            return cut_off(said.command, self.guard), state
        return braked(passed, self.guard, self.period), state

    def _calc_passed(self, context: Any, output: Any) -> None:
        output.SetFromVector(np.array(self._next(context)[0]))

    def _calc_guard_status(self, context: Any, output: Any) -> None:
        status = command_status(self._said(context).command, self.guard)
        output.SetAtIndex(0, float(status))

    def _calc_gate_status(self, context: Any, output: Any) -> None:
        output.SetAtIndex(0, float(self._next(context)[1].status))

    def _calc_arming(self, context: Any, output: Any) -> None:
        output.SetAtIndex(0, float(self._next(context)[1].arming))

    def _calc_drag(self, context: Any, output: Any) -> None:
        armed = self._next(context)[1].arming == Arming.ARMED
        passed = self._said(context).dragged if armed else NOTHING
        output.SetFromVector(np.array(passed))

    def _keep(self, context: Any, state: Any) -> None:
        passed, after = self._next(context)
        state.get_mutable_vector().SetFromVector(np.array([*passed, *after]))
