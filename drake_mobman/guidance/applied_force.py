"""A force at a point of a body, as a `MultibodyPlant` takes it."""

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


def add_fixed_point_force(
    builder: DiagramBuilder, force: OutputPort, body: Any, p_BE: Sequence[float]
) -> OutputPort:
    """Adds a force at one point, and returns its `ExternallyAppliedSpatialForce`s.

    Without Python: three of Drake's `Propeller`s push along the axes of W. They get an
    identity pose of the body, so that these are not the axes of the body.

    Args:
        builder: to add to.
        force: output port with the force (3,) in W [N].
        body: index in the plant of the body B.
        p_BE: the point in B (3,) [m].
    """
    mounts = [RigidTransform(RotationMatrix(R), p_BE) for R in _AXES]
    propellers = Propeller([PropellerInfo(body, X_BP) for X_BP in mounts])
    builder.AddNamedSystem("point_force", propellers)
    identity = ConstantValueSource(
        AbstractValue.Make([RigidTransform()] * (int(body) + 1))
    )
    builder.AddNamedSystem("identity", identity)
    builder.Connect(identity.get_output_port(), propellers.get_body_poses_input_port())
    builder.Connect(force, propellers.get_command_input_port())
    return propellers.get_spatial_forces_output_port()


GRASPED_POINT = "grasped_point"
"""4: index in the plant of the body B that the hand holds, and p_BQ [m], where."""


class PointForce(LeafSystem):
    """Applies a force at a point of a body, where both may change.

    .. pydrake_system::

        name: PointForce
        input_ports:
        - grasped_point
        - hand_force
        output_ports:
        - spatial_forces
    """

    def __init__(self) -> None:
        super().__init__()
        self.point = self.DeclareVectorInputPort(GRASPED_POINT, 4)
        self.force = self.DeclareVectorInputPort(signals.HAND_FORCE, 3)
        self.DeclareAbstractOutputPort(
            signals.SPATIAL_FORCES,
            lambda: Value([ExternallyAppliedSpatialForce()]),
            self._calc,
            prerequisites_of_calc={self.all_input_ports_ticket()},
        )

    def _calc(self, context: Any, output: Any) -> None:
        body, *p_BQ = self.point.Eval(context).tolist()
        applied = ExternallyAppliedSpatialForce()
        applied.body_index = BodyIndex(int(body))
        applied.p_BoBq_B = p_BQ
        applied.F_Bq_W = SpatialForce([0.0, 0.0, 0.0], self.force.Eval(context))
        output.set_value([applied])
