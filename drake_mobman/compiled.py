"""Blocks compiled: their laws as Drake's own expressions, evaluated without Python.

A block is evaluated once on `Expression`s; what comes out is put in a
`SymbolicVectorSystem` for each output port, behind ports of the same names.
"""

from typing import Any

import numpy as np
from pydrake.symbolic import MakeVectorVariable
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import Multiplexer, PassThrough, SymbolicVectorSystem

_LONGEST = 10_000
"""Of an output's law, in characters. An expression repeats what it uses twice; a longer
one takes more time to evaluate than the block in Python."""


def compiled(block: Any) -> Any:
    """Returns a block that does as `block` does, without Python where that goes.

    Its ports have the same names and sizes. What it puts out is the same up to the
    rounding of a handful of operations, as expressions are simplified. An output that
    takes no Expressions, as where a `MultibodyPlant` is asked, or whose expressions are
    too long to gain by it, is left to the block itself; a block of which that is all is
    returned as it is.

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
        self.outputs: dict[str, Any] = {}
        for i in range(block.num_output_ports()):
            port = symbolic.get_output_port(i)
            try:
                law = port.Eval(context)
            except (AttributeError, RuntimeError, TypeError):
                continue  # It asks a model that takes no expressions.
            if sum(len(str(e)) for e in law) <= _LONGEST:
                self.outputs[port.get_name()] = law


class _Compiled(Diagram):
    """A block's laws, in a system for each output; the block itself for the rest."""

    def __init__(self, block: Any, laws: _Laws) -> None:
        super().__init__()
        builder = DiagramBuilder()
        takers: dict[str, list[Any]] = {name: [] for name in laws.inputs}
        state: list[Any] = []
        if laws.update:
            keep = {"state": laws.state, "dynamics": laws.update}
            keep["time_period"] = block.period
            told = _taken(laws.update, laws.inputs)
            values = [1 * x for x in laws.state]
            port = _add_system(builder, values, told, takers, [], **keep)
            state = [(laws.state, port)]
        ports = {}
        for name, law in laws.outputs.items():
            told = _taken(law, laws.inputs)
            mine = [pair for pair in state if _taken(law, {"state": pair[0]})]
            ports[name] = _add_system(builder, list(law), told, takers, mine)
        names = [p.get_name() for p in map(block.get_output_port, _of(block))]
        if len(ports) < len(names):
            rest = builder.AddNamedSystem("rest", block)
            for name, ends in takers.items():
                ends.append(rest.GetInputPort(name))
            ports = {name: rest.GetOutputPort(name) for name in names} | ports
        for name in names:
            builder.ExportOutput(ports[name], name)
        for name, ends in takers.items():
            if not ends:  # The law has no use for it, but the port is there.
                idle = builder.AddSystem(PassThrough(len(laws.inputs[name])))
                ends.append(idle.get_input_port())
            builder.ExportInput(ends[0], name)
            for end in ends[1:]:
                builder.ConnectInput(name, end)
        builder.BuildInto(self)


def _of(block: Any) -> range:
    return range(block.num_output_ports())


def _taken(law: Any, vectors: dict[str, Any]) -> dict[str, Any]:
    """Returns those of the vectors of variables that the expressions take."""
    ids = {v.get_id() for e in law for v in e.GetVariables()}
    return {
        name: vector
        for name, vector in vectors.items()
        if any(v.get_id() in ids for v in vector)
    }


def _add_system(
    builder: DiagramBuilder,
    law: list[Any],
    told: dict[str, Any],
    takers: dict[str, list[Any]],
    kept: list[Any],
    **keep: Any,
) -> Any:
    """Adds a system of expressions, fed with just what they take; returns its output.

    Args:
        builder: to add to.
        law: what it puts out.
        told: the inputs that it takes, by name.
        takers: to which it adds the ports that take them.
        kept: the block's state and the port that puts it out, where the law takes it.
        keep: state and dynamics of the system itself.
    """
    vectors = [*told.values(), *(vector for vector, _ in kept)]
    every = np.concatenate(vectors) if vectors else np.zeros(0, dtype=object)
    system = builder.AddSystem(SymbolicVectorSystem(input=every, output=law, **keep))
    if len(vectors) > 1:
        mux = builder.AddSystem(Multiplexer([len(vector) for vector in vectors]))
        builder.Connect(mux.get_output_port(), system.get_input_port())
        ends = [mux.get_input_port(i) for i in range(len(vectors))]
    else:
        ends = [system.get_input_port(i) for i in range(len(vectors))]
    for name, end in zip(told, ends, strict=False):
        takers[name].append(end)
    for (_, port), end in zip(kept, ends[len(told) :], strict=True):
        builder.Connect(port, end)
    return system.get_output_port()
