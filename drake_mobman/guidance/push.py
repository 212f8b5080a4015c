"""A force in the world, as a `MultibodyPlant` takes it, made without Python."""

from collections.abc import Sequence
from typing import Any

from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import Propeller, PropellerInfo
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import ConstantValueSource

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

    Of Drake's own `Propeller`s, one for each axis of W. Told that the body never turns,
    they push along W's axes instead of the body's.

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
