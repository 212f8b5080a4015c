"""Which of a model's joints are arm and wheels, and where base and tool are."""

import dataclasses as dc
from typing import Any

from drake_mobman.parameters import ParameterError
from drake_mobman.robots.file.contents import Gripper, RobotFile
from drake_mobman.robots.file.loose import Loose
from drake_mobman.robots.file.names import found
from drake_mobman.schema import ALL

_MOVED = {"revolute", "prismatic"}
"""Types of joints that an arm may have."""


@dc.dataclass(frozen=True)
class Layout:
    """The roles of a model's joints and frames, by their names."""

    base: str  # Frame F of the base, x ahead and z up.
    tool: str  # Frame of E.
    arm: list[str]  # Joints, from the base on.
    left: list[str]  # Joints of driven wheels.
    right: list[str]  # The same.
    anchor: str  # Joint of the root with the world; "" where there is none.

    @property
    def wheels(self) -> list[str]:
        """Returns the joints of all driven wheels."""
        return [*self.left, *self.right]


def lay_out(contents: RobotFile, model: Loose) -> Layout:
    """Returns the roles of a model's joints and frames.

    Raises:
        ParameterError: where a name is none of the model's, or has no such role.
    """
    frames, joints = model.parsed.frames, model.parsed.joints
    tool = found("arm.tool", contents.arm.tool, frames, "a link or frame")
    root = model.root(tool.body())
    F = root.body_frame()
    if contents.base.frame:
        F = found("base.frame", contents.base.frame, frames, "a link or frame")
        if model.root(F.body()).index() != root.index():
            valid = "must be of the robot that the tool belongs to"
            raise ParameterError("base.frame", contents.base.frame, valid)
    arm = _arm(contents, model, F.body(), tool.body())
    left, right = _wheels(contents, model, arm)
    _check_names(contents, model, arm, [*left, *right])
    anchors = [n for n, x in joints.items() if x.child_body().index() == root.index()]
    names = {x.index(): name for name, x in frames.items()}
    return Layout(
        base=names[F.index()],
        tool=contents.arm.tool,
        arm=arm,
        left=left,
        right=right,
        anchor=next(iter(anchors), ""),
    )


def _arm(contents: RobotFile, model: Loose, base: Any, tool: Any) -> list[str]:
    """Returns the joints between base and tool that move, and are not held."""
    to_base, to_tool = model.way(base), model.way(tool)
    between = [name for name in to_tool if name not in to_base]
    joints = model.parsed.joints
    still = {*contents.held, *model.parsed.mimics}
    arm = [n for n in between if joints[n].num_velocities() and n not in still]
    name = contents.arm.tool
    if not arm:
        moved = [n for n in between if joints[n].num_velocities()]
        why = f"all of {', '.join(moved)} are held" if moved else "none is on the way"
        valid = f"must be moved by joints between base and tool; {why}"
        raise ParameterError("arm.tool", name, valid)
    for each in arm:
        kind = joints[each].type_name()
        if kind not in _MOVED:
            valid = f"its joint {each} is {kind}; must be revolute or prismatic"
            raise ParameterError("arm.tool", name, f"{valid}, or in `held`")
        _check_mass(contents, model, joints[each])
    return arm


def _check_mass(contents: RobotFile, model: Loose, joint: Any) -> None:
    """Raises `ParameterError` where a joint moves nothing that has a mass."""
    moved = model.plant.GetBodiesKinematicallyAffectedBy([joint.index()])
    if not sum(model.plant.get_body(i).default_mass() for i in moved) > 0:
        valid = f"what its joint {joint.name()} moves must have a mass"
        raise ParameterError("model", contents.model, valid)


def _wheels(
    contents: RobotFile, model: Loose, arm: list[str]
) -> tuple[list[str], list[str]]:
    """Returns the joints of the driven wheels on the left and on the right."""
    wheels = contents.base.wheels
    if wheels is None:
        return [], []
    turning = {n: x for n, x in model.parsed.joints.items() if x.num_velocities()}
    for side in ("left", "right"):
        for i, name in enumerate(getattr(wheels, side)):
            key = f"base.wheels.{side}[{i}]"
            joint = found(key, name, turning, "a joint that turns")
            if joint.type_name() != "revolute":
                valid = f"must be a joint that turns, and is {joint.type_name()}"
                raise ParameterError(key, name, valid)
            if name in arm:
                raise ParameterError(key, name, "must not be on the way to the tool")
    return wheels.left, wheels.right


def _check_names(
    contents: RobotFile, model: Loose, arm: list[str], wheels: list[str]
) -> None:
    """Raises `ParameterError` where a joint that is named has no such role."""
    for name in contents.held:
        if name in wheels:
            valid = "must not be held; it is a wheel that drives"
            raise ParameterError(f"held.{name}", contents.held[name], valid)
    known = dict.fromkeys(arm)
    for key in ("joint_acceleration", "joint_velocity"):
        for name in getattr(contents.limits, key):
            if name != ALL:
                found(f"limits.{key}.{name}", name, known, "a joint of the arm")
    if contents.gripper is not None:
        _check_gripper(contents.gripper, model, [*arm, *wheels])
    if contents.arm.posture:
        _check_posture(contents.arm.posture, model, arm)
    if contents.arm.tee:
        _check_tee(contents.arm.tee, model, arm)


def _check_gripper(gripper: Gripper, model: Loose, taken: list[str]) -> None:
    free = {n: x for n, x in model.parsed.joints.items() if n in model.held}
    for i, name in enumerate(gripper.joints):
        key = f"gripper.joints[{i}]"
        joint = found(key, name, free, "a joint that moves")
        if name in taken:
            raise ParameterError(key, name, "must not be a joint of arm or base")
        for at in ("open", "closed"):
            _check_range(f"gripper.{at}", getattr(gripper, at), name, joint)


def _check_posture(posture: list[float], model: Loose, arm: list[str]) -> None:
    if len(posture) != len(arm):
        valid = f"must be {len(arm)} positions, of {', '.join(arm)}"
        raise ParameterError("arm.posture", posture, valid)
    for i, (name, at) in enumerate(zip(arm, posture, strict=True)):
        _check_range(f"arm.posture[{i}]", at, name, model.parsed.joints[name])


def _check_range(key: str, at: float, name: str, joint: Any) -> None:
    low, high = joint.position_lower_limits()[0], joint.position_upper_limits()[0]
    if not low <= at <= high:
        valid = f"must be within [{low:g}, {high:g}], the range of {name}"
        raise ParameterError(key, at, valid)


def _check_tee(tee: str, model: Loose, arm: list[str]) -> None:
    frame = found("arm.tee", tee, model.parsed.frames, "a link or frame")
    if not {*model.way(frame.body())} & {*arm}:
        raise ParameterError("arm.tee", tee, "must be moved by the arm")
