"""The robot as a diagram: base and arm take commands, and tell their state."""

from collections.abc import Callable
from typing import Any

from pydrake.systems.framework import Diagram, DiagramBuilder

from drake_mobman import signals
from drake_mobman.arm.end_effector_sensor import EndEffectorSensor
from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import BASE_JOINTS, Robot
from drake_mobman.robots.kinematic import Kinematic, KinematicRobot
from drake_mobman.robots.servo import Servo, make_servo_robot


def make_robot(
    robot: Robot,
    start: list[float],
    period: float,
    fidelity: Kinematic | Servo | None = None,
    *,
    free_arm: bool = False,
    maybe_compiled: Callable[[Any], Any] = lambda block: block,
) -> Diagram:
    """Returns the robot at a fidelity; no controller knows which.

    .. pydrake_system::

        name: robot
        input_ports:
        - base_command_smoothed
        - arm_velocity_command (unless the arm is free)
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
        period: control period [s], at `Kinematic` the Euler step too.
        fidelity: `Kinematic` by default.
        free_arm: see `make_servo_robot`, which alone has forces.
        maybe_compiled: makes of a block what goes into the diagram, as `compiled` does.

    Raises:
        ParameterError: where a parameter is not valid, or an arm is to be free at a
            fidelity without forces.
    """
    if isinstance(fidelity, Servo):
        arm = robot.arm()
        at_start = (
            (arm.ee_cylindrical(start[BASE_JOINTS:])[1], period) if free_arm else ()
        )
        sensor = maybe_compiled(EndEffectorSensor(arm, *at_start))
        return make_servo_robot(
            robot, fidelity, start, period, sensor=sensor, free_arm=free_arm
        )
    if free_arm:
        raise ParameterError("free_arm", True, "must be False without forces, !Servo")
    builder = DiagramBuilder()
    body = builder.AddNamedSystem(
        "kinematic", maybe_compiled(KinematicRobot(start, period))
    )
    sensor = builder.AddNamedSystem(
        "sensor", maybe_compiled(EndEffectorSensor(robot.arm()))
    )
    position = body.GetOutputPort(signals.ARM_POSITION)
    builder.Connect(position, sensor.GetInputPort(signals.ARM_POSITION))
    for system in (body, sensor):
        for i in range(system.num_output_ports()):
            port = system.get_output_port(i)
            builder.ExportOutput(port, port.get_name())
    for name in (signals.BASE_COMMAND_SMOOTHED, signals.ARM_VELOCITY_COMMAND):
        builder.ExportInput(body.GetInputPort(name), name)
    diagram = builder.Build()
    diagram.set_name("robot")
    return diagram
