"""A whole diagram as one law: from state and inputs to outputs and the next state.

Its blocks are evaluated once on Expressions, each with what the others put out. So a
loop of blocks becomes a program: machine code, C, or Python for arrays.
"""

import dataclasses as dc
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from pydrake.symbolic import Expression, Variable
from pydrake.systems.framework import (
    Diagram,
    InputPortIndex,
    OutputPort,
    OutputPortIndex,
)

from drake_mobman.operations import Law
from drake_mobman.scalars import Scalar
from drake_mobman.tracing import Trace, tracing

Key = tuple[str, int]
"""A port, by the path of its system and its index there."""


class StepLawError(TypeError):
    """A diagram that is no law; the message is one line that names the block."""


@dc.dataclass(frozen=True)
class Vector:
    """A signal or a state, as one part of all inputs or results."""

    name: str  # Of a port; or the path of a block with a state.
    size: int


@dc.dataclass(frozen=True)
class StepLaw:
    """What a diagram of blocks does in a control period, on Expressions.

    Its laws take the numbers of `state`, then those of `inputs`, one after the other.
    """

    period: float  # [s].
    state: tuple[Vector, ...]
    inputs: tuple[Vector, ...]
    outputs: tuple[Vector, ...]
    start: tuple[float, ...]  # The state before `initialization`.
    trace: Trace = dc.field(repr=False)
    variables: tuple[Variable, ...] = dc.field(repr=False)  # Of state, then of inputs.
    results: tuple[Scalar, ...] = dc.field(repr=False)  # The outputs.
    update: tuple[Scalar, ...] = dc.field(repr=False)  # The state a period later.
    # The state when a simulation starts.
    initialization: tuple[Scalar, ...] = dc.field(repr=False)

    @property
    def step(self) -> Law:
        """Returns the law that gives the outputs, then the state a period later."""
        return self.variables, (*self.results, *self.update)

    @property
    def begin(self) -> Law:
        """Returns the law that gives the state when a simulation starts."""
        return self.variables, self.initialization


def step_law(diagram: Diagram, outputs: Iterable[str] | None = None) -> StepLaw:
    """Returns a diagram as one law.

    Args:
        diagram: of blocks with vector ports that take Expressions, whose states are
            discrete vectors, updated together; none depends on time.
        outputs: names of the output ports that are wanted; all unless given.

    Raises:
        StepLawError: names the block that is not so.
    """
    ports = [diagram.get_output_port(i) for i in range(diagram.num_output_ports())]
    names = [port.get_name() for port in ports] if outputs is None else list(outputs)
    with np.errstate(invalid="ignore"), tracing() as trace:
        blocks = _Blocks(diagram, trace)
        results = {name: blocks.output(diagram.GetOutputPort(name)) for name in names}
        update, initialization = blocks.updates()
    return StepLaw(
        period=blocks.period,
        state=tuple(Vector(name, len(x)) for name, x in blocks.state.items()),
        inputs=tuple(Vector(name, len(x)) for name, x in blocks.inputs.items()),
        outputs=tuple(Vector(name, len(x)) for name, x in results.items()),
        start=tuple(blocks.start),
        trace=trace,
        variables=tuple(_flat([*blocks.state.values(), *blocks.inputs.values()])),
        results=tuple(_flat(results.values())),
        update=tuple(update),
        initialization=tuple(initialization),
    )


class _Blocks:
    """The leaves of a diagram on Expressions, evaluated when they are needed."""

    def __init__(self, diagram: Diagram, trace: Trace) -> None:
        self.inputs: dict[str, Any] = {}  # Variables of the diagram's inputs.
        self.state: dict[str, Any] = {}  # Variables of each block's state, by its path.
        self.start: list[float] = []
        self.period = 0.0
        self._trace = trace
        self._root = diagram.GetSystemPathname()
        self._sources: dict[Key, Any] = {}  # The output that feeds an input.
        self._leaves: dict[str, _Leaf] = {}
        self._found: dict[Key, list[Scalar]] = {}
        for i in range(diagram.num_input_ports()):
            port = diagram.get_input_port(i)
            variables = [Variable(f"{port.get_name()}{k}") for k in range(port.size())]
            self.inputs[port.get_name()] = variables
            self._found[_key(port)] = [Expression(x) for x in variables]
        self._take(diagram)

    def _take(self, diagram: Diagram) -> None:
        """Notes how the blocks of a diagram, and of those in it, are connected."""
        for (target, i), (source, j) in diagram.connection_map().items():
            self._sources[_key(target.get_input_port(i))] = source.get_output_port(j)
        for i in range(diagram.num_input_ports()):
            outer = diagram.get_input_port(i)
            for target, j in diagram.GetInputPortLocators(InputPortIndex(i)):
                self._sources[_key(target.get_input_port(j))] = outer
        for system in diagram.GetSystems():
            if isinstance(system, Diagram):
                self._take(system)
                continue
            leaf = _Leaf(system)
            path = self._path(system)
            self._leaves[system.GetSystemPathname()] = leaf
            if len(leaf.start):
                variables = [Variable(f"{path}.x{i}") for i in range(len(leaf.start))]
                self.state[path] = variables
                self.start += leaf.start
                leaf.take_state([Expression(x) for x in variables])
            if leaf.period:
                if self.period not in (0.0, leaf.period):
                    why = f"period of {leaf.period:g} s, others {self.period:g} s"
                    raise StepLawError(f"{path} has a {why}")
                self.period = leaf.period

    def _path(self, system: Any) -> str:
        """Returns the path of a block in the diagram, as `robot/kinematic`."""
        path: str = system.GetSystemPathname()
        return path.removeprefix(f"{self._root}::").replace("::", "/")

    def output(self, port: Any) -> list[Scalar]:
        """Returns what an output, of a block or a diagram, puts out.

        Raises:
            StepLawError: where it cannot be evaluated.
        """
        key = _key(port)
        system = port.get_system()
        if isinstance(system, Diagram):
            inner, i = system.get_output_port_locator(OutputPortIndex(port.get_index()))
            return self.output(inner.get_output_port(i))
        if key not in self._found:
            leaf = self._leaves[system.GetSystemPathname()]
            index = port.get_index()
            self._feed(leaf, leaf.needs(index))
            with self._naming(system):
                found = leaf.output(index)
            self._found[key] = [self._trace.name(x) for x in found]
        return self._found[key]

    def _input(self, port: Any) -> list[Scalar]:
        """Returns what an input of a block is given."""
        key = _key(port)
        while key not in self._found:
            if key not in self._sources:
                path = self._path(port.get_system())
                raise StepLawError(f"{path}: nothing feeds {port.get_name()}")
            source = self._sources[key]
            if _is_output(source):
                return self.output(source)
            key = _key(source)
        return self._found[key]

    def _feed(self, leaf: "_Leaf", inputs: Iterable[int]) -> None:
        """Gives a block some of its inputs."""
        for i in inputs:
            given = self._input(leaf.block.get_input_port(i))
            with self._naming(leaf.block):
                leaf.take(i, given)

    def updates(self) -> tuple[list[Scalar], list[Scalar]]:
        """Returns the states a period later, and those when a simulation starts.

        Raises:
            StepLawError: where there is none.
        """
        update, begun = [], []
        for leaf in self._leaves.values():
            if len(leaf.start):
                self._feed(leaf, range(leaf.block.num_input_ports()))
                with self._naming(leaf.block):
                    update += leaf.updated()
                    begun += leaf.initialized()
        return update, begun

    def _naming(self, block: Any) -> "_Naming":
        return _Naming(self._path(block))


class _Leaf:
    """A block, and the same on Expressions."""

    def __init__(self, block: Any) -> None:
        self.block = block
        state = block.CreateDefaultContext().get_discrete_state()
        self.start = state.value().tolist() if state.num_groups() else []
        event = block.GetUniquePeriodicDiscreteUpdateAttribute()
        self.period = float(event.period_sec()) if event else 0.0
        self._state: Sequence[Scalar] = ()
        self._symbolic: Any = None
        self._context: Any = None

    def needs(self, output: int) -> list[int]:
        """Returns the inputs that an output depends on at once."""
        inputs = range(self.block.num_input_ports())
        return [i for i in inputs if self.block.HasDirectFeedthrough(i, output)]

    def _made(self) -> Any:
        """Returns the block on Expressions, made when it is needed."""
        if self._symbolic is None:
            self._symbolic = self.block.ToSymbolic()
            self._context = self._symbolic.CreateDefaultContext()
            if self._state:
                self._context.SetDiscreteState(np.array(self._state))
        return self._symbolic

    def take_state(self, state: Sequence[Scalar]) -> None:
        """Takes variables for the state."""
        self._state = state

    def take(self, i: int, values: Sequence[Scalar]) -> None:
        """Takes an input."""
        port = self._made().get_input_port(i)
        port.FixValue(self._context, np.array([_expression(x) for x in values]))

    def output(self, index: int) -> list[Scalar]:
        """Returns an output."""
        return list(self._made().get_output_port(index).Eval(self._context))

    def updated(self) -> list[Scalar]:
        """Returns the state a period later."""
        if not self.period:
            return list(self._state)
        after = self._made().EvalUniquePeriodicDiscreteUpdate(self._context)
        return list(after.value())

    def initialized(self) -> list[Scalar]:
        """Returns the state when a simulation starts."""
        symbolic, context = self._made(), self._context.Clone()
        symbolic.ExecuteInitializationEvents(context)
        return list(context.get_discrete_state_vector().CopyToVector())


@dc.dataclass
class _Naming:
    """Names the block that cannot be evaluated."""

    path: str

    def __enter__(self) -> None: ...

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None:
        if isinstance(error, AttributeError | RuntimeError | TypeError):
            if isinstance(error, StepLawError):
                return
            why = " ".join(str(error).split()) or kind.__name__
            raise StepLawError(f"{self.path} takes no Expressions: {why}") from error


def _key(port: Any) -> Key:
    """Returns the key of a port: outputs and inputs have different ones."""
    side = "out" if _is_output(port) else "in"
    return f"{side} {port.get_system().GetSystemPathname()}", int(port.get_index())


def _is_output(port: Any) -> bool:
    return isinstance(port, OutputPort)


def _expression(x: Scalar) -> Expression:
    return x if type(x) is Expression else Expression(x)


def _flat(vectors: Iterable[Sequence[Any]]) -> list[Any]:
    return [x for vector in vectors for x in vector]
