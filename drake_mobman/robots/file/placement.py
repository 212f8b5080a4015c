"""Where B and T are in a model: what has to be known before a robot is put together."""

import dataclasses as dc

from pydrake.math import RigidTransform

from drake_mobman.robots.derive import Derived
from drake_mobman.robots.derive.body import body_radius
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
    body_radius: Derived[float]  # Of the base [m].
    wheel_radius: Derived[float] | None = None  # [m]; None for a base without wheels.
    track: Derived[float] | None = None  # Likewise [m].


def place(contents: RobotFile, model: Loose, layout: Layout) -> Placement:
    """Returns where B and T are, and puts the model's frame B there.

    Raises:
        ParameterError: where it cannot be told from the model.
    """
    F = model.parsed.frames[layout.base]
    radius = between = None
    why = GIVEN if contents.base.frame else f"{layout.base}, root of the model"
    X_FB = Derived(RigidTransform(), why)
    if layout.wheels:
        joints, context = model.parsed.joints, model.context
        left, right = ([joints[n] for n in x] for x in (layout.left, layout.right))
        given = contents.base.wheel_radius
        radius = Derived(given, GIVEN) if given is not None else _radius(model, left[0])
        X_FB = base_frame(context, left, right, radius.value, F)
        between = track(context, left, right, F)
        if contents.base.track is not None:
            between = Derived(contents.base.track, GIVEN)
    model.put_base(F, X_FB.value)
    named, X_T = _tee(contents, model, layout)
    body = _body_radius(contents, model, layout)
    return Placement(X_FB, named, X_T, body, radius, between)


def _radius(model: Loose, wheel: object) -> Derived[float]:
    return wheel_radius(model.plant, model.inspector, model.context, wheel)


def _tee(
    contents: RobotFile, model: Loose, layout: Layout
) -> tuple[Derived[str], RigidTransform]:
    """Returns the link or frame that T is fixed to, and its pose in that."""
    if contents.arm.tee:
        return Derived(contents.arm.tee, GIVEN), RigidTransform()
    arm = [model.parsed.joints[name] for name in layout.arm]
    tool = model.parsed.frames[layout.tool]
    point, source = tee(arm, model.context, tool)
    name = model.name_of(point.body.body_frame())
    return Derived(name, source), RigidTransform(point.p)


def _body_radius(contents: RobotFile, model: Loose, layout: Layout) -> Derived[float]:
    """Returns the radius of the base, with its wheels and what carries the arm."""
    if contents.base.body_radius is not None:
        return Derived(contents.base.body_radius, GIVEN)
    joints = model.parsed.joints
    first = joints[layout.arm[0]]
    way = model.way(first.parent_body())
    bodies = [joints[name].parent_body() for name in way]
    bodies += [joints[name].child_body() for name in layout.wheels]
    height = first.frame_on_child().CalcPose(model.context, model.B).translation()[2]
    return body_radius(
        model.plant,
        model.inspector,
        model.context,
        [*bodies, first.parent_body()],
        model.B,
        float(height),
    )
