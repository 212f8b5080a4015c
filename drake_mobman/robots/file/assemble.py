"""A robot put together in a plant: its model, on a base that moves in the plane."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.tree import PrismaticJoint, RevoluteJoint, SpatialInertia

from drake_mobman.frames import INSTANCE
from drake_mobman.robot_model.rolling import RollingBase
from drake_mobman.robots.file.contents import PlatformLimits, RobotFile, limit_of
from drake_mobman.robots.file.layout import Layout
from drake_mobman.robots.file.loose import Loose
from drake_mobman.robots.file.model import Shapes
from drake_mobman.robots.file.parse import Mounted, Parsed, parse, take_away
from drake_mobman.robots.file.placement import Placement
from drake_mobman.robots.file.rolling import (
    axis_in_base,
    casters,
    turned_ahead,
)

_BASE_EFFORT = {"x": 1000.0, "y": 1000.0, "theta": 500.0}
"""Largest of the base [N], [N m]: those of the built-in TIAGo base."""


class Assembly:
    """Puts a robot together, in any number of plants.

    Args:
        contents: of its file.
        models: of its file.
        loose: the same, to look things up in.
        layout: of the model.
        placement: of the model.
    """

    def __init__(
        self,
        contents: RobotFile,
        models: Sequence[Mounted],
        loose: Loose,
        layout: Layout,
        placement: Placement,
    ) -> None:
        self._contents, self._models = contents, models
        self._loose, self._layout, self._placement = loose, layout, placement

    def add_to(self, plant: Any) -> list[Any]:
        """Adds the robot to a plant, moved in the plane; returns its instances."""
        ours = plant.AddModelInstance(INSTANCE)
        base = self._add_base(plant, ours)
        parsed = self._add_model(plant, ours, base, turning=())
        return [ours, *parsed.instances]

    def add_rolling_to(self, plant: Any, track: float) -> RollingBase:
        """Adds the robot to a plant, its base free and its wheels turning.

        Args:
            plant: not finalized.
            track: by which it turns [m].

        Raises:
            ParameterError: where its wheels do not roll ahead.
        """
        layout, loose = self._layout, self._loose
        ours = plant.AddModelInstance(INSTANCE)
        base = plant.AddRigidBody("base", ours, SpatialInertia.Zero())
        parsed = self._add_model(plant, ours, base, turning=layout.wheels)
        sides = []
        for side, names in (("left", layout.left), ("right", layout.right)):
            wheels = []
            for i, name in enumerate(names):
                key, axis = f"base.wheels.{side}[{i}]", axis_in_base(loose, name)
                joint = turned_ahead(plant, parsed.joints[name], axis, key)
                effort = parsed.efforts.get(name, 0.0) or np.inf
                plant.AddJointActuator(name, joint, effort)
                wheels.append(joint)
            sides.append(tuple(wheels))
        known = self._contents, loose, layout, self._placement
        radius = self._placement.wheel_radius
        assert radius is not None
        return RollingBase(
            instances=[ours, *parsed.instances],
            left=sides[0],
            right=sides[1],
            wheel_radius=radius.value,
            track=track,
            casters=casters(*known),
        )

    def _add_model(
        self, plant: Any, ours: Any, base: Any, turning: Sequence[str]
    ) -> Parsed:
        """Adds the model, on the base; only its arm and what is `turning` can move."""
        drawn = plant.geometry_source_is_registered()
        shapes = Shapes.DRAWN if drawn else Shapes.NONE
        parsed = parse(self._models, plant, shapes)
        layout, placement = self._layout, self._placement
        for constraint in plant.GetConstraintIds():
            plant.RemoveConstraint(constraint)
        for actuator in list(plant.GetJointActuatorIndices()):
            it = plant.get_joint_actuator(actuator)
            if it.model_instance() in parsed.instances:
                plant.RemoveJointActuator(it)
        for name, joint in parsed.joints.items():
            if name == layout.anchor:
                take_away(plant, joint)
            elif joint.num_velocities() and name not in {*layout.arm, *turning}:
                P, C = joint.frame_on_parent(), joint.frame_on_child()
                take_away(plant, joint)
                plant.WeldFrames(P, C, self._loose.X_FM(name))
        X_BF = placement.X_FB.value.inverse()
        plant.WeldFrames(base.body_frame(), parsed.frames[layout.base], X_BF)
        for name, frame, X in (
            ("tee", placement.tee.value, placement.X_T),
            ("tool", layout.tool, RigidTransform()),
        ):
            body = plant.AddRigidBody(name, ours, SpatialInertia.Zero())
            plant.WeldFrames(parsed.frames[frame], body.body_frame(), X)
        for name in layout.arm:
            self._limit(parsed.joints[name], name)
            effort = parsed.efforts.get(name, 0.0) or np.inf
            plant.AddJointActuator(name, parsed.joints[name], effort)
        return parsed

    def _limit(self, joint: Any, name: str) -> None:
        """Sets the limits of a joint of the arm."""
        limits = self._contents.limits
        given = limits.joint_velocity, limits.joint_acceleration
        own = joint.velocity_upper_limits()[0], joint.acceleration_upper_limits()[0]
        speed, acceleration = (
            np.full(1, limit_of(each, name, most))
            for each, most in zip(given, own, strict=True)
        )
        joint.set_velocity_limits(-speed, speed)
        joint.set_acceleration_limits(-acceleration, acceleration)

    def _add_base(self, plant: Any, ours: Any) -> Any:
        """Returns the body B, which joints x, y and theta move, with an actuator each.

        With its limits, which the robot's file gives.
        """
        limits: PlatformLimits = self._contents.base.limits
        linear = limits.speed, limits.acceleration
        angular = limits.yaw_rate, limits.yaw_acceleration
        parent = plant.world_body()
        for name, child, kind, axis, (speed, acceleration) in (
            ("x", "x_slide", PrismaticJoint, [1, 0, 0], linear),
            ("y", "y_slide", PrismaticJoint, [0, 1, 0], linear),
            ("theta", "base", RevoluteJoint, [0, 0, 1], angular),
        ):
            body = plant.AddRigidBody(child, ours, SpatialInertia.Zero())
            joint = kind(name, parent.body_frame(), body.body_frame(), axis)
            joint = plant.AddJoint(joint)
            joint.set_velocity_limits([-speed], [speed])
            joint.set_acceleration_limits([-acceleration], [acceleration])
            plant.AddJointActuator(name, joint, _BASE_EFFORT[name])
            parent = body
        return parent
