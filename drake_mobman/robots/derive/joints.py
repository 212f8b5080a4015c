"""The joints between the base and the end effector."""

from collections.abc import Collection
from typing import Any

from drake_mobman.robots.derive.derived import Derived


def joints_between(plant: Any, base: Any, tool: Any) -> list[Any]:
    """Returns the movable joints from one body to another, from the first on.

    Those of the whole way from the root, where the first body is not on it.

    Args:
        plant: a `MultibodyPlant`, finalized or not.
        base: body at which to begin.
        tool: body at which to end.
    """
    joints = map(plant.get_joint, plant.GetJointIndices())
    above = {joint.child_body().index(): joint for joint in joints}
    way, body = [], tool
    while body.index() != base.index() and body.index() in above:
        joint = above[body.index()]
        way.append(joint)
        body = joint.parent_body()
    return [joint for joint in reversed(way) if joint.num_velocities()]


def arm_joints(
    plant: Any, base: Any, tool: Any, held: Collection[str]
) -> Derived[list[Any]]:
    """Returns the arm's joints: those from base to tool that are not held.

    Args:
        plant: a `MultibodyPlant`, finalized or not.
        base: body of the base.
        tool: body of the end effector.
        held: names of joints that are held.
    """
    way = joints_between(plant, base, tool)
    arm = [joint for joint in way if joint.name() not in held]
    kept = [joint.name() for joint in way if joint.name() in held]
    less = f", without {', '.join(kept)}" if kept else ""
    return Derived(arm, f"from {base.name()} to {tool.name()}{less}")
