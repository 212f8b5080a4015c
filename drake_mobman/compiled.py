"""Compiled blocks: their laws as Drake's expressions, evaluated without Python.

A block is evaluated once on `Expression`s. The result goes into a
`SymbolicVectorSystem` for each output port, behind ports of the same names, and common
subexpressions go into systems before them. Laws that name what they work out, as those
of an arm by its Jacobian, are too long for that: they become machine code.
"""

from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np
from pydrake.symbolic import MakeVectorVariable, Variable
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import (
    PassThrough,
    Selector,
    SymbolicVectorSystem,
)

from drake_mobman.machine_block import MachineLaw, MachineState
from drake_mobman.machine_code import machine_code
from drake_mobman.parts import selection
from drake_mobman.subexpressions import Named, eliminate_common_subexpressions
from drake_mobman.tracing import Trace, tracing


def compiled(block: Any) -> Any:
    """Returns the same block, evaluated without Python where that is possible.

    Its ports have the same names and sizes. Its outputs are the same up to the rounding
    of a few operations, as Drake simplifies expressions. An output that cannot be
    evaluated on Expressions, because it uses a `MultibodyPlant`, is left to the block
    itself. A block with such outputs only is returned as it is.

    Args:
        block: a `LeafSystem` of vector ports; its state, if any, is one discrete vector
            that is updated every `block.period` [s].
    """
    try:
        # Numpy warns of expressions, as it takes them for invalid numbers.
        with np.errstate(invalid="ignore"), tracing() as trace:
            laws = _Laws(block, trace)
    except (AttributeError, RuntimeError, TypeError):
        return block  # It, or its update, does not work on Expressions.
    if trace.laws and laws.are_all:
        return _MachineCode(block, laws)
    return _Compiled(block, laws) if laws.outputs and not trace.laws else block


class _Laws:
    """A block's outputs and update as expressions of its inputs and its state."""

    def __init__(self, block: Any, trace: Trace) -> None:
        self.trace = trace
        symbolic = block.ToSymbolic()
        context = symbolic.CreateDefaultContext()
        self.time = Variable("t")
        context.SetTime(1 * self.time)
        self.inputs: dict[str, Any] = {}
        for i in range(block.num_input_ports()):
            port = symbolic.get_input_port(i)
            variables = MakeVectorVariable(port.size(), f"u{i}_")
            self.inputs[port.get_name()] = variables
            port.FixValue(context, 1 * variables)
        state = block.CreateDefaultContext().get_discrete_state()
        start = self.start = state.value() if state.num_groups() else np.zeros(0)
        self.state = MakeVectorVariable(len(start), "x")
        self.update: list[Any] = []
        self.initialization: list[Any] = []
        if len(start):
            # Counted from the start: a SymbolicVectorSystem starts at zero.
            context.SetDiscreteState(self.state + start)
            if _is_updated(block):
                after = symbolic.EvalUniquePeriodicDiscreteUpdate(context).value()
                self.update = list(after - start)
        self.outputs: dict[str, list[Any]] = {}
        for i in range(block.num_output_ports()):
            port = symbolic.get_output_port(i)
            try:
                self.outputs[port.get_name()] = list(port.Eval(context))
            except (AttributeError, RuntimeError, TypeError):
                continue  # It uses a model that takes no Expressions.

        self.are_all = len(self.outputs) == block.num_output_ports()
        if len(start):
            symbolic.ExecuteInitializationEvents(context)
            begun = context.get_discrete_state_vector().CopyToVector() - start
            same = zip(begun, self.state, strict=True)
            if not all(x.EqualTo(1 * v) for x, v in same):
                self.initialization = list(begun)
        used = [set(self._used(law)) for law in self.outputs.values()]
        # Inputs of some outputs, but not of all.
        self.optional = set().union(*used) - set(self.inputs).intersection(*used)

    def _used(self, law: Sequence[Any]) -> list[str]:
        """Returns the names of the inputs that expressions use."""
        ids = self.trace.ids(law)
        return [
            name
            for name, variables in self.inputs.items()
            if any(x.get_id() in ids for x in variables)
        ]

    def outputs_alike(self) -> list[list[str]]:
        """Returns the outputs in groups, each with the same optional inputs."""
        alike: dict[Hashable, list[str]] = {}
        for name, law in self.outputs.items():
            takes = self.optional.intersection(self._used(law))
            alike.setdefault(frozenset(takes), []).append(name)
        return list(alike.values())

    def eliminate_common_subexpressions(
        self,
    ) -> tuple[list[Any], dict[str, list[Any]], list[Named]]:
        """Returns update and outputs in terms of common subexpressions, and these."""
        every = [self.update, *self.outputs.values()]
        named, flat = eliminate_common_subexpressions([e for law in every for e in law])
        rest = iter(flat)
        update, *outputs = ([next(rest) for _ in law] for law in every)
        return update, dict(zip(self.outputs, outputs, strict=True)), named


_STATE = "the state"
"""A key beside the names of the inputs, which have no spaces."""


def _is_updated(block: Any) -> bool:
    """Returns whether a block has an update every period."""
    return bool(block.GetUniquePeriodicDiscreteUpdateAttribute())


class _Compiled(Diagram):
    """A block's laws, in systems of expressions; the block itself for the rest."""

    def __init__(self, block: Any, laws: _Laws) -> None:
        super().__init__()
        update, outputs, named = laws.eliminate_common_subexpressions()
        groups = _grouped(named, laws)
        vectors: dict[Any, Any] = dict(laws.inputs)
        if update:
            vectors[_STATE] = laws.state
        vectors |= {key: [n.variable for n in group] for key, group in groups.items()}
        systems = _Systems(vectors, laws)
        kept: dict[str, Any] = {}
        if update:
            kept = {"state": laws.state, "dynamics": update}
            kept["time_period"] = block.period
        if groups or len(outputs) != 1:
            # More than one system uses the state.
            if update:
                systems.add([1 * x for x in laws.state], _STATE, **kept)
            kept = {}
        for key, group in groups.items():
            systems.add([named.law for named in group], key)
        ports: dict[str, Any] = {}
        for alike in laws.outputs_alike():
            mine = {name: outputs[name] for name in alike}
            ports |= systems.add_split(mine, **kept)
        order = [block.get_output_port(i) for i in range(block.num_output_ports())]
        if len(ports) < len(order):
            ports = systems.add_block(block) | ports
        systems.connect(laws.inputs)
        for port in order:
            systems.export(ports[port.get_name()], port.get_name())
        systems.builder.BuildInto(self)


class _MachineCode(Diagram):
    """A block's laws, in systems of machine code."""

    def __init__(self, block: Any, laws: _Laws) -> None:
        super().__init__()
        vectors: dict[Any, Any] = dict(laws.inputs)
        if len(laws.state):
            vectors[_STATE] = laws.state
        systems = _Systems(vectors, laws)
        alike = laws.outputs_alike()
        results = [[x for name in names for x in laws.outputs[name]] for names in alike]
        picks = [systems.picked(law) for law in results]
        steps = laws.update, laws.initialization
        for_steps = systems.picked([*laws.update, *laws.initialization], but=_STATE)
        functions = machine_code(
            laws.trace,
            [
                *zip(map(systems.variables, picks), results, strict=True),
                *(
                    ([*laws.state, *systems.variables(for_steps)], step)
                    for step in steps
                ),
            ],
        )
        ports: dict[str, Any] = {}
        for names, pick, law, found in zip(
            alike, picks, functions, results, strict=False
        ):
            system = MachineLaw(law, len(systems.variables(pick)), len(found))
            port = systems.add_fed(system, pick)
            ports |= systems.split(port, {name: laws.outputs[name] for name in names})
        if len(laws.state):
            systems.add_fed(
                MachineState(
                    len(laws.state),
                    len(systems.variables(for_steps)),
                    functions[-2] if laws.update else None,
                    functions[-1] if laws.initialization else None,
                    block.period,
                ),
                for_steps,
                _STATE,
            )
        systems.connect(laws.inputs)
        for i in range(block.num_output_ports()):
            name = block.get_output_port(i).get_name()
            systems.export(ports[name], name)
        systems.builder.BuildInto(self)


Pick = dict[Hashable, list[int]]
"""Indices of elements, by the key of their vector."""


class _Systems:
    """Systems of expressions, each connected only to what it uses.

    One `Selector` gives each of them the elements that it uses, and puts results
    together that are an output: each block costs time, and so does what a block does
    not use.
    """

    def __init__(self, vectors: Mapping[Hashable, Any], laws: _Laws) -> None:
        self.builder = DiagramBuilder()
        self._vectors = vectors
        self._time, self._trace = laws.time, laws.trace
        self._sources: dict[Hashable, Any] = {}  # Output port of each vector.
        self._wires: list[
            tuple[Any, Hashable]
        ] = []  # Input ports, and the vector of each.
        self._parts: list[Pick] = []  # Outputs of the selector.
        self._ends: list[tuple[Any, int]] = []  # Input ports, and the part for each.
        self._selector: Any = None

    def add(self, law: list[Any], own: Hashable = None, **keep: Any) -> Any:
        """Adds a system; returns its output, which is the vector `own`, if given.

        Args:
            law: its output.
            own: key of the vector that this is.
            keep: state, dynamics and period of a system with a state.
        """
        every = [*law, *keep.get("dynamics", [])]
        if self._time.get_id() in self._trace.ids(every):
            keep["time"] = self._time
        pick = self.picked(every, but=_STATE if "state" in keep else None)
        inputs = self.variables(pick)
        system = SymbolicVectorSystem(input=inputs, output=law, **keep)
        return self.add_fed(system, pick, own)

    def picked(self, laws: list[Any], but: Hashable = None) -> Pick:
        """Returns the elements that laws depend on, but of one vector."""
        ids = self._trace.ids(laws)
        found = {
            key: [i for i, v in enumerate(vector) if v.get_id() in ids]
            for key, vector in self._vectors.items()
            if key != but
        }
        return {key: elements for key, elements in found.items() if elements}

    def variables(self, pick: Pick) -> list[Any]:
        """Returns the variables of elements."""
        return [
            self._vectors[key][i] for key, elements in pick.items() for i in elements
        ]

    def add_fed(self, system: Any, pick: Pick, own: Hashable = None) -> Any:
        """Adds a system whose input is some elements; as `add`."""
        self.builder.AddSystem(system)
        self._feed(system, pick)
        self._sources[own] = system.get_output_port()
        return system.get_output_port()

    def _feed(self, system: Any, chosen: Pick) -> None:
        """Connects a system only to the elements that it uses, as each costs time.

        Args:
            system: its input is these elements, one after the other.
            chosen: indices of the elements, by the key of their vector.
        """
        sizes = [len(self._vectors[key]) for key in chosen]
        if len(chosen) <= 1 and sizes == [len(e) for e in chosen.values()]:
            self._wires += [(system.get_input_port(), key) for key in chosen]
            return
        self._ends.append((system.get_input_port(), len(self._parts)))
        self._parts.append(chosen)

    def add_split(self, laws: Mapping[str, list[Any]], **keep: Any) -> dict[str, Any]:
        """Adds a system for one output or several; returns them by name."""
        port = self.add([e for law in laws.values() for e in law], **keep)
        return self.split(port, laws)

    def split(self, port: Any, laws: Mapping[str, list[Any]]) -> dict[str, Any]:
        """Returns the parts of a port that has several outputs, by name, to export."""
        if len(laws) == 1:
            return dict.fromkeys(laws, port)
        key, start, parts = f"several outputs {len(self._parts)}", 0, {}
        self._sources[key] = port
        for name, law in laws.items():
            parts[name] = len(self._parts)
            self._parts.append({key: [*range(start, start + len(law))]})
            start += len(law)
        return parts

    def add_block(self, block: Any) -> dict[str, Any]:
        """Adds the block itself; returns its outputs by name."""
        self.builder.AddNamedSystem("rest", block)
        for i in range(block.num_input_ports()):
            port = block.get_input_port(i)
            self._wires.append((port, port.get_name()))
        ports = map(block.get_output_port, range(block.num_output_ports()))
        return {port.get_name(): port for port in ports}

    def connect(self, inputs: Mapping[str, Any]) -> None:
        """Connects every system, and exports the inputs, also those that none uses."""
        if self._parts:
            self._add_selector()
        for name, variables in inputs.items():
            ends = [end for end, key in self._wires if key == name]
            if not ends:
                idle = self.builder.AddSystem(PassThrough(len(variables)))
                ends = [idle.get_input_port()]
            self.builder.ExportInput(ends[0], name)
            for end in ends[1:]:
                self.builder.ConnectInput(name, end)
        for end, key in self._wires:
            if key not in inputs:
                self.builder.Connect(self._sources[key], end)

    def _add_selector(self) -> None:
        keys = list(dict.fromkeys(key for part in self._parts for key in part))
        sizes = [self._size(key) for key in keys]
        parts = {
            f"y{i}": [
                (keys.index(key), at) for key, places in part.items() for at in places
            ]
            for i, part in enumerate(self._parts)
        }
        self._selector = self.builder.AddSystem(Selector(selection(sizes, parts)))
        for i, key in enumerate(keys):
            self._wires.append((self._selector.get_input_port(i), key))
        for end, i in self._ends:
            self.builder.Connect(self._selector.get_output_port(i), end)

    def _size(self, key: Hashable) -> int:
        """Returns the size of a vector."""
        if key in self._sources:
            return int(self._sources[key].size())
        return len(self._vectors[key])

    def export(self, port: Any, name: str) -> None:
        """Exports an output, a port or a part of one as `split` returns it."""
        if isinstance(port, int):
            port = self._selector.get_output_port(port)
        self.builder.ExportOutput(port, name)


def _grouped(names: list[Named], laws: _Laws) -> dict[Hashable, list[Named]]:
    """Returns the named subexpressions in groups, each for one system, in order.

    Those of one level and with the same optional inputs: otherwise an output would seem
    to depend on inputs that it does not use, and a diagram to have an algebraic loop.
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
