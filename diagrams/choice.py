"""Several controllers; the operator chooses one of them while driving."""

from collections.abc import Sequence
from typing import Any

from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, PortSwitch

from drake_mobman import signals
from drake_mobman.teleop.choice import ControllerSelector, CrossFade, Transition

from .wiring import export_inputs

FLAGS = (signals.DECOMPOSER_STATUS, signals.FIELD_ZONE)
"""Signals that are sums of flags: they switch at once, without a fade."""


def make_choice(
    blocks: Sequence[Any], transition: Transition, period: float
) -> Diagram:
    """Returns a diagram with the outputs of the selected one of `blocks`.

    .. pydrake_system::

        name: choice
        input_ports:
        - operator_input
        - (all inputs of the blocks)
        output_ports:
        - handover
        - (all outputs of the blocks)

    A `PortSwitch` for each signal selects the block that is to drive. During a
    transition, a second switch selects the block that drove before, and the signal
    fades from that to the first; flags switch at once. A signal that a block does not
    have is zero while that block drives.

    Args:
        blocks: with the same ports; not every block needs all of them.
        transition: how one block takes over from another.
        period: control period [s].

    Raises:
        ParameterError: where a parameter is not valid.
    """
    builder = DiagramBuilder()
    selector = builder.AddNamedSystem(
        "selector", ControllerSelector(len(blocks), transition, period)
    )
    for i, block in enumerate(blocks):
        builder.AddNamedSystem(f"{i}", block)
    export_inputs(builder, [selector, *blocks])
    handover = selector.GetOutputPort(signals.HANDOVER)
    builder.ExportOutput(handover, signals.HANDOVER)
    for name, size in _output_sizes(blocks).items():
        ports = [_port_or_zero(builder, block, name, size) for block in blocks]

        def switch(which: str, name: str = name, ports: Any = ports) -> Any:
            return _switch(builder, f"{name}.{which}", ports, selector, which)

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


def _output_sizes(blocks: Sequence[Any]) -> dict[str, int]:
    """Returns the sizes of all output signals of the blocks."""
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
    builder: DiagramBuilder, name: str, ports: Sequence[Any], selector: Any, which: str
) -> Any:
    """Returns the output of a switch between `ports`, which the selector sets."""
    switch = builder.AddNamedSystem(name, PortSwitch(ports[0].size()))
    selected = switch.get_port_selector_input_port()
    builder.Connect(selector.GetOutputPort(which), selected)
    for i, port in enumerate(ports):
        builder.Connect(port, switch.DeclareInputPort(f"{i}"))
    return switch.get_output_port()
