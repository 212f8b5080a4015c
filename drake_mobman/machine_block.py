"""Blocks whose laws are machine code: only ports and state are left to Python."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_mobman.blocks import Cached, cached, tickets
from drake_mobman.machine_code import Function, MachineCode
from drake_mobman.scalars import Scalar
from drake_mobman.tracing import Trace, variables_of


class Laws:
    """A block's laws, as expressions of its inputs and its state.

    Attributes:
        inputs: variables of each input port, by its name.
        state: variables of the discrete state, counted from where it starts.
        start: the state at which a context starts.
        trace: what the laws have named.
        outputs: expressions of each output port, by its name.
        update: of the state after a period; empty without a state.
        initialization: of the state when a simulation starts; empty without one.
    """

    inputs: Mapping[str, Any]
    state: Any
    start: Any
    trace: Trace
    outputs: Mapping[str, Sequence[Scalar]]
    update: Sequence[Scalar]
    initialization: Sequence[Scalar]


class MachineBlock(LeafSystem):
    """A block's laws as machine code, behind ports of the same names, for floats.

    Outputs that depend on the same inputs are worked out together.

    Args:
        laws: of the block, all its outputs among them.
        period: of its update [s].
    """

    def __init__(self, laws: Laws, period: float | None) -> None:
        super().__init__()
        self._laws, self._start = laws, np.array(laws.start)
        for name, variables in laws.inputs.items():
            self.DeclareVectorInputPort(name, len(variables))
        if len(self._start):
            self.DeclareDiscreteState(self._start)
        alike = _outputs_alike(laws)
        every = [x for variables in laws.inputs.values() for x in variables]
        code = MachineCode(
            [*laws.state, *every],
            laws.trace,
            [
                *(
                    [x for name in names for x in laws.outputs[name]]
                    for _, names in alike
                ),
                laws.update,
                laws.initialization,
            ],
        )
        self._code = code
        *outputs, update, initialization = code.laws
        values: dict[str, tuple[Cached[Any], slice]] = {}
        for (needs, names), law in zip(alike, outputs, strict=True):
            values |= self._worked_out(needs, names, law)
        for name, results in laws.outputs.items():
            self._declare_output(name, len(results), *values[name])
        if laws.update:
            step = self._step(update)
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, step)
        if laws.initialization:
            self.DeclareInitializationDiscreteUpdateEvent(self._step(initialization))

    def _worked_out(
        self, needs: frozenset[str], names: Sequence[str], law: Function
    ) -> dict[str, tuple[Cached[Any], slice]]:
        """Declares some outputs' values in the cache; returns where each of them is."""
        ports = [self.GetInputPort(name) for name in needs]
        depends = tickets(self, *ports)
        if len(self._start):
            depends.add(self.xd_ticket())
        calculate = self._calculation(law, needs)
        values = cached(self, calculate, depends)
        ends = np.cumsum([0, *(len(self._laws.outputs[name]) for name in names)])
        parts = map(slice, ends[:-1].tolist(), ends[1:].tolist())
        return {name: (values, part) for name, part in zip(names, parts, strict=True)}

    def _declare_output(
        self, name: str, size: int, values: Cached[Any], part: slice
    ) -> None:
        def calc(context: Any, output: Any) -> None:
            output.SetFromVector(values(context)[part])

        needs = {values.ticket}
        self.DeclareVectorOutputPort(name, size, calc, prerequisites_of_calc=needs)

    def _step(self, law: Function) -> Any:
        """Returns what sets the state by a law."""
        calculate = self._calculation(law, frozenset(self._laws.inputs))

        def step(context: Any, state: Any) -> None:
            after = self._start + calculate(context)
            state.get_mutable_vector().SetFromVector(after)

        return step

    def _calculation(self, law: Function, needs: frozenset[str]) -> Any:
        """Returns what works out a law of some inputs in a context."""
        start = self._start.tolist()
        # Inputs that it does not need are not asked for, and are zero.
        read = [
            (self.GetInputPort(name).Eval if name in needs else None, [0.0] * len(x))
            for name, x in self._laws.inputs.items()
        ]

        def calculate(context: Any) -> Any:
            numbers: list[float] = []
            if start:
                state = context.get_discrete_state_vector().value().tolist()
                numbers += [x - y for x, y in zip(state, start, strict=True)]
            for evaluate, zeros in read:
                numbers += evaluate(context).tolist() if evaluate else zeros
            return np.frombuffer(law(numbers))

        return calculate


def _outputs_alike(laws: Laws) -> list[tuple[frozenset[str], list[str]]]:
    """Returns the outputs in groups, each with the inputs that all of it needs."""
    needed = _inputs_needed(laws)
    alike: dict[frozenset[str], list[str]] = {}
    for name, law in laws.outputs.items():
        needs = frozenset[str]().union(*map(needed, law))
        alike.setdefault(needs, []).append(name)
    return list(alike.items())


def _inputs_needed(laws: Laws) -> Any:
    """Returns a function that names the inputs that an expression depends on."""
    by_id = {
        x.get_id(): frozenset({name}) for name, xs in laws.inputs.items() for x in xs
    }

    def needed(law: Scalar) -> frozenset[str]:
        return frozenset[str]().union(
            *(by_id.get(x.get_id(), frozenset()) for x in variables_of(law))
        )

    for name, law in zip(laws.trace.variables, laws.trace.laws, strict=True):
        by_id[name.get_id()] = needed(law)
    return needed
