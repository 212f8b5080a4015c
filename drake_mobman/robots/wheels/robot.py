"""The robot on its wheels as a diagram, with the ports of a servo robot and more."""

import dataclasses as dc
from typing import Any

import numpy as np
from pydrake.symbolic import MakeVectorVariable
from pydrake.systems.controllers import InverseDynamics
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import (
    MatrixGain,
    Multiplexer,
    SymbolicVectorSystem,
    ZeroOrderHold,
)

from drake_mobman import signals
from drake_mobman.arm.end_effector_sensor import EndEffectorSensor
from drake_mobman.guidance.tool_sensor import ToolSensor
from drake_mobman.parts import of_first, picked
from drake_mobman.robot_model import RobotSetup
from drake_mobman.robot_model.plant_motion import PlantMotion
from drake_mobman.robots.base_velocity import base_velocity
from drake_mobman.robots.wheels.drive import delayed, lagged
from drake_mobman.robots.wheels.plant import RollingPlant
from drake_mobman.robots.wheels.sensors import encoder_rates, measured_motion
from drake_mobman.robots.wheels.support import Upright, add_floor_force


def make_rolling_robot(
    setup: RobotSetup,
    params: Any,
    made: RollingPlant,
    q: np.ndarray,
    *,
    free_arm: bool,
) -> Diagram:
    """Returns the robot as a diagram.

    .. pydrake_system::

        name: robot
        input_ports: [base_command_smoothed, arm_velocity_command (not of a free arm),
                      spatial_forces]
        output_ports: [base_pose, base_velocity, arm_position, arm_velocity,
                       ee_cylindrical, p_BT, base_odometry, base_gyro, base_measured,
                       tool_position, tool_velocity, floor_force, robot_state]

    Args:
        setup: of the robot; its period is a multiple of the plant's step to the last
            bit.
        params: of fidelity `Wheels`.
        made: the robot's plant, which becomes part of the diagram.
        q: positions of the plant at the start.
        free_arm: whether the plant's arm is free, else driven.
    """
    builder = DiagramBuilder()
    made.plant.SetDefaultPositions(q)
    plant = setup.engine.add_to(builder, made.plant, made.scene_graph)
    made = dc.replace(made, stepped=plant)
    rates = _add_commands(builder, setup, params, made, free_arm=free_arm)
    _add_servos(builder, made, rates, q)
    _add_gravity(builder, made)
    forces = plant.get_applied_spatial_force_input_port()
    builder.ExportInput(forces, signals.SPATIAL_FORCES)
    psi = None
    if free_arm:
        psi = setup.arm.ee_cylindrical(q[made.arm_q].tolist())[1]
    parts = _parts_of_state(builder, made)
    _add_arm_sensor(builder, setup, parts, psi)
    velocity = _add_base_outputs(builder, parts)
    _add_measurements(builder, setup, params, made, parts, velocity)
    force = add_floor_force(builder, made, parts["yaw"], setup.period)
    builder.ExportOutput(force, signals.FLOOR_FORCE)
    upright = builder.AddNamedSystem("upright", Upright(made, setup.period))
    builder.Connect(plant.get_state_output_port(), upright.get_input_port())
    tool = builder.AddNamedSystem("tool_sensor", ToolSensor(PlantMotion(made.plant)))
    builder.Connect(plant.get_state_output_port(), tool.get_input_port())
    for name in (signals.TOOL_POSITION, signals.TOOL_VELOCITY):
        builder.ExportOutput(tool.GetOutputPort(name), name)
    builder.ExportOutput(plant.get_state_output_port(), signals.ROBOT_STATE)
    diagram = builder.Build()
    diagram.set_name("robot")
    return diagram


def _add_commands(
    builder: DiagramBuilder,
    setup: RobotSetup,
    params: Any,
    made: RollingPlant,
    *,
    free_arm: bool,
) -> OutputPort:
    """Adds inputs for the commands; returns the rates of left, right, and the arm.

    Commands are held for a period. Those for the base then pass the drive's faults.
    """

    def held(name: str, size: int) -> OutputPort:
        hold = builder.AddNamedSystem(f"{name}.hold", ZeroOrderHold(setup.period, size))
        builder.ExportInput(hold.get_input_port(), name)
        return hold.get_output_port()

    drive, step = params.drive, params.step
    command = held(signals.BASE_COMMAND_SMOOTHED, 2)
    command = delayed(builder, command, drive.delay, step)
    believed = params.believed(made.base)
    to_wheels = builder.AddSystem(MatrixGain(believed.wheel_rates()))
    builder.Connect(command, to_wheels.get_input_port())
    wheels = lagged(builder, to_wheels.get_output_port(), drive.bandwidth, step)
    if free_arm:
        return wheels
    arm = held(signals.ARM_VELOCITY_COMMAND, len(made.arm))
    mux = builder.AddSystem(Multiplexer([2, len(made.arm)]))
    builder.Connect(wheels, mux.get_input_port(0))
    builder.Connect(arm, mux.get_input_port(1))
    return mux.get_output_port()


def _add_servos(
    builder: DiagramBuilder, made: RollingPlant, rates: OutputPort, q: np.ndarray
) -> None:
    """Connects the desired state of all servos: their positions, then their rates."""
    plant, base = made.plant, made.base
    told = MakeVectorVariable(rates.size(), "u")
    rate_of = {joint.index(): told[0] for joint in base.left}
    rate_of |= {joint.index(): told[1] for joint in base.right}
    rate_of |= {j.index(): x for j, x in zip(made.arm, told[2:], strict=False)}
    actuators = [*map(plant.get_joint_actuator, plant.GetJointActuatorIndices())]
    for instance in {x.model_instance() for x in actuators if x.has_controller()}:
        joints = [x.joint() for x in actuators if x.model_instance() == instance]
        positions = [q[joint.position_start()] for joint in joints]
        velocities = [rate_of.get(joint.index(), 0.0) for joint in joints]
        desired = SymbolicVectorSystem(input=told, output=[*positions, *velocities])
        builder.AddSystem(desired)
        builder.Connect(rates, desired.get_input_port())
        port = made.stepped.get_desired_state_input_port(instance)
        builder.Connect(desired.get_output_port(), port)


def _add_gravity(builder: DiagramBuilder, made: RollingPlant) -> None:
    """Adds the torques that carry the arm's weight, as makers' controllers do."""
    plant = made.plant
    gravity = builder.AddNamedSystem(
        "gravity",
        InverseDynamics(
            plant, InverseDynamics.InverseDynamicsMode.kGravityCompensation
        ),
    )
    arm = {joint.index() for joint in made.arm}
    D = np.zeros((plant.num_actuators(), plant.num_velocities()))
    for i, index in enumerate(plant.GetJointActuatorIndices()):
        joint = plant.get_joint_actuator(index).joint()
        if joint.index() in arm:
            D[i, joint.velocity_start()] = 1.0
    torques = builder.AddSystem(MatrixGain(D))
    state = made.stepped.get_state_output_port()
    builder.Connect(state, gravity.get_input_port_estimated_state())
    builder.Connect(gravity.get_output_port(), torques.get_input_port())
    builder.Connect(torques.get_output_port(), made.stepped.get_actuation_input_port())


def _parts_of_state(
    builder: DiagramBuilder, made: RollingPlant
) -> dict[str, OutputPort]:
    """Returns the parts of the plant's state that outputs are made of, by name.

    The base's motion is its yaw, then the rates of x, y and yaw.
    """
    nq = made.plant.num_positions()
    at, moves = made.floating.position_start(), nq + made.floating.velocity_start()
    wheels = [*made.base.left, *made.base.right]
    # Of the floating joint: roll, pitch, yaw, x, y, z.
    parts = {
        signals.BASE_POSE: [at + 3, at + 4, at + 2],
        "motion": [at + 2, moves + 3, moves + 4, moves + 2],
        "yaw": [at + 2],
        signals.ARM_POSITION: made.arm_q,
        signals.ARM_VELOCITY: [nq + i for i in made.arm_v],
        "angles": [joint.position_start() for joint in wheels],
        "rates": [nq + joint.velocity_start() for joint in wheels],
    }
    places = {name: of_first(part) for name, part in parts.items()}
    return picked(builder, [made.stepped.get_state_output_port()], places)


def _add_arm_sensor(
    builder: DiagramBuilder,
    setup: RobotSetup,
    parts: dict[str, OutputPort],
    psi: float | None,
) -> None:
    """Adds the arm's outputs; where `psi` [rad] is given it is kept, see the sensor."""
    position = parts[signals.ARM_POSITION]
    period = None if psi is None else setup.period
    block = setup.maybe_compiled(EndEffectorSensor(setup.arm, psi, period))
    sensor = builder.AddNamedSystem("sensor", block)
    builder.Connect(position, sensor.get_input_port())
    for name in (signals.ARM_POSITION, signals.ARM_VELOCITY):
        builder.ExportOutput(parts[name], name)
    for name in (signals.EE_CYLINDRICAL, signals.P_BT):
        builder.ExportOutput(sensor.GetOutputPort(name), name)


def _add_base_outputs(
    builder: DiagramBuilder, parts: dict[str, OutputPort]
) -> OutputPort:
    """Adds true pose and velocity of the base; returns the latter.

    Both in the floor's plane, the velocity in axes turned by the base's heading alone.
    """
    block = builder.AddSystem(base_velocity())
    builder.Connect(parts["motion"], block.get_input_port())
    builder.ExportOutput(parts[signals.BASE_POSE], signals.BASE_POSE)
    builder.ExportOutput(block.get_output_port(), signals.BASE_VELOCITY)
    return block.get_output_port()


def _add_measurements(
    builder: DiagramBuilder,
    setup: RobotSetup,
    params: Any,
    made: RollingPlant,
    parts: dict[str, OutputPort],
    velocity: OutputPort,
) -> None:
    """Adds what encoders, a gyroscope and a tracker outside measure."""
    sensors, rates = params.sensors, parts["rates"]
    left, right = made.base.left, made.base.right
    if sensors.encoder_resolution:
        counts = sensors.encoder_resolution
        rates = encoder_rates(builder, parts["angles"], counts, setup.period)
    mean = np.zeros((2, rates.size()))
    mean[0, : len(left)], mean[1, len(left) :] = 1 / len(left), 1 / len(right)
    to_motion = np.linalg.inv(params.believed(made.base).wheel_rates()) @ mean
    odometry = builder.AddSystem(MatrixGain(to_motion))
    builder.Connect(rates, odometry.get_input_port())
    gyro, measured = measured_motion(builder, velocity, sensors, setup.period)
    for name, port in (
        (signals.BASE_ODOMETRY, odometry.get_output_port()),
        (signals.BASE_GYRO, gyro),
        (signals.BASE_MEASURED, measured),
    ):
        builder.ExportOutput(port, name)
