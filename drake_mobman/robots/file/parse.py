"""A robot's models read into a plant by Drake, parts welded onto each other."""

import dataclasses as dc
import re
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.tree import FrameIndex

from drake_mobman.parameters import ParameterError
from drake_mobman.robots.file.drake_log import collected_complaints
from drake_mobman.robots.file.model import Mimic, Model, Shapes, refused
from drake_mobman.robots.file.names import found, named


class Mounted(NamedTuple):
    """A model, and where it goes on those before it."""

    model: Model
    frame: str = ""  # Link or frame that its root is welded to; "" for the first model.
    X: RigidTransform = RigidTransform()  # Pose of its root in that frame.


@dc.dataclass(frozen=True)
class Parsed:
    """A robot's models in a plant.

    A name that is not unique has its model's before it, `arm::joint_1`. All are in the
    order of the files, the same each time that these are parsed.
    """

    instances: list[Any]
    joints: dict[str, Any]
    frames: dict[str, Any]  # Those of links, too.
    efforts: dict[str, float]  # Of joints, as far as they are given [N m], [N].
    mimics: dict[str, Mimic]  # By joint.
    complaints: list[str]  # Of Drake, one line each.


def parse(models: Sequence[Mounted], plant: Any, shapes: Shapes) -> Parsed:
    """Returns models that were added to a plant.

    Args:
        models: to add; all but the first are welded to those before.
        plant: a `MultibodyPlant`, not finalized.
        shapes: that the models get.

    Raises:
        ParameterError: with a key from the robot file, where a model cannot be used.
    """
    instances: list[Any] = []
    complaints: list[str] = []
    of_model: list[tuple[Model, list[Any]]] = []
    for i, mounted in enumerate(models):
        key = f"parts[{i - 1}]" if i else ""
        try:
            added, told = _added(mounted.model, plant, shapes)
        except ParameterError as error:
            raise error.below(key) if key else error from None
        if i:
            _weld(plant, mounted, instances, added, key)
        complaints += told
        instances += added
        of_model.append((mounted.model, added))
    joints = joints_of(plant, instances)
    efforts: dict[str, float] = {}
    mimics: dict[str, Mimic] = {}
    for model, added in of_model:
        inside = {
            joint.name(): name
            for name, joint in joints.items()
            if joint.model_instance() in added
        }
        known = {n: x for n, x in model.efforts.items() if n in inside}
        efforts |= {inside[name]: effort for name, effort in known.items()}
        for name, mimic in model.mimics.items():
            if name in inside and mimic.joint in inside:
                mimics[inside[name]] = mimic._replace(joint=inside[mimic.joint])
    efforts = _efforts(plant, joints) | efforts
    frames = frames_of(plant, instances)
    return Parsed(instances, joints, frames, efforts, mimics, complaints)


def joints_of(plant: Any, instances: Sequence[Any]) -> dict[str, Any]:
    """Returns the joints of some model instances by their names."""
    found = [plant.get_joint(i) for it in instances for i in plant.GetJointIndices(it)]
    return named(plant, found)


def frames_of(plant: Any, instances: Sequence[Any]) -> dict[str, Any]:
    """Returns the frames of some model instances by their names."""
    frames = map(plant.get_frame, map(FrameIndex, range(plant.num_frames())))
    return named(plant, [x for x in frames if x.model_instance() in instances])


def roots(plant: Any, instances: Sequence[Any]) -> list[Any]:
    """Returns the bodies of some model instances that hang on no joint."""
    hanging = {joint.child_body().index() for joint in _all_joints(plant)}
    return [
        plant.get_body(index)
        for it in instances
        for index in plant.GetBodyIndices(it)
        if index not in hanging
    ]


def _added(model: Model, plant: Any, shapes: Shapes) -> tuple[list[Any], list[str]]:
    """Returns a model's instances, added to a plant, and what Drake complains about."""
    parser = Parser(plant)
    parser.SetAutoRenaming(True)
    for name, folder in model.packages.items():
        parser.package_map().Add(name, str(folder))
    text = model.text(shapes)
    with collected_complaints() as messages:
        try:
            added = parser.AddModelsFromString(text, model.kind)
        except (RuntimeError, ValueError, SystemExit) as error:
            raise refused(model.path, f"Drake says: {_one_line(str(error))}") from None
    return added, [_placed(message, text) for message in messages]


_PREFIX = re.compile(r"^<literal-string>[^:]*:(?:(\d+):)? *(?:warning|error): *")

_ELEMENT = re.compile(r"""<(link|joint|body) [^>]*?name=["']([^"']*)""")


def _one_line(message: str) -> str:
    return " ".join(_PREFIX.sub("", message).split())[:160]


def _placed(message: str, text: str) -> str:
    """Returns a complaint of Drake as `link NAME: ...`, as far as it has a line."""
    match = _PREFIX.match(message)
    lines = text.splitlines()[: int(match[1])] if match and match[1] else []
    places = _ELEMENT.findall("\n".join(lines))
    place = "{} {}: ".format(*places[-1]) if places else ""
    return place + _one_line(message)


def _weld(
    plant: Any, mounted: Mounted, before: list[Any], added: list[Any], key: str
) -> None:
    """Welds a part to a frame of the models before it."""
    frame = found(
        f"{key}.frame", mounted.frame, frames_of(plant, before), "a link or frame"
    )
    _free(plant, added)
    tops = roots(plant, added)
    if len(tops) != 1:
        names = ", ".join(top.name() for top in tops) or "none"
        valid = f"must have one root, and has {names}"
        raise ParameterError(f"{key}.model", mounted.model.path.name, valid)
    plant.WeldFrames(frame, tops[0].body_frame(), mounted.X)


def _free(plant: Any, instances: Sequence[Any]) -> None:
    """Takes models off the world, which they may be joined to."""
    for joint in _all_joints(plant):
        if joint.model_instance() in instances and on_world(plant, joint):
            take_away(plant, joint)


def on_world(plant: Any, joint: Any) -> bool:
    """Returns whether a joint is one on the world."""
    return joint.parent_body().index() == plant.world_body().index()


def take_away(plant: Any, joint: Any) -> None:
    """Removes a joint, with its actuator and all that holds it to others."""
    for index in plant.GetJointActuatorIndices():
        actuator = plant.get_joint_actuator(index)
        if actuator.joint().index() == joint.index():
            plant.RemoveJointActuator(actuator)
    plant.RemoveJoint(joint)


def _all_joints(plant: Any) -> Iterator[Any]:
    return map(plant.get_joint, list(plant.GetJointIndices()))


def _efforts(plant: Any, joints: dict[str, Any]) -> dict[str, float]:
    """Returns the largest efforts of actuators, by the names of their joints."""
    names = {joint.index(): name for name, joint in joints.items()}
    actuators = map(plant.get_joint_actuator, plant.GetJointActuatorIndices())
    return {
        names[x.joint().index()]: x.effort_limit()
        for x in actuators
        if x.joint().index() in names
    }
