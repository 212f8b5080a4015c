"""Guidance by hand: a hand pulls the free arm, and the base comes along.

hand -> robot -> base controller -> smoother -> robot. The base is told by the arm's
joint angles alone. The hand goes along its path, or an operator, live or recorded,
leads it through the gate, and may choose between fields; where the gate stops the hand,
which then holds the tool where it is, the base stops too.
"""

from pydrake.systems.framework import Diagram, DiagramBuilder

from drake_mobman.base.smoother import CommandSmoother
from drake_mobman.base.velocity_field import VelocityFieldController
from drake_mobman.guidance.guiding_hand import GuidingHand
from drake_mobman.guidance.tool_sensor import ToolSensor
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.robot import make_robot
from drake_mobman.scenario.scenario import Guided
from drake_mobman.teleop.drag import Draggable
from drake_mobman.teleop.led_hand import LedHand

from .choice import make_choice
from .operator import add_operator, operator_of
from .wiring import build_and_export, connect_by_name, maybe_compiled, outputs


def make_guided_diagram(scenario: Guided, *, logged: bool = True) -> Diagram:
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
        - base_pose
        - base_velocity
        - arm_position
        - arm_velocity
        - workspace
        - p_BT

    Args:
        scenario: checked, as `load_scenario` returns it.
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

    operator = operator_of(scenario)
    wanted = maybe_compiled(scenario)
    if operator:
        hand = add("hand", LedHand(scenario.hand, scenario.drag, model, period))
    else:
        tool = model.plant.GetBodyByName("tool").index()
        pulling = GuidingHand(scenario.hand, period, tool, maybe_compiled=wanted)
        hand = add("hand", pulling)
    sensor = add("tool_sensor", ToolSensor(model))
    reach = scenario.robot.reach()
    fields = [
        wanted(VelocityFieldController(one, reach, model.limits))
        for one in (scenario.controllers if operator else [scenario.field])
    ]
    chosen = (
        make_choice(fields, scenario.transition, period) if fields[1:] else fields[0]
    )
    field = add("field", chosen)
    smoother = add("smoother", wanted(CommandSmoother(scenario.smoother, period)))
    # Last: blocks are updated in order, and Python that runs on is quicker.
    robot = add(
        "robot",
        make_robot(
            scenario.robot,
            start,
            period,
            scenario.fidelity,
            free_arm=True,
            maybe_compiled=wanted,
        ),
    )
    systems = [hand, robot, sensor, field, smoother]
    ports = outputs(systems)
    if operator:
        arm = Draggable(frozenset(model.arm_bodies.values()), scenario.drag)
        ports = add_operator(builder, scenario, operator, ports, arm)
    connect_by_name(builder, ports, systems)
    return build_and_export(builder, "guided", ports, period, logged=logged)
