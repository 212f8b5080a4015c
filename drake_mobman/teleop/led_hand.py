"""A hand that holds the tool and goes where an operator leads it.

The spring, damper and bounded force of `guiding_hand.py`, without its path.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from drake_mobman import signals
from drake_mobman.guidance.guiding_hand import Hand, hand_force
from drake_mobman.guidance.push import add_push
from drake_mobman.parameters import checked, checked_period


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


class Lead(LeafSystem):
    """Works out where the led hand goes, and its force on the tool.

    .. pydrake_system::

        name: Lead
        input_ports:
        - ee_command
        - workspace
        - base_pose
        - tool_position
        - tool_velocity
        output_ports:
        - hand_force
        - hand_position

    Both are states, renewed at the control ticks.

    Args:
        params: of the hand.
        period: control period [s].

    Raises:
        ParameterError: where a parameter is not valid.
        RuntimeError: in a run, where the tool's state is not finite.
    """

    def __init__(self, params: Hand, period: float) -> None:
        super().__init__()
        self.params = checked(params)
        self.period = checked_period(period)
        declare = self.DeclareVectorInputPort
        self.command = declare(signals.EE_COMMAND, 3)
        self.workspace = declare(signals.WORKSPACE, 3)
        self.base_pose = declare(signals.BASE_POSE, 3)
        self.tool_position = declare(signals.TOOL_POSITION, 3)
        self.tool_velocity = declare(signals.TOOL_VELOCITY, 3)
        first = params.path[0]
        # Two groups: an output of a state is one of a whole group.
        force = self.DeclareDiscreteState(3)
        position = self.DeclareDiscreteState(np.array([first.x, first.y, first.z]))
        self.DeclareStateOutputPort(signals.HAND_FORCE, force)
        self.DeclareStateOutputPort(signals.HAND_POSITION, position)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._pull)

    def _pull(self, context: Any, state: Any) -> None:
        v_WH = led_velocity(
            self.command.Eval(context).tolist(),
            self.workspace.Eval(context).tolist(),
            float(self.base_pose.Eval(context)[2]),
        )
        last = context.get_discrete_state(1).value().tolist()
        p_WE = self.tool_position.Eval(context).tolist()
        led = [H + self.period * v for H, v in zip(last, v_WH, strict=True)]
        most = self.params.max_force / self.params.stiffness
        p_WH = on_a_leash(led, p_WE, most)
        v_WE = self.tool_velocity.Eval(context).tolist()
        force = hand_force(p_WE, v_WE, p_WH, v_WH, self.params)
        state.get_mutable_vector(0).SetFromVector(np.array(force))
        state.get_mutable_vector(1).SetFromVector(np.array(p_WH))


class LedHand(Diagram):
    """Pulls the tool where an operator leads it, by a force held between control ticks.

    .. pydrake_system::

        name: LedHand
        input_ports:
        - ee_command
        - workspace
        - base_pose
        - tool_position
        - tool_velocity
        output_ports:
        - hand_force
        - hand_position
        - spatial_forces

    Commanded nothing, it holds the tool where it is. It goes no farther from the tool
    than its spring makes use of.

    Args:
        params: of the hand; it starts where its path does, and goes its own ways.
        period: control period [s].
        body: index in the plant of the body whose origin the tool is.

    Raises:
        ParameterError: where a parameter is not valid.
        RuntimeError: in a run, where the tool's state is not finite.
    """

    def __init__(self, params: Hand, period: float, body: Any) -> None:
        super().__init__()
        builder = DiagramBuilder()
        lead = builder.AddNamedSystem("lead", Lead(params, period))
        for port in map(lead.get_input_port, range(lead.num_input_ports())):
            builder.ExportInput(port, port.get_name())
        for port in map(lead.get_output_port, range(lead.num_output_ports())):
            builder.ExportOutput(port, port.get_name())
        force = lead.GetOutputPort(signals.HAND_FORCE)
        forces = add_push(builder, force, body, (0.0, 0.0, 0.0))
        builder.ExportOutput(forces, signals.SPATIAL_FORCES)
        builder.BuildInto(self)
