"""Laws as machine code, in blocks of one input and one output, for floats."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_mobman.blocks import tickets
from drake_mobman.machine_code import Function


class MachineLaw(LeafSystem):
    """Puts out what a law makes of its input.

    Args:
        law: takes and returns numbers.
        num_inputs: numbers that it takes.
        num_outputs: numbers that it returns.
    """

    def __init__(self, law: Function, num_inputs: int, num_outputs: int) -> None:
        super().__init__()
        port = self.DeclareVectorInputPort("u", num_inputs)
        read = port.Eval

        def calc(context: Any, output: Any) -> None:
            output.SetFromVector(np.frombuffer(law(read(context).tolist())))

        # Not of time: else the value would be taken for outdated at each step.
        needs = tickets(self, port)
        self.DeclareVectorOutputPort(
            "y", num_outputs, calc, prerequisites_of_calc=needs
        )


class MachineState(LeafSystem):
    """Puts out a state that laws set from the state and the input.

    Args:
        size: of the state, which starts at zero.
        num_inputs: numbers in the input.
        update: takes state and input; returns the state after a period.
        initialization: takes them, and returns the state when a simulation starts.
        period: of the update [s].
    """

    def __init__(
        self,
        size: int,
        num_inputs: int,
        update: Function | None,
        initialization: Function | None,
        period: float,
    ) -> None:
        super().__init__()
        self._read = self.DeclareVectorInputPort("u", num_inputs).Eval
        self.DeclareStateOutputPort("y", self.DeclareDiscreteState(size))
        if update:
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._step(update))
        if initialization:
            self.DeclareInitializationDiscreteUpdateEvent(self._step(initialization))

    def _step(self, law: Function) -> Any:
        def step(context: Any, state: Any) -> None:
            last = context.get_discrete_state_vector().value().tolist()
            after = law(last + self._read(context).tolist())
            state.get_mutable_vector().SetFromVector(np.frombuffer(after))

        return step
