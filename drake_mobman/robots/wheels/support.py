"""What holds a robot up on its wheels: the polygon it stands on, the floor's force."""

from typing import Any

import numpy as np
from pydrake.symbolic import MakeVectorVariable, cos, if_then_else, sin
from pydrake.systems.framework import DiagramBuilder, LeafSystem, OutputPort
from pydrake.systems.primitives import (
    DiscreteTimeIntegrator,
    LinearSystem,
    MatrixGain,
    Multiplexer,
    SymbolicVectorSystem,
)

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


def add_floor_force(
    builder: DiagramBuilder, made: RollingPlant, period: float
) -> OutputPort:
    """Adds the signal `floor_force`, from the contact forces of the plant.

    They act on the six degrees of freedom of the base as one moment about B and one
    force: the zero-moment point is where the force alone makes that moment. Both are
    means over a period: what lasts for one step of the plant tips nothing over.
    """
    plant, floating = made.plant, made.floating
    instance = floating.model_instance()
    forces = made.stepped.get_generalized_contact_forces_output_port(instance)
    own = plant.GetVelocitiesFromArray(instance, np.arange(plant.num_velocities()))
    at = own.tolist().index(floating.velocity_start())
    select = builder.AddSystem(MatrixGain(np.eye(forces.size())[[at, at + 1, at + 5]]))
    total = builder.AddSystem(DiscreteTimeIntegrator(3, plant.time_step()))
    eye: Any = np.eye(3)
    # The state is the total at the last tick: y = (u - x) / period.
    mean = builder.AddSystem(
        LinearSystem(0 * eye, eye, -eye / period, eye / period, period)
    )
    state = made.stepped.get_state_output_port()
    both = builder.AddSystem(Multiplexer([3, state.size()]))
    told = MakeVectorVariable(3 + state.size(), "u")
    moment_x, moment_y, up = told[:3]
    yaw = told[3 + floating.position_start() + 2]
    held = if_then_else(up > _NO_FORCE, up, _NO_FORCE)
    x, y = -moment_y / held, moment_x / held
    c, s = cos(yaw), sin(yaw)
    output = [c * x + s * y, c * y - s * x, up]
    block = builder.AddSystem(SymbolicVectorSystem(input=told, output=output))
    builder.Connect(forces, select.get_input_port())
    builder.Connect(select.get_output_port(), total.get_input_port())
    builder.Connect(total.get_output_port(), mean.get_input_port())
    builder.Connect(mean.get_output_port(), both.get_input_port(0))
    builder.Connect(state, both.get_input_port(1))
    builder.Connect(both.get_output_port(), block.get_input_port())
    return block.get_output_port()


class TippedOverError(RuntimeError):
    """A robot on wheels has fallen."""


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
        TippedOverError: in a run, where the base leans too far.
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
            raise TippedOverError(f"the robot tips over: {leans}")
