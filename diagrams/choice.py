"""Controllers side by side, of which the operator chooses one while driving."""

from collections.abc import Sequence
from typing import Any

from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, PortSwitch

from drake_mobman import signals
from drake_mobman.teleop.choice import ControllerSelector, CrossFade, Transition

FLAGS = (signals.DECOMPOSER_STATUS, signals.FIELD_ZONE)
"""Signals that are sums of flags: there is nothing between two of them."""


def make_choice(blocks: Sequence[Any], change: Transition, period: float) -> Diagram:
    """Returns a block that does what the chosen one of `blocks` does.

    .. pydrake_system::

        name: choice
        input_ports:
        - operator_input
        - (all that any of the blocks takes)
        output_ports:
        - handover
        - (all that any of the blocks puts out)

    Each signal goes through a `PortSwitch` to who is to drive. While one takes over
    from another, a second switch goes to who drove, and the signal fades from that to
    this; flags are at once those of who is to drive. A signal that a block does not
    have is zero while that one drives.

    Args:
        blocks: with the same ports, but that not every one need have each.
        change: how one takes over from another.
        period: control period [s].

    Raises:
        ParameterError: where a parameter is not valid.
    """
    builder = DiagramBuilder()
    chooser = builder.AddNamedSystem(
        "chooser", ControllerSelector(len(blocks), change, period)
    )
    for i, block in enumerate(blocks):
        builder.AddNamedSystem(f"{i}", block)
    _export_inputs(builder, [chooser, *blocks])
    handover = chooser.GetOutputPort(signals.HANDOVER)
    builder.ExportOutput(handover, signals.HANDOVER)
    for name, size in _output_sizes(blocks).items():
        ports = [_port_or_zero(builder, block, name, size) for block in blocks]

        def switch(which: str, name: str = name, ports: Any = ports) -> Any:
            return _switch(builder, f"{name}.{which}", ports, chooser, which)

        if name in FLAGS:
            builder.ExportOutput(switch("now"), name)
            continue
        fade = builder.AddNamedSystem(name, CrossFade(size))
        builder.Connect(handover, fade.handover)
        builder.Connect(switch("before"), fade.before)
        builder.Connect(switch("now"), fade.now)
        builder.ExportOutput(fade.get_output_port(), name)
    diagram = builder.Build()
    diagram.set_name("choice")
    return diagram


def _export_inputs(builder: DiagramBuilder, systems: Sequence[Any]) -> None:
    """Exports each input under its name, one for all systems that have it."""
    exported = set()
    for system in systems:
        for port in map(system.get_input_port, range(system.num_input_ports())):
            name = port.get_name()
            if name in exported:
                builder.ConnectInput(name, port)
            else:
                builder.ExportInput(port, name)
                exported.add(name)


def _output_sizes(blocks: Sequence[Any]) -> dict[str, int]:
    """Returns the sizes of all signals that any of the blocks puts out."""
    return {
        port.get_name(): port.size()
        for block in blocks
        for port in map(block.get_output_port, range(block.num_output_ports()))
    }


def _port_or_zero(builder: DiagramBuilder, block: Any, name: str, size: int) -> Any:
    if block.HasOutputPort(name):
        return block.GetOutputPort(name)
    return builder.AddSystem(ConstantVectorSource([0.0] * size)).get_output_port()


def _switch(
    builder: DiagramBuilder, name: str, ports: Sequence[Any], chooser: Any, which: str
) -> Any:
    """Returns the output of a switch between `ports`, which the chooser sets."""
    switch = builder.AddNamedSystem(name, PortSwitch(ports[0].size()))
    selector = switch.get_port_selector_input_port()
    builder.Connect(chooser.GetOutputPort(which), selector)
    for i, port in enumerate(ports):
        builder.Connect(port, switch.DeclareInputPort(f"{i}"))
    return switch.get_output_port()
