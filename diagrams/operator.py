"""A live or recorded operator in a diagram."""

from typing import Any

from pydrake.systems.framework import DiagramBuilder

from drake_mobman import signals
from drake_mobman.scenario import AnyScenario
from drake_mobman.teleop.drag import NO_BODY, Draggable
from drake_mobman.teleop.gate import CommandGate
from drake_mobman.teleop.stop_ramp import StopRamp

from .wiring import Ports, add_source, connect_by_name, outputs


def add_operator(
    builder: DiagramBuilder,
    scenario: AnyScenario,
    source: Any,
    ports: Ports,
    draggable: Draggable = NO_BODY,
) -> Ports:
    """Adds the operator, the gate for the commands, and the base's stop ramp.

    A live operator's input is the diagram's port `operator_input`.

    Args:
        builder: to add to.
        scenario: of the operator.
        source: block with the input of the live or recorded operator.
        ports: of the other blocks, with `base_command`.
        draggable: the bodies that may be dragged; none unless given.

    Returns:
        All output ports. `base_command` is now the stop ramp's; the raw one's name
        begins with the name of its block, as in `decomposer.base_command`.
    """
    add, period = builder.AddNamedSystem, scenario.period
    add_source(builder, source)
    watched = signals.BASE_ASTRAY in ports
    gate = add(
        "gate",
        CommandGate(scenario.gate, scenario.guard, period, draggable, watched=watched),
    )
    connect_by_name(builder, ports | outputs([source]), [gate])
    ports = ports | outputs([source, gate])
    stop_ramp = add("stop_ramp", StopRamp(scenario.guard, period))
    connect_by_name(builder, ports, [stop_ramp])
    raw = ports[signals.BASE_COMMAND]
    name = f"{raw.get_system().get_name()}.{signals.BASE_COMMAND}"
    return ports | {name: raw} | outputs([stop_ramp])
