"""A choice between controllers that run side by side, changed without a jump."""

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
    """The signal `handover`, component by component."""

    before: int = 0  # Index of the controller that drove.
    now: int = 0  # Index of the controller that takes over.
    weight: float = 1.0  # Of the latter: 0 at the start of the transition, 1 after it.


@dc.dataclass
class Transition:
    """How one controller takes over from another."""

    duration: float = 0.5  # [s].

    def check(self) -> None:
        """Raises `ParameterError` unless the duration is in range."""
        within(self, Range(1e-6, 60.0, "s"), "duration")


def next_handover(last: Handover, choice: float, count: int, step: float) -> Handover:
    """Returns the handover one period on.

    A choice waits until the transition before it is done. One that is not the index of
    a controller changes nothing.

    Args:
        last: the handover now.
        choice: index of the controller that the operator chooses.
        count: number of controllers.
        step: by which the weight grows in a period.
    """
    if last.weight < 1:
        return last._replace(weight=1.0 - nearer_to_rest(1.0 - last.weight, step))
    if choice != last.now and choice in range(count):
        return Handover(before=last.now, now=int(choice), weight=0.0)
    return last._replace(before=last.now)


def faded(before: Scalar, now: Scalar, weight: float) -> Scalar:
    """Returns a value between two: the first at weight 0, smoothly the second at 1.

    It is never outside of the two: where both are 0, so is it. And if the parts for
    base and arm add up to the command before and now, their cross-fades do too.
    """
    s = smoothstep(weight, 0.0, 1.0)
    return before + s * (now - before)


class ControllerSelector(LeafSystem):
    """Turns the operator's choice into two port selectors and a weight.

    .. pydrake_system::

        name: ControllerSelector
        input_ports:
        - operator_input
        output_ports:
        - handover
        - before
        - now

    `before` and `now` are `InputPortIndex`es for a `PortSwitch`, of the controller that
    drove and of the one that takes over. The first controller has port 1.

    Args:
        count: number of controllers.
        transition: how one takes over from another.
        period: control period [s].

    Raises:
        ParameterError: where a parameter is not valid.
    """

    def __init__(self, count: int, transition: Transition, period: float) -> None:
        super().__init__()
        self.count = count
        self.step = checked_period(period) / checked(transition).duration
        self.input = self.DeclareVectorInputPort(signals.OPERATOR_INPUT, SIZE)
        state = self.DeclareDiscreteState(np.array(Handover(), dtype=float))
        self.DeclareStateOutputPort(signals.HANDOVER, state)
        for i, name in enumerate(("before", "now")):
            self.DeclareAbstractOutputPort(
                name,
                lambda: Value[InputPortIndex](InputPortIndex(1)),
                self._calc_selector(i),
                prerequisites_of_calc={self.xd_ticket()},
            )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._advance)

    @staticmethod
    def _calc_selector(i: int) -> Any:
        def calc(context: Any, output: Any) -> None:
            index = int(context.get_discrete_state_vector().GetAtIndex(i))
            output.set_value(InputPortIndex(1 + index))

        return calc

    def _advance(self, context: Any, state: Any) -> None:
        before, now, weight = context.get_discrete_state_vector().value()
        last = Handover(int(before), int(now), float(weight))
        choice = OperatorSample(*self.input.Eval(context)).choice
        after = next_handover(last, choice, self.count, self.step)
        state.get_mutable_vector().SetFromVector(np.array(after, dtype=float))


class CrossFade(LeafSystem):
    """Fades from one signal to another, by the weight of the handover.

    .. pydrake_system::

        name: CrossFade
        input_ports:
        - handover
        - before
        - now
        output_ports:
        - value

    After the transition, it evaluates `now` only, and passes it bit for bit.

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
