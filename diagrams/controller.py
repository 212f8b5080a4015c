"""The controller alone: from a command and what is measured, to base and joints.

guard -> decomposer -> smoother, with the arm's inverse beside the smoother, as in the
whole loop; a sensor works out where the end effector is. No robot is in it.
"""

from typing import Any

from pydrake.systems.framework import Diagram, DiagramBuilder

from drake_mobman import signals
from drake_mobman.arm.end_effector_sensor import EndEffectorSensor
from drake_mobman.decomposers.field import build_decomposer
from drake_mobman.robot_model import RobotSetup
from drake_mobman.scenario import Teleop
from drake_mobman.teleop.guard import CommandGuard

from .wiring import add_blocks, connect_by_name, export_inputs, outputs

OUTPUTS = (
    signals.BASE_COMMAND_SMOOTHED,
    signals.ARM_VELOCITY_COMMAND,
    signals.GUARD_STATUS,
    signals.DECOMPOSER_STATUS,
    signals.ARM_STATUS,
)
"""What goes to the robot, and what the operator is told."""


def make_controller_diagram(
    scenario: Teleop, setup: RobotSetup | None = None
) -> Diagram:
    """Returns the controller of a scenario, without source and robot.

    .. pydrake_system::

        name: controller
        input_ports:
        - ee_command
        - arm_position
        - (base_pose, where the tool keeps its own orientation)
        - (the signals that the scenario's estimate measures)
        output_ports:
        - base_command_smoothed
        - arm_velocity_command
        - guard_status
        - decomposer_status (where the decomposer has one)
        - arm_status

    Args:
        scenario: checked, as `load_scenario` returns it.
        setup: of its robot, `scenario.setup()` unless given.

    Raises:
        ParameterError: where a block cannot work with its parameters.
    """
    scenario = scenario.in_whole_steps()
    setup = setup or scenario.setup()
    estimator = scenario.estimate.build(setup.period)
    watched = estimator.HasOutputPort(signals.BASE_ASTRAY)
    guard = CommandGuard(scenario.guard, setup.period, watched=watched)
    builder = DiagramBuilder()
    systems = add_blocks(
        builder,
        {
            "guard": guard,
            "sensor": EndEffectorSensor(setup.arm),
            "decomposer": build_decomposer(scenario.decomposer, setup),
            "smoother": scenario.smoother.build(setup),
            "estimator": estimator,
            "arm": scenario.robot.arm_inverse(setup),
        },
    )
    ports = outputs(systems)
    # The guard's input has its output's name: it is the diagram's.
    builder.ExportInput(guard.command, signals.EE_COMMAND)
    left = {name for name in _inputs(systems) if name not in ports}
    connect_by_name(builder, ports, systems[1:], left)
    if watched:
        builder.Connect(ports[signals.BASE_ASTRAY], guard.astray)
    export_inputs(builder, systems[1:], ports)
    for name in OUTPUTS:
        if name in ports:
            builder.ExportOutput(ports[name], name)
    diagram = builder.Build()
    diagram.set_name("controller")
    return diagram


def _inputs(systems: list[Any]) -> set[str]:
    """Returns the names of all inputs of some blocks."""
    return {
        system.get_input_port(i).get_name()
        for system in systems
        for i in range(system.num_input_ports())
    }
