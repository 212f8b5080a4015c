"""Teleoperation: the operator's command, split between base and arm.

source -> guard -> decomposer -> smoother -> robot, with the arm's inverse beside the
smoother, and an estimator that tells decomposer and arm how the base moves. A live or
recorded operator has a gate in place of the guard, and may choose between several
decomposers.
"""

from typing import Any

from pydrake.systems.framework import Diagram, DiagramBuilder

from drake_mobman import signals
from drake_mobman.decomposers.field import build_decomposer
from drake_mobman.robot_model import RobotSetup
from drake_mobman.scenario import Teleop
from drake_mobman.teleop.guard import CommandGuard

from .choice import make_choice
from .operator import add_operator
from .wiring import (
    Ports,
    add_blocks,
    add_source,
    build_and_export,
    connect_by_name,
    outputs,
)


def make_decomposers(scenario: Teleop, setup: RobotSetup, *, choice: bool) -> Any:
    """Returns the scenario's decomposer, or a choice of all its decomposers."""
    params = scenario.controllers if choice else [scenario.decomposer]
    blocks = [setup.maybe_compiled(build_decomposer(one, setup)) for one in params]
    if not blocks[1:]:
        return blocks[0]
    return make_choice(blocks, scenario.transition, setup.period)


def add_guarded(
    builder: DiagramBuilder,
    scenario: Teleop,
    setup: RobotSetup,
    source: Any,
    others: Ports,
) -> Ports:
    """Adds a source without an operator, and the guard; returns their outputs.

    Args:
        builder: to add to.
        scenario: of the guard.
        setup: of its robot.
        source: of commands.
        others: ports of the other blocks.
    """
    watched = signals.BASE_ASTRAY in others
    guard = CommandGuard(scenario.guard, setup.period, watched=watched)
    # A compiled guard would end the simulation where the command is not finite.
    guard = setup.maybe_compiled(guard) if scenario.source.finite else guard
    guard = builder.AddNamedSystem("guard", guard)
    add_source(builder, source)
    command = {signals.EE_COMMAND: source.get_output_port()}
    connect_by_name(builder, others | command, [guard])
    ports = outputs([guard])
    if scenario.source.finite:  # Only finite signals may be logged.
        ports[f"source.{signals.EE_COMMAND}"] = source.get_output_port()
    return ports


def controller_blocks(
    scenario: Teleop, setup: RobotSetup, decomposer: Any
) -> dict[str, Any]:
    """Returns the blocks between guard and robot, in the order of their updates."""
    return {
        "decomposer": decomposer,
        "smoother": setup.maybe_compiled(scenario.smoother.build(setup)),
        # Not compiled: an Expression cannot take what a sensor may say, as NaN.
        "estimator": scenario.estimate.build(setup.period),
        "arm": setup.maybe_compiled(scenario.robot.arm_inverse(setup)),
    }


def make_teleop_diagram(
    scenario: Teleop,
    setup: RobotSetup | None = None,
    *,
    decomposer: Any = None,
    logged: bool = True,
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
        - base_estimate
        - base_astray (where the estimate is by a sensor)
        - arm_velocity_command
        - arm_status
        - (all of the robot, except robot_state)

    Args:
        scenario: checked, as `load_scenario` returns it.
        setup: of its robot, `scenario.setup()` unless given.
        decomposer: a block to use instead of the scenario's, with the same ports.
        logged: whether every signal is logged each period, for `simulation.log`.

    Raises:
        ParameterError: where a block cannot work with its parameters.
    """
    scenario = scenario.in_whole_steps()
    setup = setup or scenario.setup()
    period = scenario.period
    source = scenario.source.build(period)
    operated = source.HasOutputPort(signals.OPERATOR_INPUT)
    decomposer = decomposer or make_decomposers(scenario, setup, choice=operated)
    builder = DiagramBuilder()
    blocks = controller_blocks(scenario, setup, decomposer)
    robot = {"robot": scenario.build_robot(setup)}
    systems = add_blocks(builder, blocks | robot)
    ports = outputs(systems)
    if operated:
        ports = add_operator(builder, scenario, source, ports)
    else:
        ports |= add_guarded(builder, scenario, setup, source, ports)
    # No hand pushes the robot.
    connect_by_name(builder, ports, systems, left_open=[signals.SPATIAL_FORCES])
    return build_and_export(builder, "teleop", ports, period, logged=logged)
