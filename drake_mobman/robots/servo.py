"""The robot at fidelity `servo`: rigid bodies, driven by servos of bounded force."""

import dataclasses as dc
from typing import Any

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import PdControllerGains
from pydrake.symbolic import MakeVectorVariable, cos, sin
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import (
    Demultiplexer,
    Multiplexer,
    SymbolicVectorSystem,
    ZeroOrderHold,
)

from drake_mobman import signals
from drake_mobman.arm.end_effector_sensor import EndEffectorSensor
from drake_mobman.base.unicycle import unicycle_rates
from drake_mobman.parameters import ParameterError, Range, checked, within
from drake_mobman.robot_model import BASE_JOINTS, Robot
from drake_mobman.ticks import aligned, whole_steps


@dc.dataclass
class Servo:
    """Rigid-body dynamics, with velocity servos on base and arm.

    A servo's torque is its gain times the error of its velocity, up to the joint's
    effort limit; it is solved for with the step, so a large gain is stable.
    """

    step: float = 0.002  # Of the plant [s].
    base_gain: float = 1e6  # Of x and y [N s/m]: 100 N of the arm's slip 0.1 mm/s.
    yaw_gain: float = 1e5  # Of theta [N m s].
    arm_gain: float = 1e4  # Of the arm's joints, where they are driven [N m s].
    joint_damping: float = 1.0  # Of the arm's joints, where they are free [N m s].
    # A free arm that is let go stays where it is to the base; with this, it goes home.
    joint_stiffness: float = 0.0  # Of the same, towards the start [N m/rad].

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, Range(1e-5, 0.1, "s"), "step")
        within(self, Range(1.0, 1e8, "N s/m"), "base_gain")
        within(self, Range(1.0, 1e8, "N m s"), "yaw_gain")
        within(self, Range(0.01, 1e8, "N m s"), "arm_gain")
        within(self, Range(0.0, 1e4, "N m s"), "joint_damping")
        within(self, Range(0.0, 1e5, "N m/rad"), "joint_stiffness")

    def check_period(self, period: float) -> None:
        """Raises `ParameterError` unless the control period [s] is whole steps."""
        if not whole_steps(period, self.step):
            valid = f"must divide the control period of {period:g} s"
            raise ParameterError("step", self.step, valid)

    def check_aligned(self, period: float) -> None:
        """Raises `ParameterError` unless ticks and steps stay in step for good."""
        self.check_period(period)
        good_period, good_step = aligned(period, self.step)
        if (period, self.step) != (good_period, good_step):
            valid = f"must be {good_step!r} at a period of {good_period!r} s"
            raise ParameterError("step", (self.step, period), f"{valid}, see `aligned`")


class ServoRobot:
    """A robot's `MultibodyPlant` with servos, finished.

    Gravity is off for the whole robot: its base stands on the floor, and its arm is
    compensated for gravity, as the makers' controllers do it.

    Attributes:
        plant: positions x, y [m], theta [rad] of the base, then the arm's joints.
        instance: of the robot in the plant.
        driven: which position each of its actuators drives, in their order.
    """

    def __init__(self, robot: Robot, servo: Servo, *, free_arm: bool) -> None:
        self.plant = MultibodyPlant(servo.step)
        # Else the plant steps before all else that happens at the same time, and what
        # the robot is told would not be what is logged.
        self.plant.SetUseSampledOutputPorts(False)
        (self.instance,) = Parser(self.plant).AddModelsFromString(robot.urdf(), "urdf")
        gains = {"x": servo.base_gain, "y": servo.base_gain, "theta": servo.yaw_gain}
        for index in self.plant.GetJointActuatorIndices():
            actuator = self.plant.get_joint_actuator(index)
            if free_arm and actuator.name() not in gains:
                actuator.joint().set_default_damping(servo.joint_damping)
                spring = PdControllerGains(p=servo.joint_stiffness, d=0.0)
                if servo.joint_stiffness:
                    actuator.set_controller_gains(spring)
                continue
            gain = gains.get(actuator.name(), servo.arm_gain)
            actuator.set_controller_gains(PdControllerGains(p=0.0, d=gain))
        self.plant.set_gravity_enabled(self.instance, False)
        self.plant.Finalize()
        actuators = map(
            self.plant.get_joint_actuator, self.plant.GetJointActuatorIndices()
        )
        self.driven = [each.joint().position_start() for each in actuators]


def make_servo_robot(
    robot: Robot,
    servo: Servo,
    start: list[float],
    period: float,
    *,
    free_arm: bool,
    sensor: Any = None,
) -> Diagram:
    """Returns the robot with rigid-body dynamics.

    Commands are sampled each `period` and held in between, as a robot's own bus does
    it; nothing outside is asked at the plant's steps.

    .. pydrake_system::

        name: robot
        input_ports:
        - base_command_smoothed
        - arm_velocity_command (unless the arm is free)
        - spatial_forces
        output_ports:
        - base_pose
        - base_velocity
        - arm_position
        - arm_velocity
        - workspace
        - p_BT
        - robot_state

    Args:
        robot: which one.
        servo: step and gains.
        start: positions (3 + n,) of base and arm.
        period: control period [s], a multiple of the plant's step to the last bit, as
            `ticks.aligned` makes it.
        free_arm: whether the arm is free and compensated for gravity, to be pulled by
            hand, instead of driven at `arm_velocity_command`.
        sensor: tells `workspace` and `p_BT`; a `EndEffectorSensor` unless given.

    Raises:
        ParameterError: where a parameter is not valid.
    """
    checked(servo).check_aligned(period)
    body = ServoRobot(robot, servo, free_arm=free_arm)
    plant = body.plant
    plant.SetDefaultPositions(np.array(start))
    n = len(start) - BASE_JOINTS
    builder = DiagramBuilder()
    builder.AddNamedSystem("plant", plant)
    state = plant.get_state_output_port()
    # Blocks cost at each step of the plant, asked or not: they are few.
    parts = builder.AddSystem(Demultiplexer([BASE_JOINTS, n, BASE_JOINTS, n]))
    builder.Connect(state, parts.get_input_port())
    pose, position, _, velocity = map(parts.get_output_port, range(4))

    held = []
    commands = {signals.BASE_COMMAND_SMOOTHED: 2}
    if not free_arm:
        commands[signals.ARM_VELOCITY_COMMAND] = n
    for name, size in commands.items():
        hold = builder.AddNamedSystem(f"{name}.hold", ZeroOrderHold(period, size))
        builder.ExportInput(hold.get_input_port(), name)
        held.append(hold.get_output_port())

    wanted = _desired_state(start, servo.step, free_arm, body.driven)
    desired = _joined(builder, [pose, *held], wanted)
    builder.Connect(desired, plant.get_desired_state_input_port(body.instance))

    forces = plant.get_applied_spatial_force_input_port()
    builder.ExportInput(forces, signals.SPATIAL_FORCES)
    builder.ExportOutput(pose, signals.BASE_POSE)
    builder.ExportOutput(position, signals.ARM_POSITION)
    builder.ExportOutput(velocity, signals.ARM_VELOCITY)
    rolling = builder.AddSystem(_base_velocity(n))
    builder.Connect(state, rolling.get_input_port())
    builder.ExportOutput(rolling.get_output_port(), signals.BASE_VELOCITY)
    sensor = builder.AddNamedSystem("sensor", sensor or EndEffectorSensor(robot.arm()))
    builder.Connect(position, sensor.get_input_port())
    for name in (signals.EE_CYLINDRICAL, signals.P_BT):
        builder.ExportOutput(sensor.GetOutputPort(name), name)
    builder.ExportOutput(state, signals.ROBOT_STATE)
    diagram = builder.Build()
    diagram.set_name("robot")
    return diagram


def _desired_state(
    start: list[float], step: float, free_arm: bool, driven: list[int]
) -> SymbolicVectorSystem:
    """Returns what the servos are told, from the base's pose and the commands held.

    Positions, then velocities, each in the order of the actuators.
    The base is told to roll along the heading that it will have at the step's end,
    where an implicit servo makes its velocity: so it does not slide while it turns.
    It is asked at each step of the plant, and so is compiled. Positions count only for
    a free arm with a spring.
    """
    n = len(start) - BASE_JOINTS
    told = MakeVectorVariable(BASE_JOINTS + (2 if free_arm else 2 + n), "u")
    _, _, theta, v, omega, *rates = told
    base = unicycle_rates(theta + step * omega, v, omega)
    velocities = [*base, *(rates or [0.0] * n)]
    desired = [each[i] for each in (start, velocities) for i in driven]
    return SymbolicVectorSystem(input=told, output=desired)


def _base_velocity(n: int) -> SymbolicVectorSystem:
    """Returns `base_velocity` from the state of a robot with `n` joints in its arm."""
    told = MakeVectorVariable(2 * (BASE_JOINTS + n), "u")
    theta, (x, y, omega) = told[2], told[BASE_JOINTS + n :][:BASE_JOINTS]
    forward = cos(theta) * x + sin(theta) * y
    sideways = cos(theta) * y - sin(theta) * x
    return SymbolicVectorSystem(input=told, output=[forward, sideways, omega])


def _joined(
    builder: DiagramBuilder, ports: list[OutputPort], system: Any
) -> OutputPort:
    """Adds `system`, fed by all `ports` one after the other, and returns its output."""
    mux = builder.AddSystem(Multiplexer([port.size() for port in ports]))
    builder.AddSystem(system)
    for i, port in enumerate(ports):
        builder.Connect(port, mux.get_input_port(i))
    builder.Connect(mux.get_output_port(), system.get_input_port())
    return system.get_output_port()
