"""Guidance by hand: a hand pulls the free arm, and the base comes along.

hand -> robot -> base controller -> smoother -> robot. The base is told by the arm's
joint angles alone.
"""

from pydrake.systems.framework import Diagram, DiagramBuilder

from drake_mobman.base.smoother import CommandSmoother
from drake_mobman.base.velocity_field import VelocityFieldController
from drake_mobman.guidance.guiding_hand import GuidingHand
from drake_mobman.guidance.tool_sensor import ToolSensor
from drake_mobman.robots.model import RobotModel
from drake_mobman.robots.robot import make_robot
from drake_mobman.runs.scenario import Guided

from .wiring import as_wanted, connect_by_name, finished, outputs


def make_guided_diagram(scenario: Guided, *, logged: bool = True) -> Diagram:
    """Returns the whole loop, from the guiding hand to the base that follows.

    .. pydrake_system::

        name: guided
        output_ports:
        - hand_force
        - hand_position
        - tool_position
        - tool_velocity
        - base_command
        - field_zone
        - base_sent
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
    model = RobotModel(scenario.robot)
    period = scenario.period
    start = scenario.start_position(model)
    tool = model.plant.GetBodyByName("tool").index()
    builder = DiagramBuilder()
    add = builder.AddNamedSystem

    hand = add("hand", GuidingHand(scenario.hand, period, tool))
    wanted = as_wanted(scenario)
    robot = add(
        "robot",
        make_robot(
            scenario.robot,
            start,
            period,
            scenario.fidelity,
            free_arm=True,
            as_wanted=wanted,
        ),
    )
    sensor = add("tool_sensor", ToolSensor(model))
    controller = VelocityFieldController(scenario.field, scenario.robot.reach())
    field = add("field", wanted(controller))
    smoother = add("smoother", wanted(CommandSmoother(scenario.smoother, period)))
    systems = [hand, robot, sensor, field, smoother]
    ports = outputs(systems)
    connect_by_name(builder, ports, systems)
    return finished(builder, "guided", ports, period, logged=logged)
