"""The controller alone: from a command and what is measured, to base and joints.

guard -> decomposer -> smoother, with the arm's inverse beside the smoother, as in the
whole loop; a sensor works out where the end effector is. No robot is in it.
"""

import dataclasses as dc

from pydrake.systems.framework import Diagram, DiagramBuilder

from drake_mobman import signals
from drake_mobman.arm.end_effector_sensor import EndEffectorSensor
from drake_mobman.robot_model import RobotSetup
from drake_mobman.scenario import Teleop
from drake_mobman.teleop.external import External

from .teleop import add_guarded, controller_blocks, make_decomposers
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
    scenario = dc.replace(scenario.in_whole_steps(), source=External())
    setup = dc.replace(setup or scenario.setup(), compiled=False)
    decomposer = make_decomposers(scenario, setup, choice=False)
    blocks = controller_blocks(scenario, setup, decomposer)
    builder = DiagramBuilder()
    sensor = {"sensor": EndEffectorSensor(setup.arm)}
    systems = add_blocks(builder, sensor | blocks)
    ports = outputs(systems)
    # First: a program finds the command before all that is measured.
    source = scenario.source.build(setup.period)
    ports |= add_guarded(builder, scenario, setup, source, ports)
    measured = [signals.ARM_POSITION, signals.BASE_POSE, *scenario.estimate.measures]
    connect_by_name(builder, ports, systems, measured)
    export_inputs(builder, systems, but=ports)
    for name in OUTPUTS:
        if name in ports:
            builder.ExportOutput(ports[name], name)
    diagram = builder.Build()
    diagram.set_name("controller")
    return diagram
