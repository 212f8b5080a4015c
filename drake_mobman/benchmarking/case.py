"""What is timed of a decomposer: its law by itself, or its block in a diagram."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from pydrake.systems.framework import DiagramBuilder

from drake_mobman import signals
from drake_mobman.benchmarking.ticks import Tick


class BenchmarkCase:
    """Something that is called once a tick.

    `act` alone is timed, between `prepare` and `settle`.
    """

    def prepare(self, tick: Any) -> None:
        """Takes the inputs of a tick."""
        raise NotImplementedError

    def act(self) -> Any:
        """Returns the outputs; None where no solution was found."""
        raise NotImplementedError

    def settle(self) -> None:
        """Updates the state for the next tick."""


class Law(BenchmarkCase):
    """A function of the four inputs, given as lists of floats."""

    def __init__(self, law: Callable[..., Any]) -> None:
        self._law = law
        self._inputs: tuple[list[float], ...] = ()

    def prepare(self, tick: Tick) -> None:
        """Turns the arrays into lists."""
        self._inputs = tuple(value.tolist() for value in tick)

    def act(self) -> tuple[float, ...]:
        """Returns `base_command` and `arm_command` (5,)."""
        return self._law(*self._inputs)


class Block(BenchmarkCase):
    """A block in a diagram of its own.

    Args:
        block: or a diagram of several.
        inputs: names of all its inputs, in the order of a tick.
        outputs: names of those that are evaluated.
    """

    def __init__(
        self,
        block: Any,
        inputs: Sequence[str] = Tick._fields,
        outputs: Sequence[str] = (signals.BASE_COMMAND, signals.ARM_COMMAND),
    ) -> None:
        builder = DiagramBuilder()
        builder.AddSystem(block)
        for name in inputs:
            builder.ExportInput(block.GetInputPort(name), name)
        for name in outputs:
            builder.ExportOutput(block.GetOutputPort(name), name)
        self._diagram = builder.Build()
        self._context = self._diagram.CreateDefaultContext()
        self._inputs = [self._diagram.GetInputPort(name) for name in inputs]
        self._outputs = [self._diagram.GetOutputPort(name) for name in outputs]
        self._has_state = self._context.num_discrete_state_groups() > 0
        self._started = False

    def prepare(self, tick: Sequence[np.ndarray]) -> None:
        """Fixes all inputs to new values, so that no output is cached."""
        for port, value in zip(self._inputs, tick, strict=True):
            port.FixValue(self._context, value)
        if not self._started:
            self._diagram.ExecuteInitializationEvents(self._context)
            self._started = True

    def act(self) -> tuple[float, ...]:
        """Returns the outputs in a row."""
        base, arm = self._outputs
        return (*base.Eval(self._context), *arm.Eval(self._context))

    def settle(self) -> None:
        """Updates the block's state by a period."""
        if self._has_state:
            state = self._diagram.EvalUniquePeriodicDiscreteUpdate(self._context)
            self._context.get_mutable_discrete_state().SetFrom(state)
