"""Tele-operation: the operator's command, split between base and arm.

source -> guard -> decomposer -> smoother -> robot, with the arm's inverse beside the
smoother. With a live or a recorded operator the gate stands in the guard's place, and
the decomposer may be one of several, as he chooses.
"""

import dataclasses as dc
from typing import Any

from pydrake.systems.framework import Diagram, DiagramBuilder

from drake_mobman import signals
from drake_mobman.arm.closed_form_inverse import ClosedFormInverse
from drake_mobman.arm.damped_inverse import DampedInverse
from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.oriented_inverse import OrientedInverse
from drake_mobman.base.smoother import CommandSmoother
from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.decomposers.blending import Blending, BlendingDecomposer
from drake_mobman.decomposers.diff_ik import DiffIk, DiffIkDecomposer
from drake_mobman.decomposers.exact import Exact, ExactDecomposer
from drake_mobman.decomposers.field import FieldDecomposer
from drake_mobman.decomposers.limiter import Limiter
from drake_mobman.decomposers.qp import Qp, QpDecomposer
from drake_mobman.decomposers.switching import Switching, SwitchingDecomposer
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.robot import make_robot
from drake_mobman.scenario.scenario import Teleop
from drake_mobman.teleop.guard import CommandGuard
from drake_mobman.teleop.scripted import Script, ScriptedSource

from .choice import make_choice
from .operator import add_operator, operator_of
from .wiring import Ports, build_and_export, connect_by_name, maybe_compiled, outputs


def make_decomposer(scenario: Teleop, model: RobotModel) -> Any:
    """Returns the decomposer that the scenario names."""
    params, robot, limits = scenario.decomposer, scenario.robot, model.limits
    arm, period = robot.arm(), scenario.period
    shared = scenario.workspace, scenario.projection, arm.num_joints
    match params:
        case Exact():
            return ExactDecomposer(
                params, scenario.workspace, arm, limits, scenario.smoother, period
            )
        case Blending():
            return BlendingDecomposer(params, *shared)
        case Switching():
            return SwitchingDecomposer(params, *shared)
        case VelocityField():
            limiter = Limiter(arm, limits, scenario.smoother, None, period)
            return FieldDecomposer(params, robot.reach(), arm, limiter)
        case Qp():
            return QpDecomposer(params, arm, limits, period)
        case DiffIk():
            return DiffIkDecomposer(params, robot, period)


def make_decomposers(scenario: Teleop, model: RobotModel) -> Any:
    """Returns the scenario's decomposer, or what chooses between it and others.

    There is a choice where there is an operator to choose.
    """
    wanted, period = maybe_compiled(scenario), scenario.period
    operated = operator_of(scenario)
    params = scenario.controllers if operated else [scenario.decomposer]
    blocks = [
        wanted(make_decomposer(dc.replace(scenario, decomposer=one), model))
        for one in params
    ]
    return make_choice(blocks, scenario.transition, period) if blocks[1:] else blocks[0]


def make_arm_inverse(scenario: Teleop, model: RobotModel) -> Any:
    """Returns the arm's inverse: in closed form where the arm has one."""
    robot, limits, period = scenario.robot, model.limits, scenario.period
    arm = robot.arm()
    if isinstance(robot, Planar) or not isinstance(arm, JacobianArm):
        return ClosedFormInverse(arm, limits, period, by=scenario.inverse)
    if robot.orientation == "reach":
        return DampedInverse(arm, limits, period)
    return OrientedInverse(arm, limits, period, robot.orientation)


def add_guarded(builder: DiagramBuilder, scenario: Teleop) -> Ports:
    """Adds a source without an operator, and the guard; returns their outputs."""
    guard = CommandGuard(scenario.guard, scenario.period)
    if isinstance(scenario.source, Script):
        # A script is finite throughout; a program need not be, and what is compiled
        # would end the simulation.
        guard = builder.AddNamedSystem("guard", maybe_compiled(scenario)(guard))
        ports = outputs([guard])
        source = builder.AddNamedSystem(
            "source", ScriptedSource(scenario.source, scenario.period)
        )
        builder.Connect(source.get_output_port(), guard.get_input_port())
        ports[f"source.{signals.EE_COMMAND}"] = source.get_output_port()
        return ports
    builder.AddNamedSystem("guard", guard)
    builder.ExportInput(guard.get_input_port(), signals.EE_COMMAND)
    return outputs([guard])


def make_teleop_diagram(
    scenario: Teleop, *, decomposer: Any = None, logged: bool = True
) -> Diagram:
    """Returns the whole loop, from the operator's command to the robot.

    .. pydrake_system::

        name: teleop
        input_ports:
        - ee_command (only where the scenario's source is External)
        - operator_input (only where it is Operator)
        output_ports:
        - source.ee_command (where it is Script)
        - operator_input, gate_status, gate_arming, decomposer.base_command (where it
          is Operator or Recording)
        - handover (where there are alternatives to choose from)
        - ee_command
        - guard_status
        - base_command
        - base_contribution
        - arm_command
        - base_command_smoothed
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
    scenario = scenario.in_whole_steps()
    model = RobotModel(scenario.robot)
    period = scenario.period
    start = scenario.start_position(model)
    builder = DiagramBuilder()
    add = builder.AddNamedSystem

    wanted = maybe_compiled(scenario)

    decomposer = add("decomposer", decomposer or make_decomposers(scenario, model))
    smoother = add("smoother", wanted(CommandSmoother(scenario.smoother, period)))
    arm = add("arm", wanted(make_arm_inverse(scenario, model)))
    robot = add(
        "robot",
        make_robot(
            scenario.robot,
            start,
            period,
            scenario.fidelity,
            maybe_compiled=wanted,
        ),
    )

    ports = outputs([decomposer, smoother, arm, robot])
    if operator := operator_of(scenario):
        ports = add_operator(builder, scenario, operator, ports)
    else:
        ports |= add_guarded(builder, scenario)
    blocks = [decomposer, smoother, arm, robot]
    # Nobody pushes.
    connect_by_name(builder, ports, blocks, left_open=[signals.SPATIAL_FORCES])
    return build_and_export(builder, "teleop", ports, period, logged=logged)
