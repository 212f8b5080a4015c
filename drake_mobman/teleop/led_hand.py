"""A hand that an operator steers, and that holds the tool or any point of the arm.

It pulls with the spring, the damper and the bounded force of `guiding_hand.py`.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from drake_mobman import signals
from drake_mobman.frames import body
from drake_mobman.guidance.applied_force import GRASPED_POINT, PointForce
from drake_mobman.guidance.guiding_hand import Hand, Spring, hand_force
from drake_mobman.parameters import checked, checked_period
from drake_mobman.robot_model.plant_motion import PlantMotion
from drake_mobman.scalars import Vector
from drake_mobman.teleop.drag import NOTHING, Drag, Dragged


def commanded_velocity(
    command: Vector, ee_cylindrical: Vector, theta: float
) -> list[float]:
    """Returns v_WH (3,) [m/s] that the operator commands.

    v_c along the reach, l omega_c across it, v_z up: the same stick moves the hand here
    and the end effector in teleoperation.

    Args:
        command: `ee_command` (3,).
        ee_cylindrical: l [m], psi [rad], z [m].
        theta: heading of the base in W [rad].
    """
    v_c, omega_c, v_z = command
    l, psi, _ = ee_cylindrical
    c, s = math.cos(theta + psi), math.sin(theta + psi)
    across = l * omega_c
    return [v_c * c - across * s, v_c * s + across * c, v_z]


def within_distance(
    p_WH: Sequence[float], p_WE: Sequence[float], limit: float
) -> list[float]:
    """Returns `p_WH` (3,), or the nearest point within `limit` of `p_WE` (3,) [m].

    So a hand whose tool does not follow does not move away, only to jerk at it later.
    """
    away = [H - E for H, E in zip(p_WH, p_WE, strict=True)]
    distance = math.hypot(*away)
    if distance <= limit:
        return list(p_WH)
    return [E + x * limit / distance for E, x in zip(p_WE, away, strict=True)]


def drag_velocity(
    p_WH: Sequence[float], p_WT: Sequence[float], max_speed: float, period: float
) -> list[float]:
    """Returns v_WH (3,) [m/s] of a hand that drags: straight to its target.

    Args:
        p_WH: position of the hand (3,) [m].
        p_WT: its target (3,) [m], reached after one period if `max_speed` allows it.
        max_speed: of the hand [m/s].
        period: control period [s].
    """
    away = [T - H for T, H in zip(p_WT, p_WH, strict=True)]
    slower = max(1.0, math.hypot(*away) / (max_speed * period))
    return [x / period / slower for x in away]


class SteeredGrasp(LeafSystem):
    """Computes where a steered hand goes, and its force on what it holds.

    .. pydrake_system::

        name: SteeredGrasp
        input_ports:
        - ee_command
        - drag
        - ee_cylindrical
        - base_pose
        - tool_position
        - tool_velocity
        - robot_state
        output_ports:
        - hand_force
        - hand_position
        - grasped_point

    All outputs are states, renewed at the control ticks. The hand holds the tool, or
    the point that is dragged; it takes hold of either where that is.

    Args:
        params: of the hand at the tool; it starts where its path starts.
        drag: of the hand while it drags another point.
        motion: of the plant that is simulated.
        period: control period [s].

    Raises:
        ParameterError: where a parameter is not valid.
        RuntimeError: in a run, where the tool's state is not finite.
    """

    def __init__(
        self, params: Hand, drag: Drag, motion: PlantMotion, period: float
    ) -> None:
        super().__init__()
        self.params = checked(params)
        self.drag_params = checked(drag)
        self.motion = motion
        self.period = checked_period(period)
        declare = self.DeclareVectorInputPort
        self.command = declare(signals.EE_COMMAND, 3)
        self.drag = declare(signals.DRAG, len(NOTHING))
        self.ee_cylindrical = declare(signals.EE_CYLINDRICAL, 3)
        self.base_pose = declare(signals.BASE_POSE, 3)
        self.tool_position = declare(signals.TOOL_POSITION, 3)
        self.tool_velocity = declare(signals.TOOL_VELOCITY, 3)
        plant = motion.plant
        size = plant.num_positions() + plant.num_velocities()
        self.robot_state = declare(signals.ROBOT_STATE, size)
        self._at_tool = [float(body(plant, "tool").index()), 0.0, 0.0, 0.0]
        first = params.path[0]
        # Three groups: a state output port puts out a whole group.
        force = self.DeclareDiscreteState(3)
        position = self.DeclareDiscreteState(np.array([first.x, first.y, first.z]))
        point = self.DeclareDiscreteState(np.array(self._at_tool))
        self.DeclareStateOutputPort(signals.HAND_FORCE, force)
        self.DeclareStateOutputPort(signals.HAND_POSITION, position)
        self.DeclareStateOutputPort(GRASPED_POINT, point)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._renew)

    def _renew(self, context: Any, state: Any) -> None:
        _, last, last_point = (
            context.get_discrete_state(i).value().tolist() for i in range(3)
        )
        dragged = Dragged(*self.drag.Eval(context).tolist())
        point, spring, motion = self._grasped(context, dragged)
        p_WQ, v_WQ = (x.tolist() for x in motion)
        if point != last_point:
            last = p_WQ
        v_WH = self._velocity(context, last, dragged)
        steered = [H + self.period * v for H, v in zip(last, v_WH, strict=True)]
        p_WH = within_distance(steered, p_WQ, spring.max_force / spring.stiffness)
        force = hand_force(p_WQ, v_WQ, p_WH, v_WH, spring)
        for i, value in enumerate((force, p_WH, point)):
            state.get_mutable_vector(i).SetFromVector(np.array(value))

    def _grasped(
        self, context: Any, dragged: Dragged
    ) -> tuple[list[float], Spring, tuple[Any, Any]]:
        """Returns the grasped point, the spring, and p_WQ [m] and v_WQ [m/s] of it."""
        if not dragged.body:
            tool = self.tool_position.Eval(context), self.tool_velocity.Eval(context)
            return self._at_tool, self.params, tool
        body, p_BQ = int(dragged.body), dragged.p_BQ
        point = self.motion.point_W(body, p_BQ, self.robot_state.Eval(context))
        return [dragged.body, *p_BQ], self.drag_params, point

    def _velocity(
        self, context: Any, p_WH: list[float], dragged: Dragged
    ) -> list[float]:
        """Returns v_WH (3,) [m/s], as the operator drags or commands."""
        x, y, theta = self.base_pose.Eval(context).tolist()
        if dragged.body:
            p_WT = dragged.to_x + x, dragged.to_y + y, dragged.to_z
            return drag_velocity(p_WH, p_WT, self.drag_params.max_speed, self.period)
        command, at = self.command.Eval(context), self.ee_cylindrical.Eval(context)
        return commanded_velocity(command.tolist(), at.tolist(), theta)


class LedHand(Diagram):
    """Pulls where an operator steers it, by a force constant between control ticks.

    .. pydrake_system::

        name: LedHand
        input_ports: [ee_command, drag, ee_cylindrical, base_pose, tool_position,
                      tool_velocity, robot_state]
        output_ports: [hand_force, hand_position, spatial_forces]

    Without a command, it holds the tool where it is. It moves no farther from what it
    holds than its spring needs for the largest force. While another point is dragged,
    it lets go of the tool.

    Args:
        params: of the hand at the tool, as of `SteeredGrasp`.
        drag: of the hand while it drags another point.
        motion: of the plant that is simulated.
        period: control period [s].

    Raises:
        ParameterError: as `SteeredGrasp`; in a run, `RuntimeError`, too.
    """

    def __init__(
        self, params: Hand, drag: Drag, motion: PlantMotion, period: float
    ) -> None:
        super().__init__()
        builder = DiagramBuilder()
        grasp = SteeredGrasp(params, drag, motion, period)
        builder.AddNamedSystem("grasp", grasp)
        force = builder.AddNamedSystem("point_force", PointForce())
        for port in map(grasp.get_input_port, range(grasp.num_input_ports())):
            builder.ExportInput(port, port.get_name())
        for name in (GRASPED_POINT, signals.HAND_FORCE):
            builder.Connect(grasp.GetOutputPort(name), force.GetInputPort(name))
        for name in (signals.HAND_FORCE, signals.HAND_POSITION):
            builder.ExportOutput(grasp.GetOutputPort(name), name)
        builder.ExportOutput(force.get_output_port(), signals.SPATIAL_FORCES)
        builder.BuildInto(self)
