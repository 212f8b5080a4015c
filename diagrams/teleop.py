"""Tele-operation: the operator's command, split between base and arm.

source -> guard -> decomposer -> smoother -> robot, with the arm's inverse beside the
smoother.
"""

from typing import Any

from pydrake.systems.framework import Diagram, DiagramBuilder

from drake_mobman import signals
from drake_mobman.arm.closed_form_inverse import ClosedFormInverse
from drake_mobman.base.smoother import CommandSmoother
from drake_mobman.decomposers.blending import Blending, BlendingDecomposer
from drake_mobman.decomposers.switching import Switching, SwitchingDecomposer
from drake_mobman.robots.model import RobotModel
from drake_mobman.robots.robot import make_robot
from drake_mobman.runs.log import log_signals
from drake_mobman.runs.scenario import Scenario
from drake_mobman.teleop.guard import CommandGuard
from drake_mobman.teleop.scripted import Script, ScriptedSource

DECOMPOSERS = {Blending: BlendingDecomposer, Switching: SwitchingDecomposer}
"""The block of each decomposer that a scenario can name."""


def make_decomposer(scenario: Scenario) -> Any:
    """Returns the decomposer that the scenario names."""
    return DECOMPOSERS[type(scenario.decomposer)](
        scenario.decomposer,
        scenario.workspace,
        scenario.projection,
        scenario.robot.arm().joints,
    )


def make_teleop_diagram(
    scenario: Scenario, *, decomposer: Any = None, logged: bool = True
) -> Diagram:
    """Returns the whole loop, from the operator's command to the robot.

    .. pydrake_system::

        name: teleop
        input_ports:
        - ee_command (only where the scenario's source is External)
        output_ports:
        - source.ee_command (unless the source is External)
        - ee_command
        - guard_status
        - base_command
        - base_share
        - arm_command
        - base_sent
        - arm_velocity_command
        - arm_status
        - base_pose
        - base_velocity
        - arm_position
        - arm_velocity
        - workspace
        - p_BT

    Args:
        scenario: checked, as `load_scenario` returns it.
        decomposer: a block to use instead of the scenario's, with the same ports.
        logged: whether every signal is logged each period; `runs.log` reads the logs.

    Raises:
        ParameterError: where a block cannot work with its parameters.
    """
    model = RobotModel(scenario.robot)
    period = scenario.period
    builder = DiagramBuilder()
    add, connect = builder.AddNamedSystem, builder.Connect

    guard = add("guard", CommandGuard(scenario.guard, period))
    decomposer = add("decomposer", decomposer or make_decomposer(scenario))
    smoother = add("smoother", CommandSmoother(scenario.smoother, period))
    arm = add(
        "arm",
        ClosedFormInverse(
            scenario.robot.arm(), model.limits, period, by=scenario.inverse
        ),
    )
    start = scenario.start_position(model)
    robot = add("robot", make_robot(scenario.robot, start, period))

    # One name is one signal: whoever puts it out feeds all who take it.
    systems = [guard, decomposer, smoother, arm, robot]
    ports = {
        port.get_name(): port
        for system in systems
        for port in map(system.get_output_port, range(system.num_output_ports()))
    }
    for system in systems[1:]:
        for i in range(system.num_input_ports()):
            port = system.get_input_port(i)
            connect(ports[port.get_name()], port)

    command = guard.GetInputPort(signals.EE_COMMAND)
    if isinstance(scenario.source, Script):
        source = add("source", ScriptedSource(scenario.source))
        connect(source.get_output_port(), command)
        ports[f"source.{signals.EE_COMMAND}"] = source.get_output_port()
    else:
        builder.ExportInput(command, signals.EE_COMMAND)

    for name, port in ports.items():
        builder.ExportOutput(port, name)
    if logged:
        log_signals(builder, ports, period)
    diagram = builder.Build()
    diagram.set_name("teleop")
    return diagram
