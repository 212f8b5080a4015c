"""Joints of a robot's base that a fidelity takes away, by Drake's own calls."""

from collections.abc import Sequence
from typing import Any

from drake_mobman.robot_model.rolling import Caster, RollingBase

WHEELS = ("left_wheel", "right_wheel")
"""Joints of the driven wheels of robots with two."""

_SLIDES = ("x", "y")


def remove_joint(plant: Any, joint: Any) -> None:
    """Removes a joint and its actuators from a plant that is not finalized."""
    for actuator in map(plant.get_joint_actuator, plant.GetJointActuatorIndices()):
        if actuator.joint().index() == joint.index():
            plant.RemoveJointActuator(actuator)
    plant.RemoveJoint(joint)


def weld_joint(plant: Any, joint: Any) -> None:
    """Replaces a joint by a weld, at its zero."""
    parent, child = joint.frame_on_parent(), joint.frame_on_child()
    remove_joint(plant, joint)
    plant.WeldFrames(parent, child)


def weld_wheels(plant: Any) -> None:
    """Welds the wheels of a robot whose base is moved by x, y and theta."""
    for name in WHEELS:
        weld_joint(plant, plant.GetJointByName(name))


def free_base(plant: Any) -> None:
    """Takes a base off its joints x, y and theta; the slides stay, in the world."""
    for name in _SLIDES:
        weld_joint(plant, plant.GetJointByName(name))
    remove_joint(plant, plant.GetJointByName("theta"))


def rolling_base(
    plant: Any, instances: list[Any], casters: Sequence[tuple[float, float, float]]
) -> RollingBase:
    """Frees the base of a robot with joints `left_wheel` and `right_wheel`.

    Their radius and track are those of where the wheels are on the base.

    Args:
        plant: not finalized.
        instances: the robot's.
        casters: x, y and radius of each [m].
    """
    left, right = (plant.GetJointByName(name) for name in WHEELS)
    p_left, p_right = (
        joint.frame_on_parent().GetFixedPoseInBodyFrame().translation()
        for joint in (left, right)
    )
    free_base(plant)
    return RollingBase(
        instances=instances,
        left=(left,),
        right=(right,),
        wheel_radius=float(p_left[2]),
        track=float(p_left[1] - p_right[1]),
        casters=tuple(Caster(*each) for each in casters),
    )
