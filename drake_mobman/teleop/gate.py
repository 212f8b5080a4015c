"""The command gate: nothing moves unless an operator is there and wants it to.

A live command comes over a link that may freeze, break or send wrong data. The gate is
the last block before the controllers, and all that it knows comes by `operator_input`.
"""

import dataclasses as dc
import enum
import math
from typing import Any, NamedTuple

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_mobman import signals
from drake_mobman.blocks import tickets
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
    clamped,
    command_status,
)
from drake_mobman.teleop.live import SIZE, OperatorSample


class GateStatus(enum.IntEnum):
    """Why the robot is held still; it has the values of `GuardStatus`."""

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
    """The last input of the operator is too old."""
    STOPPED = 6
    """Someone asked for a stop."""
    GONE = 7
    """There is no operator any more: handed over, left, or disconnected."""
    ASTRAY = 8
    """The base has not moved as it was sent for too long."""


class Arming(enum.IntEnum):
    """How far the operator has come in arming."""

    LATCHED = 0
    """Waits for a neutral stick, with the dead-man let go."""
    READY = 1
    """Both were so a period ago: a press of the dead-man arms."""
    ARMED = 2
    """Commands pass."""


@dc.dataclass
class Gate:
    """What shows that an operator is there."""

    fresh: float = 0.25  # Largest age of a command [s].
    neutral: float = 0.05  # Largest neutral command, as a share of the largest.

    def check(self) -> None:
        """Raises `ParameterError` unless both are in range."""
        within(self, Range(1e-3, 60.0, "s"), "fresh")
        if not 0 <= self.neutral < 1:
            raise ParameterError("neutral", self.neutral, "must be within [0, 1)")


class GateState(NamedTuple):
    """Whether commands pass, and why not."""

    arming: Arming = Arming.LATCHED
    status: GateStatus = GateStatus.NOT_ARMED


def input_status(
    sample: OperatorSample,
    gate: Gate,
    guard: Guard,
    draggable: Draggable = NO_BODY,
    astray: float = 0.0,
) -> GateStatus:
    """Returns why the operator's input may not pass, the gravest reason, or OK."""
    # In these comparisons, a NaN never counts as held, as fresh, or as no stop.
    if sample.stop != 0:
        return GateStatus.STOPPED
    if astray != 0:
        return GateStatus.ASTRAY
    if sample.age == math.inf:
        return GateStatus.GONE
    if not 0 <= sample.age <= gate.fresh:
        return GateStatus.STALE
    reasons = (
        command_status(sample.command, guard),
        drag_status(sample.dragged, draggable),
    )
    for grave in (GuardStatus.NOT_FINITE, GuardStatus.OVER_RANGE):
        if grave in reasons:
            return GateStatus(int(grave))
    return GateStatus.OK if sample.dead_man > 0.5 else GateStatus.RELEASED


def is_at_rest(sample: OperatorSample, gate: Gate, guard: Guard) -> bool:
    """Returns whether an operator is there, and neither presses nor commands."""
    # Without a draggable body: to drag is to command.
    released = input_status(sample, gate, guard) == GateStatus.RELEASED
    return released and all(
        abs(c) <= gate.neutral * most
        for c, most in zip(sample.command, guard.largest, strict=True)
    )


def next_state(
    last: GateState,
    sample: OperatorSample,
    gate: Gate,
    guard: Guard,
    draggable: Draggable = NO_BODY,
    astray: float = 0.0,
) -> GateState:
    """Returns the gate's state one period on.

    The reason of a stop stays until the gate is armed again. Only two others replace
    it: a stop that anyone asks for, and a press of the dead-man that does not arm.

    Args:
        last: the state before.
        sample: the operator's input.
        gate: what shows that an operator is there.
        guard: what a command may be.
        draggable: which bodies may be dragged.
        astray: `base_astray`.
    """
    status = input_status(sample, gate, guard, draggable, astray)
    if status == GateStatus.OK and last.arming != Arming.LATCHED:
        return GateState(Arming.ARMED, GateStatus.OK)
    if is_at_rest(sample, gate, guard) and last.arming != Arming.ARMED:
        return GateState(Arming.READY, last.status)
    pressed = last.arming == Arming.READY and sample.dead_man > 0.5
    stopped = status == GateStatus.STOPPED
    is_new = last.arming == Arming.ARMED or pressed or stopped
    return GateState(Arming.LATCHED, status if is_new else last.status)


class CommandGate(LeafSystem):
    """Passes the commands of an armed operator, and brakes to rest otherwise.

    .. pydrake_system::

        name: CommandGate
        input_ports:
        - operator_input
        - base_astray (where it is watched)
        output_ports:
        - ee_command
        - guard_status
        - gate_status
        - gate_arming
        - drag (where anything may be dragged)

    A command passes, bit for bit, if the operator has armed the gate and the command is
    fresh, finite and in range. The first that is not becomes a stop from the command
    last passed, within the guard's `stop_time`, and latches the reason. To arm again,
    the operator lets go of dead-man and stick, and then presses the dead-man anew.
    `guard_status` is that of the input, as a `CommandGuard` has it. A drag passes as a
    command does; with the first that may not pass, the point is let go.

    The state is the command last passed, `Arming` and `GateStatus`. The gate has no
    clock: whoever receives a command measures its age, which is data here.

    Args:
        params: what shows that an operator is there.
        guard: what a command may be, and how it is stopped.
        period: control period [s].
        draggable: which bodies may be dragged.
        watched: whether an estimator tells where the base is astray.

    Raises:
        ParameterError: where a parameter is not valid.
    """

    def __init__(
        self,
        params: Gate,
        guard: Guard,
        period: float,
        draggable: Draggable = NO_BODY,
        *,
        watched: bool = False,
    ) -> None:
        super().__init__()
        self.params = checked(params)
        self.guard = checked(guard)
        self.period = checked_period(period)
        self.draggable = draggable
        checked(draggable.params)
        self.input = self.DeclareVectorInputPort(signals.OPERATOR_INPUT, SIZE)
        given = tickets(self, self.input)
        both = given | {self.xd_ticket()}
        self.astray: Any = None
        if watched:
            self.astray = self.DeclareVectorInputPort(signals.BASE_ASTRAY, 1)
            both |= tickets(self, self.astray)
        ports = [
            (signals.EE_COMMAND, 3, self._calc_passed, both),
            (signals.GUARD_STATUS, 1, self._calc_guard_status, given),
            (signals.GATE_STATUS, 1, self._calc_gate_status, both),
            (signals.GATE_ARMING, 1, self._calc_arming, both),
        ]
        if draggable.bodies:
            ports.append((signals.DRAG, len(NOTHING), self._calc_drag, both))
        for name, size, calc, needs in ports:
            self.DeclareVectorOutputPort(name, size, calc, prerequisites_of_calc=needs)
        self.DeclareDiscreteState(np.array([0.0, 0.0, 0.0, *GateState()]))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._keep)

    def _sample(self, context: Any) -> OperatorSample:
        return OperatorSample(*self.input.Eval(context).tolist())

    def _next(self, context: Any) -> tuple[list[float], GateState]:
        """Returns the command that passes, and the state after it."""
        sample = self._sample(context)
        *passed, arming, status = context.get_discrete_state_vector().value()
        last = GateState(Arming(int(arming)), GateStatus(int(status)))
        astray = self.astray.Eval(context)[0] if self.astray is not None else 0.0
        state = next_state(
            last, sample, self.params, self.guard, self.draggable, astray
        )
        if state.arming == Arming.ARMED:
            return clamped(sample.command, self.guard), state
        return braked(passed, self.guard, self.period), state

    def _calc_passed(self, context: Any, output: Any) -> None:
        output.SetFromVector(np.array(self._next(context)[0]))

    def _calc_guard_status(self, context: Any, output: Any) -> None:
        status = command_status(self._sample(context).command, self.guard)
        output.SetAtIndex(0, float(status))

    def _calc_gate_status(self, context: Any, output: Any) -> None:
        output.SetAtIndex(0, float(self._next(context)[1].status))

    def _calc_arming(self, context: Any, output: Any) -> None:
        output.SetAtIndex(0, float(self._next(context)[1].arming))

    def _calc_drag(self, context: Any, output: Any) -> None:
        armed = self._next(context)[1].arming == Arming.ARMED
        passed = self._sample(context).dragged if armed else NOTHING
        output.SetFromVector(np.array(passed))

    def _keep(self, context: Any, state: Any) -> None:
        passed, after = self._next(context)
        state.get_mutable_vector().SetFromVector(np.array([*passed, *after]))
