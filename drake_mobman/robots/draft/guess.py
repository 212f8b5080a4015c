"""A robot file's contents, guessed from a model and the link of its tool."""

import dataclasses as dc
from collections.abc import Sequence
from typing import Any

from drake_mobman.arm.jacobian_arm import LEVEL
from drake_mobman.robots.draft.wheels import driven_wheels, wheel_speeds
from drake_mobman.robots.file.contents import Gripper, RobotFile
from drake_mobman.robots.file.loose import Loose
from drake_mobman.robots.file.names import found

_MOST = 4
"""Joints of a gripper that follow no other; with more, it is a hand of its own."""

_LIMB = 3
"""Least number of joints of other limbs that make a trunk of what carries them."""

_HALF = 0.5
"""Where a lift is held, as a share of its range."""


@dc.dataclass(frozen=True)
class Guess:
    """The contents of a robot file, and why they are so, by key."""

    contents: RobotFile
    why: dict[str, str]


def guessed(contents: RobotFile, model: Loose) -> Guess:
    """Returns the contents of a robot file, completed by what its model shows.

    Its driven wheels, what lifts the arm, and its gripper. A lift is held: with it, an
    arm reaches further up and down, but no faster than the lift. So is a trunk, which
    would take the other arm and the head along.

    Args:
        contents: with model and tool.
        model: the same, as it comes.

    Raises:
        ParameterError: where there is no such tool.
    """
    frames, joints = model.parsed.frames, model.parsed.joints
    tool = found("arm.tool", contents.arm.tool, frames, "a link or frame")
    way = model.way(tool.body())
    base = model.root(tool.body()).body_frame()
    why: dict[str, str] = {}
    wheels = driven_wheels(model, base, way)
    if wheels.left:
        contents = _with(contents, "base", wheels=wheels)
        why["base.wheels"] = "turn on and on about an axis across, in pairs"
        limits = wheel_speeds(model, wheels, base)
        if limits:
            contents = _with(contents, "base", limits=limits)
            why["base.limits"] = "speeds as fast as the wheels turn"
    else:
        contents = _with(contents, "base", frame=_name(frames, base))
        why["base.frame"] = "root of the model, which has no wheels that drive"
    lifting = lifts(model, way)
    held = {name: _middle(joints[name]) for name in lifting}
    carrying = [name for name in trunk(model, way) if name not in held]
    held |= {name: _zero(joints[name]) for name in carrying}
    if held:
        contents = dc.replace(contents, held=held | contents.held)
        lifted = ["lifts the arm; take it out for a lift that moves"] * bool(lifting)
        carried = ["carries other limbs with the arm"] * bool(carrying)
        why["held"] = ", or ".join(lifted + carried)
    gripper = gripper_of(model, way)
    if gripper:
        contents = dc.replace(contents, gripper=gripper)
        why["gripper"] = "moves beyond the arm"
    return Guess(contents, why)


def lifts(model: Loose, way: Sequence[str]) -> list[str]:
    """Returns the joints on the way to the tool that slide before the first turns."""
    found = []
    for name in way:
        kind = model.parsed.joints[name].type_name()
        if kind == "revolute":
            break
        if kind == "prismatic":
            found.append(name)
    return found


def trunk(model: Loose, way: Sequence[str]) -> list[str]:
    """Returns the joints on the way to the tool that carry other limbs as well.

    Up to the last from which a limb goes off and the arm goes on with all the joints
    that a level end effector takes.
    """
    joints, mimics = model.parsed.joints, model.parsed.mimics
    arm = [name for name in way if joints[name].num_velocities()]
    last = max(len(arm) - LEVEL, 0)
    carried = [0] * last
    for name, joint in joints.items():
        if name in {*way, *mimics} or not joint.num_velocities():
            continue
        shared = [x for x in model.way(joint.parent_body()) if x in arm]
        if 0 < len(shared) <= last:
            carried[len(shared) - 1] += 1
    ends = [k + 1 for k in range(last) if sum(carried[k:]) >= _LIMB]
    return arm[: max(ends, default=0)]


def gripper_of(model: Loose, way: Sequence[str]) -> Gripper | None:
    """Returns the gripper: joints beyond the arm that follow no other.

    It is closed where its joints are at rest. None where there are no such joints, or
    where they have no one range that all are in.
    """
    joints = model.parsed.joints
    arm = [name for name in way if joints[name].num_velocities()]
    fingers = [
        name
        for name, joint in joints.items()
        if name not in {*arm, *model.parsed.mimics}
        and joint.type_name() in {"revolute", "prismatic"}
        and arm[-1:] == [x for x in model.way(joint.parent_body()) if x in arm][-1:]
    ]
    if not 0 < len(fingers) <= _MOST:
        return None
    low = max(float(joints[n].position_lower_limits()[0]) for n in fingers)
    high = min(float(joints[n].position_upper_limits()[0]) for n in fingers)
    closed = min(max(0.0, low), high)
    at_end = high if high - closed >= closed - low else low
    if not low < high or not abs(at_end) < 100.0:
        return None
    return Gripper(fingers, round(at_end, 4), round(closed, 4))


def _middle(joint: Any) -> float:
    low, high = joint.position_lower_limits()[0], joint.position_upper_limits()[0]
    return round(float(low + _HALF * (high - low)), 4)


def _zero(joint: Any) -> float:
    low, high = joint.position_lower_limits()[0], joint.position_upper_limits()[0]
    return round(float(min(max(0.0, low), high)), 4)


def _name(frames: dict[str, Any], frame: Any) -> str:
    return next(name for name, x in frames.items() if x.index() == frame.index())


def _with(contents: RobotFile, key: str, **changes: Any) -> RobotFile:
    return dc.replace(contents, **{key: dc.replace(getattr(contents, key), **changes)})
