"""Guidance by hand: a hand pulls the free arm, and the base follows.

hand -> robot -> base controller -> smoother -> robot. The base depends on the arm's
joint angles alone. The hand moves along its path; or a live or recorded operator moves
it through the gate, and may choose between base controllers. Where the gate stops the
hand, the hand holds the tool in place and the base stops too.
"""

from typing import Any

from pydrake.systems.framework import Diagram, DiagramBuilder

from drake_mobman import signals
from drake_mobman.frames import body
from drake_mobman.guidance.guiding_hand import GuidingHand
from drake_mobman.guidance.tool_sensor import ToolSensor
from drake_mobman.robot_model import RobotSetup
from drake_mobman.robot_model.plant_motion import PlantMotion
from drake_mobman.scenario import Guided
from drake_mobman.teleop.drag import Draggable
from drake_mobman.teleop.led_hand import LedHand

from .choice import make_choice
from .operator import add_operator
from .wiring import add_blocks, build_and_export, connect_by_name, outputs


def make_guided_diagram(
    scenario: Guided, setup: RobotSetup | None = None, *, logged: bool = True
) -> Diagram:
    """Returns the whole loop, from the guiding hand to the base that follows.

    .. pydrake_system::

        name: guided
        input_ports:
        - operator_input (only where the scenario's source is Operator)
        output_ports:
        - operator_input, ee_command, guard_status, gate_status, gate_arming, drag,
          field.base_command (where the source is Operator or Recording)
        - handover (where there are alternatives to choose from)
        - hand_force
        - hand_position
        - tool_position
        - tool_velocity
        - base_command
        - field_zone
        - base_command_smoothed
        - (all of the robot, except robot_state)

    Args:
        scenario: checked, as `load_scenario` returns it.
        setup: of its robot, `scenario.setup()` unless given.
        logged: whether every signal is logged each period, for `simulation.log`.

    Raises:
        ParameterError: where a block cannot work with its parameters.
    """
    scenario = scenario.in_whole_steps()
    setup = setup or scenario.setup()
    model, period = setup.model, scenario.period
    source = scenario.source.build(period)
    builder = DiagramBuilder()
    motion = PlantMotion(scenario.bare_plant())
    robot = scenario.build_robot(setup)
    blocks = {
        "hand": _hand(scenario, setup, motion, operated=source is not None),
        "tool_sensor": ToolSensor(motion),
        "field": _field(scenario, setup, choice=source is not None),
        "smoother": setup.maybe_compiled(scenario.smoother.build(setup)),
        # Last: blocks are updated in order, and all Python in a row is faster.
        "robot": robot,
    }
    if robot.HasOutputPort(signals.TOOL_POSITION):
        del blocks["tool_sensor"]
    systems = add_blocks(builder, blocks)
    ports = outputs(systems)
    if source is not None:
        arm = Draggable(frozenset(model.arm_bodies.values()), scenario.drag)
        ports = add_operator(builder, scenario, source, ports, arm)
    connect_by_name(builder, ports, systems)
    return build_and_export(builder, "guided", ports, period, logged=logged)


def _hand(
    scenario: Guided, setup: RobotSetup, motion: PlantMotion, *, operated: bool
) -> Any:
    """Returns the hand, which an operator moves, or which moves along its path."""
    if operated:
        return LedHand(scenario.hand, scenario.drag, motion, setup.period)
    tool = body(motion.plant, "tool").index()
    return GuidingHand(
        scenario.hand, setup.period, tool, maybe_compiled=setup.maybe_compiled
    )


def _field(scenario: Guided, setup: RobotSetup, *, choice: bool) -> Any:
    """Returns the scenario's base controller, or a choice of all its controllers."""
    params = scenario.controllers if choice else [scenario.field]
    blocks = [setup.maybe_compiled(one.build(setup)) for one in params]
    if not blocks[1:]:
        return blocks[0]
    return make_choice(blocks, scenario.transition, setup.period)
