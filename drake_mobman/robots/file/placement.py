"""Where B and T are in a model: what has to be known before a robot is put together."""

import dataclasses as dc

from pydrake.math import RigidTransform

from drake_mobman.robots.derive.body import body_radius
from drake_mobman.robots.derive.derived import Derived
from drake_mobman.robots.derive.tee import tee
from drake_mobman.robots.derive.wheels import base_frame, track, wheel_radius
from drake_mobman.robots.file.contents import RobotFile
from drake_mobman.robots.file.layout import Layout
from drake_mobman.robots.file.loose import Loose

GIVEN = "given"
"""Source of what the robot file says."""


@dc.dataclass(frozen=True)
class Placement:
    """Where B and T are in a model, and the base's sizes."""

    X_FB: Derived[RigidTransform]  # Pose of B in the frame F of the base.
    wheel_radius: Derived[float] | None  # [m]; None without wheels.
    track: Derived[float] | None  # [m]; None without wheels.
    body_radius: Derived[float]  # [m].
    tee: str  # Body that T is fixed to.
    X_T: Derived[RigidTransform]  # Pose of T in that body.


def place(contents: RobotFile, model: Loose, layout: Layout) -> Placement:
    """Returns where B and T are, and the base's sizes.

    Raises:
        ParameterError: where it cannot be told from the model.
    """
    given, joints = contents.base, model.parsed.joints
    F = model.parsed.frames[layout.base]
    left, right = ([joints[n] for n in side] for side in (layout.left, layout.right))
    source = f"frame of {layout.base}"
    X_FB = Derived(RigidTransform(), source)
    radius = apart = None
    if layout.wheels:
        if given.wheel_radius is not None:
            radius = Derived(given.wheel_radius, GIVEN)
        else:
            radius = wheel_radius(model.plant, model.inspector, model.context, left[0])
        X_FB = base_frame(model.context, left, right, radius.value, F)
        apart = track(model.context, left, right, F)
        if given.track is not None:
            apart = Derived(given.track, GIVEN)
    model.put_base(F, X_FB.value)
    body, X_T = _tee(contents, model, layout)
    return Placement(
        X_FB=X_FB,
        wheel_radius=radius,
        track=apart,
        body_radius=_body_radius(contents, model, layout),
        tee=body,
        X_T=X_T,
    )


def _tee(
    contents: RobotFile, model: Loose, layout: Layout
) -> tuple[str, Derived[RigidTransform]]:
    """Returns the name of the frame that T is fixed to, and its pose in that."""
    if contents.arm.tee:
        return contents.arm.tee, Derived(RigidTransform(), GIVEN)
    joints = [model.parsed.joints[name] for name in layout.arm]
    found = tee(joints, model.context, model.parsed.frames[layout.tool])
    body, p = found.value
    return model.name_of(body.body_frame()), Derived(RigidTransform(p), found.source)


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
