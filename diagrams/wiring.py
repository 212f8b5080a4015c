"""One name is one signal: an output feeds all inputs of the same name."""

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from pydrake.systems.framework import Diagram, DiagramBuilder, PortDataType

from drake_mobman import signals

from .signal_log import log_signals

Ports = dict[str, Any]
"""Output ports by the name of their signal."""


def add_blocks(builder: DiagramBuilder, blocks: Mapping[str, Any]) -> list[Any]:
    """Adds blocks by their names, and returns them."""
    return [builder.AddNamedSystem(name, block) for name, block in blocks.items()]


def outputs(systems: Sequence[Any]) -> Ports:
    """Returns all output ports of some systems."""
    return {
        port.get_name(): port
        for system in systems
        for port in map(system.get_output_port, range(system.num_output_ports()))
    }


def add_source(builder: DiagramBuilder, source: Any) -> None:
    """Adds a source; its inputs become inputs of the diagram."""
    builder.AddNamedSystem("source", source)
    for port in map(source.get_input_port, range(source.num_input_ports())):
        builder.ExportInput(port, port.get_name())


def export_inputs(
    builder: DiagramBuilder, systems: Sequence[Any], but: Collection[str] = ()
) -> None:
    """Exports each input under its name, once for all systems that have it.

    Args:
        builder: of the systems.
        systems: whose inputs are exported.
        but: names of inputs that are not.
    """
    exported = set()
    for system in systems:
        for port in map(system.get_input_port, range(system.num_input_ports())):
            name = port.get_name()
            if name in exported:
                builder.ConnectInput(name, port)
            elif name not in but:
                builder.ExportInput(port, name)
                exported.add(name)


def connect_by_name(
    builder: DiagramBuilder,
    ports: Ports,
    systems: Sequence[Any],
    left_open: Collection[str] = (),
) -> None:
    """Connects each input of `systems` to the output port of the same name.

    Args:
        builder: of the systems.
        ports: output ports by name.
        systems: whose inputs are connected.
        left_open: names of inputs that need no connection, or get one later.

    Raises:
        ValueError: where there is no output for an input.
    """
    for system in systems:
        for i in range(system.num_input_ports()):
            port = system.get_input_port(i)
            name = port.get_name()
            if name in ports:
                builder.Connect(ports[name], port)
            elif name not in left_open:
                valid = ", ".join(sorted(ports))
                raise ValueError(
                    f"{system.get_name()}: no block has an output for its input "
                    f"{name!r}; valid names are {valid}"
                )


def build_and_export(
    builder: DiagramBuilder, name: str, ports: Ports, period: float, *, logged: bool
) -> Diagram:
    """Returns the diagram, with every vector signal exported, and logged if `logged`.

    Except `robot_state`, which is exported in parts by base and arm.
    """
    vectors = {
        name: port
        for name, port in ports.items()
        if port.get_data_type() == PortDataType.kVectorValued
        and name != signals.ROBOT_STATE
    }
    for signal, port in vectors.items():
        builder.ExportOutput(port, signal)
    if logged:
        log_signals(builder, vectors, period)
    diagram = builder.Build()
    diagram.set_name(name)
    return diagram
