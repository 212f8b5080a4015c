"""What holds a robot up on its wheels: the polygon it stands on, the floor's force."""

from typing import Any

import numpy as np
from pydrake.symbolic import MakeVectorVariable, cos, if_then_else, sin
from pydrake.systems.framework import DiagramBuilder, LeafSystem, OutputPort
from pydrake.systems.primitives import Multiplexer, SymbolicVectorSystem

from drake_mobman.robot_model.tipping import SupportPolygon
from drake_mobman.robots.wheels.plant import RollingPlant

_NO_FORCE = 1.0
"""Force of the floor below which the robot flies [N]."""

_LEANS = 0.5
"""Angle at which a base has tipped over and will not come back [rad]."""


def support_polygon(made: RollingPlant) -> SupportPolygon:
    """Returns the polygon of a robot's wheels and casters, upright."""
    context = made.plant.CreateDefaultContext()
    made.plant.SetPositions(context, np.zeros(made.plant.num_positions()))
    B = made.floating.frame_on_child()
    return SupportPolygon.of(
        [
            contact.body.body_frame().CalcPose(context, B).multiply(contact.p_BC)[:2]
            for contact in made.contacts
        ]
    )


def add_floor_force(builder: DiagramBuilder, made: RollingPlant) -> OutputPort:
    """Adds the signal `floor_force`, from the contact forces of the plant.

    They act on the six degrees of freedom of the base as one moment about B and one
    force: the zero-moment point is where the force alone makes that moment.
    """
    plant, floating = made.plant, made.floating
    instance = floating.model_instance()
    forces = plant.get_generalized_contact_forces_output_port(instance)
    state = plant.get_state_output_port()
    both = builder.AddSystem(Multiplexer([state.size(), forces.size()]))
    builder.Connect(state, both.get_input_port(0))
    builder.Connect(forces, both.get_input_port(1))
    told = MakeVectorVariable(state.size() + forces.size(), "u")
    places = np.arange(plant.num_velocities())
    own = plant.GetVelocitiesFromArray(instance, places).tolist()
    at = state.size() + own.index(floating.velocity_start())
    moment_x, moment_y, _, _, _, up = told[at : at + 6]
    yaw = told[floating.position_start() + 2]
    held = if_then_else(up > _NO_FORCE, up, _NO_FORCE)
    x, y = -moment_y / held, moment_x / held
    c, s = cos(yaw), sin(yaw)
    output = [c * x + s * y, c * y - s * x, up]
    block = builder.AddSystem(SymbolicVectorSystem(input=told, output=output))
    builder.Connect(both.get_output_port(), block.get_input_port())
    return block.get_output_port()


class Upright(LeafSystem):
    """Ends a run in which the robot tips over: what comes after means nothing.

    .. pydrake_system::

        name: Upright
        input_ports:
        - state

    Args:
        made: the robot's plant, whose state it looks at.
        period: between two looks [s].

    Raises:
        RuntimeError: in a run, where the base leans too far.
    """

    def __init__(self, made: RollingPlant, period: float) -> None:
        super().__init__()
        self._at = made.floating.position_start()
        size = made.plant.num_positions() + made.plant.num_velocities()
        self.state = self.DeclareVectorInputPort("state", size)
        self.DeclarePeriodicPublishEvent(period, 0.0, self._look)

    def _look(self, context: Any) -> None:
        roll, pitch = self.state.Eval(context)[self._at : self._at + 2]
        if not max(abs(roll), abs(pitch)) < _LEANS:
            leans = f"its base rolls by {roll:.2g} and pitches by {pitch:.2g} rad"
            raise RuntimeError(f"the robot tips over: {leans}")
