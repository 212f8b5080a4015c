"""The robot as a diagram: base and arm take commands, and tell their state."""

from pydrake.systems.framework import Diagram, DiagramBuilder

from drake_mobman import signals
from drake_mobman.arm.workspace_sensor import WorkspaceSensor
from drake_mobman.robots.kinematic import KinematicRobot
from drake_mobman.robots.model import Robot


def make_robot(robot: Robot, start: list[float], period: float) -> Diagram:
    """Returns the robot at fidelity `kinematic`.

    .. pydrake_system::

        name: robot
        input_ports:
        - base_sent
        - arm_velocity_command
        output_ports:
        - base_pose
        - base_velocity
        - arm_position
        - arm_velocity
        - workspace
        - p_BT

    Args:
        robot: which one.
        start: positions (3 + n,) of base and arm.
        period: Euler step [s].
    """
    builder = DiagramBuilder()
    body = builder.AddNamedSystem("kinematic", KinematicRobot(start, period))
    sensor = builder.AddNamedSystem("sensor", WorkspaceSensor(robot.arm()))
    position = body.GetOutputPort(signals.ARM_POSITION)
    builder.Connect(position, sensor.GetInputPort(signals.ARM_POSITION))
    for system in (body, sensor):
        for i in range(system.num_output_ports()):
            port = system.get_output_port(i)
            builder.ExportOutput(port, port.get_name())
    for name in (signals.BASE_SENT, signals.ARM_VELOCITY_COMMAND):
        builder.ExportInput(body.GetInputPort(name), name)
    diagram = builder.Build()
    diagram.set_name("robot")
    return diagram
