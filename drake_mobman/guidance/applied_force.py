"""A force in the world, as a `MultibodyPlant` takes it."""

from collections.abc import Sequence
from typing import Any

from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import (
    ExternallyAppliedSpatialForce,
    Propeller,
    PropellerInfo,
)
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import DiagramBuilder, LeafSystem, OutputPort
from pydrake.systems.primitives import ConstantValueSource

from drake_mobman import signals

_AXES = (
    [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
    [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
)
"""Frames whose z axes are W's x, y and z."""


def add_push(
    builder: DiagramBuilder, force: OutputPort, body: Any, p_BE: Sequence[float]
) -> OutputPort:
    """Adds what pushes a body, and returns its `ExternallyAppliedSpatialForce`s.

    Without Python, of Drake's own `Propeller`s, one for each axis of W. Told that the
    body never turns, they push along W's axes instead of the body's.

    Args:
        builder: to add to.
        force: puts out the force (3,) in W [N].
        body: index in the plant of the body B that is pushed.
        p_BE: where, in B (3,) [m].
    """
    mounts = [RigidTransform(RotationMatrix(R), p_BE) for R in _AXES]
    push = Propeller([PropellerInfo(body, X_BP) for X_BP in mounts])
    builder.AddNamedSystem("push", push)
    unturned = ConstantValueSource(
        AbstractValue.Make([RigidTransform()] * (int(body) + 1))
    )
    builder.AddNamedSystem("unturned", unturned)
    builder.Connect(unturned.get_output_port(), push.get_body_poses_input_port())
    builder.Connect(force, push.get_command_input_port())
    return push.get_spatial_forces_output_port()


HOLD = "hold"
"""4: index in the plant of the body B that is held, and p_BQ [m], where."""


class Push(LeafSystem):
    """Pushes whatever body is held, where it is held.

    .. pydrake_system::

        name: Push
        input_ports:
        - hold
        - hand_force
        output_ports:
        - spatial_forces
    """

    def __init__(self) -> None:
        super().__init__()
        self.hold = self.DeclareVectorInputPort(HOLD, 4)
        self.force = self.DeclareVectorInputPort(signals.HAND_FORCE, 3)
        self.DeclareAbstractOutputPort(
            signals.SPATIAL_FORCES,
            lambda: Value([ExternallyAppliedSpatialForce()]),
            self._calc,
            prerequisites_of_calc={self.all_input_ports_ticket()},
        )

    def _calc(self, context: Any, output: Any) -> None:
        body, *p_BQ = self.hold.Eval(context).tolist()
        push = ExternallyAppliedSpatialForce()
        push.body_index = BodyIndex(int(body))
        push.p_BoBq_B = p_BQ
        push.F_Bq_W = SpatialForce([0.0, 0.0, 0.0], self.force.Eval(context))
        output.set_value([push])
