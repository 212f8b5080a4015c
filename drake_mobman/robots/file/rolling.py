"""A robot from a file on its own wheels: which way they turn, and what else stands."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from pydrake.multibody.tree import RevoluteJoint

from drake_mobman.parameters import LENGTH, ParameterError
from drake_mobman.robot_model.rolling import Caster
from drake_mobman.robot_model.tipping import SupportPolygon
from drake_mobman.robots.derive import Derived
from drake_mobman.robots.derive.extent import extents, shapes_of
from drake_mobman.robots.derive.skid import skid_track, wheel_loads
from drake_mobman.robots.file.contents import RobotFile
from drake_mobman.robots.file.layout import Layout
from drake_mobman.robots.file.loose import Loose
from drake_mobman.robots.file.parse import take_away
from drake_mobman.robots.file.placement import Placement
from drake_mobman.robots.wheels import Wheels
from drake_mobman.robots.wheels.floor import GRAVITY, Floor
from drake_mobman.robots.wheels.tip_limits import Footing

_ACROSS = 0.99
"""Least cosine between a wheel's axis and the base's y axis."""

_ON_FLOOR = 0.008
"""Height below which a shape is taken to touch the floor [m]."""

_APART = 0.03
"""Least distance between two casters [m]; nearer ones are shapes of one."""

_RADIUS = 0.03
"""Of casters that the model does not show [m]."""


def turned_ahead(plant: Any, joint: Any, axis: Any, key: str) -> Any:
    """Returns a wheel's joint so that positive rates roll ahead.

    Args:
        plant: not finalized.
        joint: the model's; replaced where it turns the other way.
        axis: of the joint in B (3,).
        key: of the wheel in the robot file.

    Raises:
        ParameterError: where its axis is not across the base.
    """
    if abs(axis[1]) < _ACROSS:
        valid = "must turn about an axis across the base"
        raise ParameterError(key, joint.name(), valid)
    if axis[1] > 0:
        return joint
    name, own = joint.name(), joint.revolute_axis()
    P, C = joint.frame_on_parent(), joint.frame_on_child()
    take_away(plant, joint)
    return plant.AddJoint(RevoluteJoint(name, P, C, -own))


def axis_in_base(model: Loose, wheel: str) -> np.ndarray:
    """Returns the axis of a wheel in B (3,)."""
    joint = model.parsed.joints[wheel]
    X = joint.frame_on_parent().CalcPose(model.context, model.B)
    return np.asarray(X.rotation() @ joint.revolute_axis())


def acting_track(
    contents: RobotFile,
    model: Loose,
    layout: Layout,
    placement: Placement,
    centre: np.ndarray,
) -> Derived[float] | None:
    """Returns the track by which the base turns [m]; None where it has no wheels.

    With several wheels on a side, all of them scrub as the base turns: see `skid`.

    Args:
        contents: of the robot's file.
        model: of the robot.
        layout: of the model.
        placement: of the model.
        centre: of the robot's mass in B, from above (2,) [m].
    """
    track = placement.track
    if track is None or contents.base.track is not None or len(layout.left) == 1:
        return track
    places = wheel_places(model, layout)
    found = skid_track(places, wheel_loads(places, centre))
    how = f"scrub of {len(places)} wheels {track.value:.4g} m apart, as loaded"
    return Derived(found, f"{how} at the posture")


def wheel_places(model: Loose, layout: Layout) -> np.ndarray:
    """Returns where the driven wheels stand on the floor in B (N, 2) [m]."""
    frames = [model.parsed.joints[name].frame_on_child() for name in layout.wheels]
    poses = [frame.CalcPose(model.context, model.B) for frame in frames]
    return np.array([X.translation()[:2] for X in poses])


def footing(
    contents: RobotFile, model: Loose, layout: Layout, placement: Placement
) -> Footing:
    """Returns what the robot stands on: its wheels and casters, on a level floor."""
    others = casters(contents, model, layout, placement)
    points = [*wheel_places(model, layout), *((c.x, c.y) for c in others)]
    floor, margin = Floor(), Wheels().tip_margin
    grip = floor.friction * GRAVITY
    return Footing(SupportPolygon.of(points), floor.gravity_W(), grip, margin)


def casters(
    contents: RobotFile, model: Loose, layout: Layout, placement: Placement
) -> tuple[Caster, ...]:
    """Returns the casters: given, or what of the base touches the floor.

    Without any and with one axle, four at the corners of a square in the base.
    """
    if contents.base.casters:
        return tuple(Caster(c.x, c.y, c.radius) for c in contents.base.casters)
    found: list[Caster] = []
    for caster in _on_floor(model, layout):
        if all(np.hypot(caster.x - c.x, caster.y - c.y) > _APART for c in found):
            found.append(caster)
    if found or len(layout.left) > 1:
        return tuple(found)
    out = max(placement.body_radius.value, _RADIUS) * np.sqrt(0.5)
    corners = [(x, y) for x in (out, -out) for y in (out, -out)]
    return tuple(Caster(x, y, _RADIUS) for x, y in corners)


def _on_floor(model: Loose, layout: Layout) -> Iterator[Caster]:
    """Yields where shapes touch the floor that are not of a wheel that drives."""
    wheels = {*layout.wheels}
    bodies = {frame.body().index(): frame.body() for frame in _frames(model)}
    for _, body in sorted(bodies.items()):
        if wheels & {*model.way(body)}:
            continue
        shapes, _ = shapes_of(
            model.plant, model.inspector, model.context, body, model.B
        )
        for shape in shapes:
            for extent in extents([shape]):
                x, y, z = shape.X.translation()
                if abs(extent.lowest) < _ON_FLOOR and z > 0:
                    radius = float(np.clip(z, LENGTH.low, 10 * _RADIUS))
                    yield Caster(float(x), float(y), radius)


def _frames(model: Loose) -> Sequence[Any]:
    return list(model.parsed.frames.values())
