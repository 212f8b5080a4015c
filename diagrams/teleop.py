"""Tele-operation: the operator's command, split between base and arm.

source -> guard -> decomposer -> smoother -> robot, with the arm's inverse beside the
smoother.
"""

from typing import Any

from pydrake.systems.framework import Diagram, DiagramBuilder

from drake_mobman import signals
from drake_mobman.arm.closed_form_inverse import ClosedFormInverse
from drake_mobman.arm.damped_inverse import DampedInverse
from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.base.smoother import CommandSmoother
from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.decomposers.blending import Blending, BlendingDecomposer
from drake_mobman.decomposers.field import FieldDecomposer
from drake_mobman.decomposers.switching import Switching, SwitchingDecomposer
from drake_mobman.robots.model import RobotModel
from drake_mobman.robots.robot import make_robot
from drake_mobman.runs.scenario import Teleop
from drake_mobman.teleop.guard import CommandGuard
from drake_mobman.teleop.scripted import Script, ScriptedSource

from .wiring import as_wanted, connect_by_name, finished, outputs

DECOMPOSERS = {Blending: BlendingDecomposer, Switching: SwitchingDecomposer}
"""The block of each decomposer that splits by shares."""


def make_decomposer(scenario: Teleop) -> Any:
    """Returns the decomposer that the scenario names."""
    params, arm = scenario.decomposer, scenario.robot.arm()
    if isinstance(params, VelocityField):
        return FieldDecomposer(params, scenario.robot.reach(), arm)
    block = DECOMPOSERS[type(params)]
    return block(params, scenario.workspace, scenario.projection, arm.joints)


def make_arm_inverse(scenario: Teleop, model: RobotModel) -> Any:
    """Returns the arm's inverse: in closed form where the arm has one."""
    arm, period = scenario.robot.arm(), scenario.period
    if isinstance(arm, JacobianArm):
        return DampedInverse(arm, model.limits, period)
    return ClosedFormInverse(arm, model.limits, period, by=scenario.inverse)


def make_teleop_diagram(
    scenario: Teleop, *, decomposer: Any = None, logged: bool = True
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
    start = scenario.start_position(model)
    builder = DiagramBuilder()
    add = builder.AddNamedSystem

    wanted = as_wanted(scenario)

    guard = add("guard", CommandGuard(scenario.guard, period))
    decomposer = add("decomposer", decomposer or wanted(make_decomposer(scenario)))
    smoother = add("smoother", wanted(CommandSmoother(scenario.smoother, period)))
    arm = add("arm", wanted(make_arm_inverse(scenario, model)))
    robot = add(
        "robot",
        make_robot(
            scenario.robot,
            start,
            period,
            scenario.fidelity,
            as_wanted=wanted,
        ),
    )

    ports = outputs([guard, decomposer, smoother, arm, robot])
    connect_by_name(builder, ports, [decomposer, smoother, arm, robot])

    command = guard.GetInputPort(signals.EE_COMMAND)
    if isinstance(scenario.source, Script):
        source = add("source", ScriptedSource(scenario.source))
        builder.Connect(source.get_output_port(), command)
        ports[f"source.{signals.EE_COMMAND}"] = source.get_output_port()
    else:
        builder.ExportInput(command, signals.EE_COMMAND)
    return finished(builder, "teleop", ports, period, logged=logged)
