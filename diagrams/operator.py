"""An operator in a diagram, live or recorded."""

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
    """Adds the operator, the gate for its commands, and what keeps the base still.

    A live one gives its input at the diagram's port `operator_input`.

    Args:
        builder: to add to.
        scenario: of the operator.
        source: puts out what the operator, live or recorded, wants.
        ports: of the other blocks; the `base_command` among them is asked of the base.
        draggable: what of the robot may be dragged; nothing unless given.

    Returns:
        All output ports, now with `base_command` as far as the gate lets the base go.
    """
    add, period = builder.AddNamedSystem, scenario.period
    add_source(builder, source)
    gate = add("gate", CommandGate(scenario.gate, scenario.guard, period, draggable))
    connect_by_name(builder, outputs([source]), [gate])
    ports = ports | outputs([source, gate])
    standstill = add("standstill", StopRamp(scenario.guard, period))
    connect_by_name(builder, ports, [standstill])
    asked = ports[signals.BASE_COMMAND]
    name = f"{asked.get_system().get_name()}.{signals.BASE_COMMAND}"
    return ports | {name: asked} | outputs([standstill])
