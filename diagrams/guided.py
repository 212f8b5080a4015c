"""Guidance by hand: a hand pulls the free arm, and the base comes along.

hand -> robot -> base controller -> smoother -> robot. The base is told by the arm's
joint angles alone. The hand goes along its path, or an operator, live or recorded,
leads it through the gate, and may choose between fields; where the gate stops the hand,
which then holds the tool where it is, the base stops too.
"""

from typing import Any

from pydrake.systems.framework import Diagram, DiagramBuilder

from drake_mobman.guidance.guiding_hand import GuidingHand
from drake_mobman.guidance.tool_sensor import ToolSensor
from drake_mobman.robot_model import RobotSetup
from drake_mobman.scenario import Guided
from drake_mobman.teleop.drag import Draggable
from drake_mobman.teleop.led_hand import LedHand

from .choice import make_choice
from .operator import add_operator
from .wiring import build_and_export, connect_by_name, outputs


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
        - (all of the robot, but for robot_state)

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
    systems = [
        builder.AddNamedSystem(name, block)
        for name, block in {
            "hand": _hand(scenario, setup, led=source is not None),
            "tool_sensor": ToolSensor(model),
            "field": _field(scenario, setup, choice=source is not None),
            "smoother": setup.maybe_compiled(scenario.smoother.build(setup)),
            # Last: blocks are updated in order, and Python that runs on is quicker.
            "robot": scenario.build_robot(setup),
        }.items()
    ]
    ports = outputs(systems)
    if source is not None:
        arm = Draggable(frozenset(model.arm_bodies.values()), scenario.drag)
        ports = add_operator(builder, scenario, source, ports, arm)
    connect_by_name(builder, ports, systems)
    return build_and_export(builder, "guided", ports, period, logged=logged)


def _hand(scenario: Guided, setup: RobotSetup, *, led: bool) -> Any:
    """Returns the hand, which an operator leads, or which goes along its path."""
    if led:
        return LedHand(scenario.hand, scenario.drag, setup.model, setup.period)
    tool = setup.model.plant.GetBodyByName("tool").index()
    return GuidingHand(
        scenario.hand, setup.period, tool, maybe_compiled=setup.maybe_compiled
    )


def _field(scenario: Guided, setup: RobotSetup, *, choice: bool) -> Any:
    """Returns the scenario's base controller, or with a choice all that may drive."""
    params = scenario.controllers if choice else [scenario.field]
    blocks = [setup.maybe_compiled(one.build(setup)) for one in params]
    if not blocks[1:]:
        return blocks[0]
    return make_choice(blocks, scenario.transition, setup.period)
