"""An operator in a diagram, who is there or was."""

from pydrake.systems.framework import DiagramBuilder

from drake_mobman import signals
from drake_mobman.scenario.scenario import AnyScenario
from drake_mobman.teleop.drag import NO_BODY, Draggable
from drake_mobman.teleop.gate import CommandGate
from drake_mobman.teleop.live import LiveSource, Operator
from drake_mobman.teleop.recorded import RecordedSource, Recording
from drake_mobman.teleop.stop_ramp import StopRamp

from .wiring import Ports, connect_by_name, outputs


def operator_of(scenario: AnyScenario) -> Operator | Recording | None:
    """Returns the scenario's operator, if it has one."""
    source = scenario.source
    return source if isinstance(source, Operator | Recording) else None


def add_operator(
    builder: DiagramBuilder,
    scenario: AnyScenario,
    operator: Operator | Recording,
    ports: Ports,
    draggable: Draggable = NO_BODY,
) -> Ports:
    """Adds the operator, the gate for what he says, and what keeps the base still.

    A live one speaks at the diagram's input port `operator_input`.

    Args:
        builder: to add to.
        scenario: of the operator.
        operator: live or recorded.
        ports: of the other blocks; the `base_command` among them is asked of the base.
        draggable: what of the robot may be dragged; nothing unless given.

    Returns:
        All output ports, now with `base_command` as far as the gate lets the base go.

    Raises:
        ParameterError: where a recording cannot be read.
    """
    add, period = builder.AddNamedSystem, scenario.period
    if isinstance(operator, Recording):
        source = add("source", RecordedSource(operator.samples(period), period))
    else:
        source = add("source", LiveSource(period))
        builder.ExportInput(source.get_input_port(), signals.OPERATOR_INPUT)
    gate = add("gate", CommandGate(scenario.gate, scenario.guard, period, draggable))
    connect_by_name(builder, outputs([source]), [gate])
    ports = ports | outputs([source, gate])
    standstill = add("standstill", StopRamp(scenario.guard, period))
    connect_by_name(builder, ports, [standstill])
    asked = ports[signals.BASE_COMMAND]
    name = f"{asked.get_system().get_name()}.{signals.BASE_COMMAND}"
    return ports | {name: asked} | outputs([standstill])
