"""The base's frame B, its track and its wheels' radius, from the driven wheels."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.geometry import Cylinder, Sphere
from pydrake.math import RigidTransform, RotationMatrix

from drake_mobman.parameters import ParameterError
from drake_mobman.robots.derive.derived import Derived
from drake_mobman.robots.derive.extent import Placed, extents, shapes_of
from drake_mobman.scalars import Matrix


def wheel_radius(
    plant: Any, inspector: Any, context: Any, joint: Any
) -> Derived[float]:
    """Returns the radius of a wheel [m], from its geometry.

    Args:
        plant: finalized, with geometry.
        inspector: of its `SceneGraph`.
        context: of the plant.
        joint: that the wheel turns about.

    Raises:
        ParameterError: where the wheel has no geometry.
    """
    body, axle = joint.child_body(), joint.frame_on_child()
    shapes, kind = shapes_of(plant, inspector, context, body, axle)
    round_ones = [x for x in shapes if isinstance(x.shape, Cylinder | Sphere)]
    if round_ones:
        largest = max(x.shape.radius() for x in round_ones)
        return Derived(largest, f"radius of {body.name()}, {kind}")
    to_axle = RigidTransform(
        RotationMatrix.MakeFromOneVector(joint.revolute_axis(), 2).inverse(), [0, 0, 0]
    )
    found = extents(Placed(x.shape, to_axle @ x.X) for x in shapes)
    if not found:
        valid = f"must be given, as {body.name()} has no geometry to tell it from"
        raise ParameterError("base.wheel_radius", None, valid)
    largest = max(each.width for each in found) / 2
    return Derived(largest, f"half the width of {body.name()}, {kind}")


def base_frame(
    context: Any, left: Sequence[Any], right: Sequence[Any], radius: float, frame: Any
) -> Derived[RigidTransform]:
    """Returns the pose of B in a frame of the model.

    B is on the floor midway between the wheels, its y axis from right to left.

    Args:
        context: of the finalized plant.
        left: joints of the driven wheels on the left.
        right: the same on the right.
        radius: of the wheels [m].
        frame: of the model, its z axis up.

    Raises:
        ParameterError: where the wheels on both sides are not apart.
    """
    on_left, on_right = (_middle(context, side, frame) for side in (left, right))
    y = (on_left - on_right) * [1, 1, 0]
    if not np.linalg.norm(y) > 0:
        valid = "must be on the other side of the base than base.wheels.right"
        raise ParameterError("base.wheels.left", [x.name() for x in left], valid)
    y /= np.linalg.norm(y)
    middle = (on_left + on_right) / 2 - [0, 0, radius]
    R = RotationMatrix(np.column_stack([np.cross(y, [0, 0, 1]), y, [0, 0, 1]]))
    count = len(left) + len(right)
    return Derived(RigidTransform(R, middle), f"midway between {count} driven wheels")


def track(
    context: Any, left: Sequence[Any], right: Sequence[Any], frame: Any
) -> Derived[float]:
    """Returns how far the driven wheels are apart [m]; arguments as `base_frame`."""
    between = _middle(context, left, frame) - _middle(context, right, frame)
    return Derived(
        float(np.hypot(*between[:2])), "distance of the wheels' joints, left to right"
    )


def _middle(context: Any, joints: Sequence[Any], frame: Any) -> Matrix:
    """Returns the middle (3,) of the wheels of some joints [m]."""
    poses = [joint.frame_on_child().CalcPose(context, frame) for joint in joints]
    return np.asarray(np.mean([X.translation() for X in poses], axis=0))
