"""A choice between controllers that stand side by side, changed without a jump."""

import dataclasses as dc
from typing import Any, NamedTuple

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import InputPortIndex, LeafSystem

from drake_mobman import signals
from drake_mobman.parameters import Range, checked, checked_period, within
from drake_mobman.scalars import Scalar, nearer_to_rest, smoothstep
from drake_mobman.teleop.live import SIZE, OperatorSample


class Handover(NamedTuple):
    """The signal `handover`: who drove, who is to, and how far that has come."""

    before: int = 0
    now: int = 0
    weight: float = 1.0  # Of who is to drive; 0 at the change, 1 when it is done.


@dc.dataclass
class Transition:
    """How one controller takes over from another."""

    duration: float = 0.5  # [s].

    def check(self) -> None:
        """Raises `ParameterError` unless the duration is one."""
        within(self, Range(1e-6, 60.0, "s"), "duration")


def next_handover(last: Handover, choice: float, count: int, step: float) -> Handover:
    """Returns the handover one period on.

    A change waits until the one before it is done; a choice of nobody who is there, or
    that is no number, changes nothing.

    Args:
        last: the handover now.
        choice: index of who is to drive.
        count: how many there are to choose from.
        step: by which the weight grows in a period.
    """
    if last.weight < 1:
        return last._replace(weight=1.0 - nearer_to_rest(1.0 - last.weight, step))
    if choice != last.now and choice in range(count):
        return Handover(before=last.now, now=int(choice), weight=0.0)
    return last._replace(before=last.now)


def faded(before: Scalar, now: Scalar, weight: float) -> Scalar:
    """Returns what is between two values: the first at 0, and smoothly the second at 1.

    Never outside of the two: where both are at rest, so is what is between. And what
    two splits of a command sum up to, this one does.
    """
    s = smoothstep(weight, 0.0, 1.0)
    return before + s * (now - before)


class ControllerSelector(LeafSystem):
    """Turns the operator's choice into selectors of two `PortSwitch`es and a weight.

    .. pydrake_system::

        name: ControllerSelector
        input_ports:
        - operator_input
        output_ports:
        - handover
        - before
        - now

    `before` and `now` are `InputPortIndex`es of the controller that drove and of the
    one that is to drive, port 1 for the first of them, as a `PortSwitch` takes them.

    Args:
        count: how many there are to choose from.
        change: how one takes over from another.
        period: control period [s].

    Raises:
        ParameterError: where a parameter is not valid.
    """

    def __init__(self, count: int, change: Transition, period: float) -> None:
        super().__init__()
        self.count = count
        self.step = checked_period(period) / checked(change).duration
        self.said = self.DeclareVectorInputPort(signals.OPERATOR_INPUT, SIZE)
        state = self.DeclareDiscreteState(np.array(Handover(), dtype=float))
        self.DeclareStateOutputPort(signals.HANDOVER, state)
        for i, name in enumerate(("before", "now")):
            self.DeclareAbstractOutputPort(
                name,
                lambda: Value[InputPortIndex](InputPortIndex(1)),
                self._calc_selector(i),
                prerequisites_of_calc={self.xd_ticket()},
            )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._go_on)

    @staticmethod
    def _calc_selector(i: int) -> Any:
        def calc(context: Any, output: Any) -> None:
            index = int(context.get_discrete_state_vector().GetAtIndex(i))
            output.set_value(InputPortIndex(1 + index))

        return calc

    def _go_on(self, context: Any, state: Any) -> None:
        before, now, weight = context.get_discrete_state_vector().value()
        last = Handover(int(before), int(now), float(weight))
        choice = OperatorSample(*self.said.Eval(context)).choice
        after = next_handover(last, choice, self.count, self.step)
        state.get_mutable_vector().SetFromVector(np.array(after, dtype=float))


class CrossFade(LeafSystem):
    """Puts out what is between two signals, by the handover's weight.

    .. pydrake_system::

        name: CrossFade
        input_ports:
        - handover
        - before
        - now
        output_ports:
        - value

    Done, it asks for `now` alone, and puts it out bit for bit.

    Args:
        size: of the signal.
    """

    def __init__(self, size: int) -> None:
        super().__init__()
        self.handover = self.DeclareVectorInputPort(signals.HANDOVER, 3)
        self.before = self.DeclareVectorInputPort("before", size)
        self.now = self.DeclareVectorInputPort("now", size)
        self.DeclareVectorOutputPort(
            "value",
            size,
            self._calc,
            prerequisites_of_calc={self.all_input_ports_ticket()},
        )

    def _calc(self, context: Any, output: Any) -> None:
        weight = self.handover.Eval(context)[2]
        value = self.now.Eval(context)
        if weight < 1:
            value = faded(self.before.Eval(context), value, weight)
        output.SetFromVector(value)
