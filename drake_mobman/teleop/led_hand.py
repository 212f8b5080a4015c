"""A hand that holds the tool, or any point of the arm, and goes where it is led.

The spring, damper and bounded force of `guiding_hand.py`, led by an operator.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from drake_mobman import signals
from drake_mobman.guidance.applied_force import HOLD, Push
from drake_mobman.guidance.guiding_hand import Hand, Spring, hand_force
from drake_mobman.parameters import checked, checked_period
from drake_mobman.robot_model import RobotModel
from drake_mobman.teleop.drag import NOTHING, Drag, Dragged


def led_velocity(command: Any, workspace: Any, theta: float) -> list[float]:
    """Returns v_WH (3,) [m/s] that the operator commands.

    v_c along the reach, l omega_c across it, v_z up: the stick pulls the hand just as
    it steers the hand of a robot that is tele-operated.

    Args:
        command: `ee_command`.
        workspace: l [m], psi [rad], z [m].
        theta: heading of the base in W [rad].
    """
    v_c, omega_c, v_z = command
    l, psi, _ = workspace
    c, s = math.cos(theta + psi), math.sin(theta + psi)
    across = l * omega_c
    return [v_c * c - across * s, v_c * s + across * c, v_z]


def on_a_leash(p_WH: Sequence[float], p_WE: Sequence[float], most: float) -> Any:
    """Returns `p_WH` (3,), or the nearest to it within `most` of `p_WE` (3,) [m].

    A hand that pulls in vain does not run away from its tool, to tear at it later.
    """
    away = [H - E for H, E in zip(p_WH, p_WE, strict=True)]
    distance = math.hypot(*away)
    if distance <= most:
        return list(p_WH)
    return [E + x * most / distance for E, x in zip(p_WE, away, strict=True)]


def drag_velocity(
    p_WH: Sequence[float], p_WT: Sequence[float], max_speed: float, period: float
) -> list[float]:
    """Returns v_WH (3,) [m/s] of a hand that drags: straight to p_WT (3,) [m].

    It is there a period [s] on, if that is not faster than `max_speed` [m/s].
    """
    way = [T - H for T, H in zip(p_WT, p_WH, strict=True)]
    slower = max(1.0, math.hypot(*way) / (max_speed * period))
    return [x / period / slower for x in way]


class Lead(LeafSystem):
    """Works out where the led hand goes, and its force on what it holds.

    .. pydrake_system::

        name: Lead
        input_ports:
        - ee_command
        - drag
        - workspace
        - base_pose
        - tool_position
        - tool_velocity
        - robot_state
        output_ports:
        - hand_force
        - hand_position
        - hold

    All are states, renewed at the control ticks. The hand holds the tool, or the point
    that is dragged; it takes hold of either where that is.

    Args:
        params: of the hand at the tool.
        drag: of the hand that drags.
        model: of the robot.
        period: control period [s].

    Raises:
        ParameterError: where a parameter is not valid.
        RuntimeError: in a run, where the tool's state is not finite.
    """

    def __init__(
        self, params: Hand, drag: Drag, model: RobotModel, period: float
    ) -> None:
        super().__init__()
        self.params = checked(params)
        self.drag_params = checked(drag)
        self.model = model
        self.period = checked_period(period)
        declare = self.DeclareVectorInputPort
        self.command = declare(signals.EE_COMMAND, 3)
        self.drag = declare(signals.DRAG, len(NOTHING))
        self.workspace = declare(signals.EE_CYLINDRICAL, 3)
        self.base_pose = declare(signals.BASE_POSE, 3)
        self.tool_position = declare(signals.TOOL_POSITION, 3)
        self.tool_velocity = declare(signals.TOOL_VELOCITY, 3)
        plant = model.plant
        size = plant.num_positions() + plant.num_velocities()
        self.robot_state = declare(signals.ROBOT_STATE, size)
        self._at_tool = [float(plant.GetBodyByName("tool").index()), 0.0, 0.0, 0.0]
        first = params.path[0]
        # Groups of their own: an output of a state is one of a whole group.
        force = self.DeclareDiscreteState(3)
        position = self.DeclareDiscreteState(np.array([first.x, first.y, first.z]))
        hold = self.DeclareDiscreteState(np.array(self._at_tool))
        self.DeclareStateOutputPort(signals.HAND_FORCE, force)
        self.DeclareStateOutputPort(signals.HAND_POSITION, position)
        self.DeclareStateOutputPort(HOLD, hold)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._pull)

    def _pull(self, context: Any, state: Any) -> None:
        _, last, held = (
            context.get_discrete_state(i).value().tolist() for i in range(3)
        )
        dragged = Dragged(*self.drag.Eval(context).tolist())
        hold, spring, motion = self._held(context, dragged)
        p_WQ, v_WQ = (x.tolist() for x in motion)
        if hold != held:
            last = p_WQ
        v_WH = self._lead(context, last, dragged)
        led = [H + self.period * v for H, v in zip(last, v_WH, strict=True)]
        p_WH = on_a_leash(led, p_WQ, spring.max_force / spring.stiffness)
        force = hand_force(p_WQ, v_WQ, p_WH, v_WH, spring)
        for i, value in enumerate((force, p_WH, hold)):
            state.get_mutable_vector(i).SetFromVector(np.array(value))

    def _held(
        self, context: Any, dragged: Dragged
    ) -> tuple[list[float], Spring, tuple[Any, Any]]:
        """Returns what is held, how, and its position [m] and velocity [m/s] in W."""
        if not dragged.body:
            tool = self.tool_position.Eval(context), self.tool_velocity.Eval(context)
            return self._at_tool, self.params, tool
        body, p_BQ = int(dragged.body), dragged.p_BQ
        point = self.model.point_W(body, p_BQ, self.robot_state.Eval(context))
        return [dragged.body, *p_BQ], self.drag_params, point

    def _lead(self, context: Any, p_WH: list[float], dragged: Dragged) -> list[float]:
        """Returns v_WH (3,) [m/s], as the operator drags or commands."""
        x, y, theta = self.base_pose.Eval(context).tolist()
        if dragged.body:
            p_WT = dragged.to_x + x, dragged.to_y + y, dragged.to_z
            return drag_velocity(p_WH, p_WT, self.drag_params.max_speed, self.period)
        command = self.command.Eval(context).tolist()
        return led_velocity(command, self.workspace.Eval(context).tolist(), theta)


class LedHand(Diagram):
    """Pulls where an operator leads it, by a force held between control ticks.

    .. pydrake_system::

        name: LedHand
        input_ports:
        - ee_command
        - drag
        - workspace
        - base_pose
        - tool_position
        - tool_velocity
        - robot_state
        output_ports:
        - hand_force
        - hand_position
        - spatial_forces

    Commanded nothing, it holds the tool where it is. It goes no farther from what it
    holds than its spring makes use of. While another point is dragged, it lets go of
    the tool.

    Args:
        params: of the hand; it starts where its path does, and goes its own ways.
        drag: of the hand while it drags.
        model: of the robot.
        period: control period [s].

    Raises:
        ParameterError: where a parameter is not valid.
        RuntimeError: in a run, where the tool's state is not finite.
    """

    def __init__(
        self, params: Hand, drag: Drag, model: RobotModel, period: float
    ) -> None:
        super().__init__()
        builder = DiagramBuilder()
        lead = builder.AddNamedSystem("lead", Lead(params, drag, model, period))
        push = builder.AddNamedSystem("push", Push())
        for port in map(lead.get_input_port, range(lead.num_input_ports())):
            builder.ExportInput(port, port.get_name())
        for name in (HOLD, signals.HAND_FORCE):
            builder.Connect(lead.GetOutputPort(name), push.GetInputPort(name))
        for name in (signals.HAND_FORCE, signals.HAND_POSITION):
            builder.ExportOutput(lead.GetOutputPort(name), name)
        builder.ExportOutput(push.get_output_port(), signals.SPATIAL_FORCES)
        builder.BuildInto(self)
