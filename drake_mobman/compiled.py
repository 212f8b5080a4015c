"""Blocks compiled: their laws as Drake's own expressions, evaluated without Python.

A block is evaluated once on `Expression`s; what comes out is put in a
`SymbolicVectorSystem` for each output port, behind ports of the same names, and what
these have in common in systems before them.
"""

from collections.abc import Hashable, Iterable, Mapping
from typing import Any

import numpy as np
from pydrake.symbolic import MakeVectorVariable
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import (
    Demultiplexer,
    Multiplexer,
    PassThrough,
    SymbolicVectorSystem,
)

from drake_mobman.subexpressions import Named, with_names


def compiled(block: Any) -> Any:
    """Returns a block that does as `block` does, without Python where that goes.

    Its ports have the same names and sizes. What it puts out is the same up to the
    rounding of a handful of operations, as expressions are simplified. An output that
    takes no Expressions, as where a `MultibodyPlant` is asked, is left to the block
    itself; a block of which that is all is returned as it is.

    Args:
        block: a `LeafSystem` of vector ports; its state, if any, is one discrete vector
            that is updated every `block.period` [s].
    """
    try:
        # Numpy warns of expressions, as it takes them for numbers that are none.
        with np.errstate(invalid="ignore"):
            laws = _Laws(block)
    except (AttributeError, RuntimeError, TypeError):
        return block  # It has no conversion to Expression, or its update takes none.
    return _Compiled(block, laws) if laws.outputs else block


class _Laws:
    """A block's outputs and update as expressions of its inputs and its state."""

    def __init__(self, block: Any) -> None:
        symbolic = block.ToSymbolic()
        context = symbolic.CreateDefaultContext()
        self.inputs: dict[str, Any] = {}
        for i in range(block.num_input_ports()):
            port = symbolic.get_input_port(i)
            variables = MakeVectorVariable(port.size(), f"u{i}_")
            self.inputs[port.get_name()] = variables
            port.FixValue(context, 1 * variables)
        start = block.CreateDefaultContext().get_discrete_state()
        start = start.value() if start.num_groups() else np.zeros(0)
        self.state = MakeVectorVariable(len(start), "x")
        self.update: list[Any] = []
        if len(start):
            # Counted from the start: a SymbolicVectorSystem starts at zero.
            context.SetDiscreteState(self.state + start)
            after = symbolic.EvalUniquePeriodicDiscreteUpdate(context).value()
            self.update = list(after - start)
        self.outputs: dict[str, list[Any]] = {}
        for i in range(block.num_output_ports()):
            port = symbolic.get_output_port(i)
            try:
                self.outputs[port.get_name()] = list(port.Eval(context))
            except (AttributeError, RuntimeError, TypeError):
                continue  # It asks a model that takes no expressions.

        taken = [set(_taken(law, self.inputs)) for law in self.outputs.values()]
        # What one output takes and another one does not.
        self.optional = set().union(*taken) - set(self.inputs).intersection(*taken)

    def outputs_alike(self) -> list[list[str]]:
        """Returns the outputs that one system can put out together."""
        alike: dict[Hashable, list[str]] = {}
        for name, law in self.outputs.items():
            takes = self.optional.intersection(_taken(law, self.inputs))
            alike.setdefault(frozenset(takes), []).append(name)
        return list(alike.values())

    def with_names(self) -> tuple[list[Any], dict[str, list[Any]], list[Named]]:
        """Returns update and outputs, and what they have in common."""
        every = [self.update, *self.outputs.values()]
        names, flat = with_names([e for law in every for e in law])
        rest = iter(flat)
        update, *outputs = ([next(rest) for _ in law] for law in every)
        return update, dict(zip(self.outputs, outputs, strict=True)), names


_STATE = "the state"
"""Stands among the names of the inputs, which have no spaces."""


class _Compiled(Diagram):
    """A block's laws, in a system for each output; the block itself for the rest."""

    def __init__(self, block: Any, laws: _Laws) -> None:
        super().__init__()
        builder = DiagramBuilder()
        update, outputs, names = laws.with_names()
        groups = _grouped(names, laws)

        # A vector of variables under a key, and, but for the inputs, who puts it out.
        vectors: dict[Hashable, Any] = dict(laws.inputs)
        sources: dict[Hashable, Any] = {}
        wires: list[tuple[Any, Hashable]] = []
        if update:
            vectors[_STATE] = laws.state
        vectors |= {key: [n.variable for n in group] for key, group in groups.items()}

        def add(law: list[Any], **keep: Any) -> Any:
            takes = _taken([*law, *keep.get("dynamics", [])], vectors)
            if keep:
                takes.pop(_STATE, None)
            every = np.concatenate([*takes.values(), []]).astype(object)
            system = SymbolicVectorSystem(input=every, output=law, **keep)
            builder.AddSystem(system)
            ends = [system.get_input_port(i) for i in range(min(1, len(takes)))]
            if len(takes) > 1:
                mux = builder.AddSystem(Multiplexer([len(v) for v in takes.values()]))
                builder.Connect(mux.get_output_port(), ends[0])
                ends = [mux.get_input_port(i) for i in range(len(takes))]
            wires.extend(zip(ends, takes, strict=True))
            return system.get_output_port()

        if update:
            kept = {"state": laws.state, "dynamics": update}
            kept["time_period"] = block.period
            sources[_STATE] = add([1 * x for x in laws.state], **kept)
        for key, group in groups.items():
            sources[key] = add([named.law for named in group])
        ports = {}
        for alike in laws.outputs_alike():
            split = Demultiplexer([len(outputs[name]) for name in alike])
            builder.AddSystem(split)
            port = add([e for name in alike for e in outputs[name]])
            builder.Connect(port, split.get_input_port())
            for i, name in enumerate(alike):
                ports[name] = split.get_output_port(i)

        order = [block.get_output_port(i) for i in range(block.num_output_ports())]
        if len(ports) < len(order):
            rest = builder.AddNamedSystem("rest", block)
            wires += [(rest.GetInputPort(name), name) for name in laws.inputs]
            ports = {p.get_name(): rest.GetOutputPort(p.get_name()) for p in order} | (
                ports
            )
        for port in order:
            builder.ExportOutput(ports[port.get_name()], port.get_name())
        for name, variables in laws.inputs.items():
            ends = [end for end, key in wires if key == name]
            if not ends:  # The law has no use for it, but the port is there.
                idle = builder.AddSystem(PassThrough(len(variables)))
                ends = [idle.get_input_port()]
            builder.ExportInput(ends[0], name)
            for end in ends[1:]:
                builder.ConnectInput(name, end)
        for end, key in wires:
            if key in sources:
                builder.Connect(sources[key], end)
        builder.BuildInto(self)


def _taken(law: Iterable[Any], vectors: Mapping[Any, Any]) -> dict[Any, Any]:
    """Returns those of the vectors of variables that the expressions take."""
    ids = {v.get_id() for e in law for v in e.GetVariables()}
    return {
        key: vector
        for key, vector in vectors.items()
        if any(v.get_id() in ids for v in vector)
    }


def _grouped(names: list[Named], laws: _Laws) -> dict[Hashable, list[Named]]:
    """Returns the names that one system can put out together, in order.

    Those of one level that need the same optional inputs: with others, an output would
    seem to depend on what it does not, and a loop of blocks on itself.
    """
    needs = {
        v.get_id(): frozenset({name} & laws.optional)
        for name, vector in laws.inputs.items()
        for v in vector
    }
    groups: dict[Hashable, list[Named]] = {}
    for named in names:
        takes = [needs.get(v.get_id(), frozenset()) for v in named.law.GetVariables()]
        mine = needs[named.variable.get_id()] = frozenset[str]().union(*takes)
        groups.setdefault((named.level, mine), []).append(named)
    return groups
