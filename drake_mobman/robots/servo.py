"""The robot at fidelity `servo`: rigid bodies, driven by servos with force limits."""

import dataclasses as dc
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import PdControllerGains
from pydrake.symbolic import MakeVectorVariable
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import (
    ConstantVectorSource,
    SymbolicVectorSystem,
    ZeroOrderHold,
)

from drake_mobman import signals
from drake_mobman.arm.end_effector_sensor import EndEffectorSensor
from drake_mobman.base.unicycle import unicycle_rates
from drake_mobman.parameters import ParameterError, Range, checked, within
from drake_mobman.parts import of_first, picked
from drake_mobman.robot_model import BASE_JOINTS, RobotDescription, RobotSetup
from drake_mobman.robots.base_velocity import base_velocity
from drake_mobman.ticks import aligned, whole_steps


@dc.dataclass
class Servo:
    """Rigid-body dynamics, with velocity servos on base and arm.

    A servo's torque is its gain times the velocity error, up to the joint's effort
    limit. It is solved for implicitly in each step, so a large gain is stable.
    """

    step: float = 0.002  # Of the plant [s].
    base_gain: float = 1e6  # Of x and y [N s/m]: 100 N of the arm's slip 0.1 mm/s.
    yaw_gain: float = 1e5  # Of theta [N m s].
    arm_gain: float = 1e4  # Of the arm's joints, where they are driven [N m s].
    joint_damping: float = 1.0  # Of the arm's joints, where they are free [N m s].
    # At 0, a free arm that is released stays in its posture; else it goes to the start.
    joint_stiffness: float = 0.0  # Of the free joints, towards the start [N m/rad].
    has_masses: ClassVar[bool] = True

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, Range(1e-5, 0.1, "s"), "step")
        within(self, Range(1.0, 1e8, "N s/m"), "base_gain")
        within(self, Range(1.0, 1e8, "N m s"), "yaw_gain")
        within(self, Range(0.01, 1e8, "N m s"), "arm_gain")
        within(self, Range(0.0, 1e4, "N m s"), "joint_damping")
        within(self, Range(0.0, 1e5, "N m/rad"), "joint_stiffness")

    def build(self, setup: RobotSetup, start: list[float]) -> Diagram:
        """Returns the robot as a diagram, its arm driven."""
        return make_driven_robot(setup, self, start)

    def build_guided(self, setup: RobotSetup, start: list[float]) -> Diagram:
        """Returns the robot as a diagram, its arm free to be pulled by hand."""
        return make_guided_robot(setup, self, start)

    def plant(self, robot: RobotDescription) -> Any:
        """Returns the simulated plant alone, its arm driven."""
        return driven_plant(robot, self).plant

    def guided_plant(self, robot: RobotDescription) -> Any:
        """Returns the simulated plant alone, its arm free."""
        return guided_plant(robot, self).plant

    def check_period(self, period: float) -> None:
        """Raises `ParameterError` unless the step divides the control period [s]."""
        if not whole_steps(period, self.step):
            valid = f"must divide the control period of {period:g} s"
            raise ParameterError("step", self.step, valid)

    def aligned_with(self, period: float) -> tuple[float, "Servo"]:
        """Returns a period that is an exact multiple of the step, and this servo.

        Period and step differ from the given ones in the last bits at most.
        """
        period, step = aligned(period, self.step)
        return period, dc.replace(self, step=step)

    def check_aligned(self, period: float) -> None:
        """Raises `ParameterError` unless the period is whole steps, exactly."""
        self.check_period(period)
        good_period, good_step = aligned(period, self.step)
        if (period, self.step) != (good_period, good_step):
            valid = f"must be {good_step!r} at a period of {good_period!r} s"
            raise ParameterError("step", (self.step, period), f"{valid}, see `aligned`")


@dc.dataclass(frozen=True)
class ServoPlant:
    """A robot's finalized `MultibodyPlant` with servos."""

    plant: Any  # Positions x, y [m], theta [rad] of the base, then the arm's joints.
    # The positions that actuators drive, by model instance, where any has a servo.
    driven: dict[Any, list[int]]


def driven_plant(robot: RobotDescription, servo: Servo) -> ServoPlant:
    """Returns the plant of a robot whose arm is driven by velocity servos."""
    servo_gains = PdControllerGains(p=0.0, d=servo.arm_gain)
    return _plant(robot, servo, lambda joint: joint.set_controller_gains(servo_gains))


def guided_plant(robot: RobotDescription, servo: Servo) -> ServoPlant:
    """Returns the plant of a robot whose arm is free, to be pulled by hand."""

    def free(actuator: Any) -> None:
        actuator.joint().set_default_damping(servo.joint_damping)
        if servo.joint_stiffness:
            spring = PdControllerGains(p=servo.joint_stiffness, d=0.0)
            actuator.set_controller_gains(spring)

    return _plant(robot, servo, free)


def _plant(
    robot: RobotDescription, servo: Servo, set_up_arm: Callable[[Any], None]
) -> ServoPlant:
    """Returns the plant; `set_up_arm` is called for each actuator of the arm.

    Gravity is off for the whole robot: its base stands on the floor, and its arm's
    gravity is compensated, as by the makers' controllers.
    """
    plant = MultibodyPlant(servo.step)
    # Else the plant steps before all other events of the same time, and the robot would
    # get other commands than are logged.
    plant.SetUseSampledOutputPorts(False)
    instances = robot.add_to(plant)
    gains = {"x": servo.base_gain, "y": servo.base_gain, "theta": servo.yaw_gain}
    actuators = [*map(plant.get_joint_actuator, plant.GetJointActuatorIndices())]
    for actuator in actuators:
        if actuator.name() in gains:
            gain = PdControllerGains(p=0.0, d=gains[actuator.name()])
            actuator.set_controller_gains(gain)
        else:
            set_up_arm(actuator)
    for instance in instances:
        plant.set_gravity_enabled(instance, False)
    plant.Finalize()
    served = {x.model_instance() for x in actuators if x.has_controller()}
    driven: dict[Any, list[int]] = {instance: [] for instance in served}
    for actuator in actuators:
        if actuator.model_instance() in served:
            start = actuator.joint().position_start()
            driven[actuator.model_instance()].append(start)
    return ServoPlant(plant, driven)


def make_driven_robot(setup: RobotSetup, servo: Servo, start: list[float]) -> Diagram:
    """Returns the robot with rigid-body dynamics, its arm driven.

    .. pydrake_system::

        name: robot
        input_ports: [base_command_smoothed, arm_velocity_command, spatial_forces]
        output_ports: [base_pose, base_velocity, arm_position, arm_velocity,
                       ee_cylindrical, p_BT, robot_state]

    Commands are sampled each period and held in between, as on a real robot; nothing
    outside the robot is evaluated at the plant's steps.

    Args:
        setup: of the robot; its period is a multiple of the plant's step to the last
            bit, as `ticks.aligned` makes it.
        servo: step and gains.
        start: positions (3 + n,) of base and arm.

    Raises:
        ParameterError: where a parameter is not valid.
    """
    commands = {
        signals.BASE_COMMAND_SMOOTHED: 2,
        signals.ARM_VELOCITY_COMMAND: setup.arm.num_joints,
    }
    sensor = EndEffectorSensor(setup.arm)
    return _servo_robot(setup, servo, start, driven_plant, commands, sensor)


def make_guided_robot(setup: RobotSetup, servo: Servo, start: list[float]) -> Diagram:
    """Returns the robot with rigid-body dynamics, its arm free and without gravity.

    Its ports are those of a driven robot, without `arm_velocity_command`.

    Args:
        setup: of the robot.
        servo: step and gains.
        start: positions (3 + n,) of base and arm.

    Raises:
        ParameterError: where a parameter is not valid.
    """
    commands = {signals.BASE_COMMAND_SMOOTHED: 2}
    psi = setup.arm.ee_cylindrical(start[BASE_JOINTS:])[1]
    sensor = EndEffectorSensor(setup.arm, psi, setup.period)
    return _servo_robot(setup, servo, start, guided_plant, commands, sensor)


def _servo_robot(
    setup: RobotSetup,
    servo: Servo,
    start: list[float],
    make_plant: Callable[[RobotDescription, Servo], ServoPlant],
    commands: dict[str, int],
    sensor: Any,
) -> Diagram:
    """Returns the robot as a diagram with an input for each of the commands."""
    checked(servo).check_aligned(setup.period)
    made = make_plant(setup.robot, servo)
    plant = made.plant
    plant.SetDefaultPositions(np.array(start))
    n = len(start) - BASE_JOINTS
    builder = DiagramBuilder()
    stepped = setup.engine.add_to(builder, plant)
    state = stepped.get_state_output_port()
    held = {}
    for name, size in commands.items():
        hold = builder.AddNamedSystem(f"{name}.hold", ZeroOrderHold(setup.period, size))
        builder.ExportInput(hold.get_input_port(), name)
        held[name] = hold.get_output_port()
    x, y, theta = range(BASE_JOINTS)
    rates = [BASE_JOINTS + n + i for i in range(BASE_JOINTS + n)]
    # Each block costs time at each step of the plant, evaluated or not: so few blocks.
    parts = picked(
        builder,
        [state, held[signals.BASE_COMMAND_SMOOTHED]],
        {
            "told": [(0, theta), (1, 0), (1, 1)],
            signals.BASE_POSE: of_first([x, y, theta]),
            "motion": of_first([theta, *rates[:BASE_JOINTS]]),
            signals.ARM_POSITION: of_first([BASE_JOINTS + i for i in range(n)]),
            signals.ARM_VELOCITY: of_first(rates[BASE_JOINTS:]),
        },
    )
    base = builder.AddSystem(_base_rates(servo.step))
    builder.Connect(parts["told"], base.get_input_port())
    arm = held.get(signals.ARM_VELOCITY_COMMAND)
    for instance, driven in made.driven.items():
        desired = _desired_state(builder, start, driven, base.get_output_port(), arm)
        builder.Connect(desired, stepped.get_desired_state_input_port(instance))
    forces = stepped.get_applied_spatial_force_input_port()
    builder.ExportInput(forces, signals.SPATIAL_FORCES)
    for name in (signals.BASE_POSE, signals.ARM_POSITION, signals.ARM_VELOCITY):
        builder.ExportOutput(parts[name], name)
    rolling = builder.AddSystem(base_velocity())
    builder.Connect(parts["motion"], rolling.get_input_port())
    builder.ExportOutput(rolling.get_output_port(), signals.BASE_VELOCITY)
    sensor = builder.AddNamedSystem("sensor", setup.maybe_compiled(sensor))
    builder.Connect(parts[signals.ARM_POSITION], sensor.get_input_port())
    for name in (signals.EE_CYLINDRICAL, signals.P_BT):
        builder.ExportOutput(sensor.GetOutputPort(name), name)
    builder.ExportOutput(state, signals.ROBOT_STATE)
    diagram = builder.Build()
    diagram.set_name("robot")
    return diagram


def _base_rates(step: float) -> SymbolicVectorSystem:
    """Returns the desired rates of x, y and theta, from theta, v and omega.

    The base is to roll along its heading at the end of the step, where the implicit
    servo reaches its velocity: so it does not slide while it turns. The block is
    compiled, as it is evaluated at each step of the plant.
    """
    inputs = MakeVectorVariable(3, "u")
    theta, v, omega = inputs
    rates = unicycle_rates(theta + step * omega, v, omega)
    return SymbolicVectorSystem(input=inputs, output=list(rates))


def _desired_state(
    builder: DiagramBuilder,
    start: list[float],
    driven: list[int],
    base: OutputPort,
    arm: OutputPort | None,
) -> OutputPort:
    """Returns the desired state of some servos: positions, then velocities.

    Each in the order of the actuators. Only a free arm with a spring uses positions.

    Args:
        builder: to add to.
        start: positions (3 + n,) of base and arm.
        driven: the positions that the servos drive.
        base: desired rates of x, y, theta.
        arm: those of its joints; zero unless given.
    """
    rest = builder.AddSystem(ConstantVectorSource([*start, 0.0]))
    ports = [base, rest.get_output_port(), *([arm] if arm else [])]
    still = 1, len(start)

    def rate(i: int) -> tuple[int, int]:
        if i < BASE_JOINTS:
            return 0, i
        return (2, i - BASE_JOINTS) if arm else still

    places = [*((1, i) for i in driven), *map(rate, driven)]
    return picked(builder, ports, {"desired": places})["desired"]
