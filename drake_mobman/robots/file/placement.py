"""Where B and T are in a model: what has to be known before a robot is put together."""

import dataclasses as dc

from pydrake.math import RigidTransform

from drake_mobman.robots.derive import Derived
from drake_mobman.robots.derive.tee import tee
from drake_mobman.robots.derive.wheels import base_frame, track, wheel_radius
from drake_mobman.robots.file.contents import RobotFile
from drake_mobman.robots.file.layout import Layout
from drake_mobman.robots.file.loose import Loose

GIVEN = "given"
"""Source of what the robot file has."""


@dc.dataclass(frozen=True)
class Placement:
    """Where B and T are in a model, and its wheels, with where each is from."""

    X_FB: Derived[RigidTransform]  # Pose of B in the frame F of the base.
    tee: Derived[str]  # Link or frame that T is fixed to.
    X_T: RigidTransform  # Pose of T in that.
    wheel_radius: Derived[float] | None = None  # None for a base without wheels.
    track: Derived[float] | None = None  # Likewise.


def place(contents: RobotFile, model: Loose, layout: Layout) -> Placement:
    """Returns where B and T are.

    Raises:
        ParameterError: where it cannot be told from the model.
    """
    named, X_T = _tee(contents, model, layout)
    if not layout.wheels:
        why = GIVEN if contents.base.frame else f"{layout.base}, root of the model"
        return Placement(Derived(RigidTransform(), why), named, X_T)
    joints, context = model.parsed.joints, model.context
    F = model.parsed.frames[layout.base]
    left, right = ([joints[n] for n in side] for side in (layout.left, layout.right))
    given = contents.base.wheel_radius
    radius = Derived(given, GIVEN) if given is not None else _radius(model, left[0])
    X_FB = base_frame(context, left, right, radius.value, F)
    between = track(context, left, right, F)
    if contents.base.track is not None:
        between = Derived(contents.base.track, GIVEN)
    return Placement(X_FB, named, X_T, radius, between)


def _radius(model: Loose, wheel: object) -> Derived[float]:
    return wheel_radius(model.plant, model.inspector, model.context, wheel)


def _tee(
    contents: RobotFile, model: Loose, layout: Layout
) -> tuple[Derived[str], RigidTransform]:
    """Returns the link or frame that T is fixed to, and its pose in that."""
    if contents.arm.tee:
        return Derived(contents.arm.tee, GIVEN), RigidTransform()
    frames, joints = model.parsed.frames, model.parsed.joints
    arm = [joints[name] for name in layout.arm]
    point, source = tee(arm, model.context, frames[layout.tool])
    names = {x.index(): name for name, x in frames.items()}
    name = names[point.body.body_frame().index()]
    return Derived(name, source), RigidTransform(point.p)
