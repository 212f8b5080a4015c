"""The model as it comes, in a plant of its own, to look things up in."""

import dataclasses as dc
from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame

from drake_mobman.frames import INSTANCE
from drake_mobman.parameters import ParameterError
from drake_mobman.robots.file.model import Shapes
from drake_mobman.robots.file.names import found
from drake_mobman.robots.file.parse import Mounted, Parsed, on_world, parse, roots


@dc.dataclass(frozen=True)
class Loose:
    """A finalized plant of the model with all its joints; nothing is held or added."""

    plant: Any
    parsed: Parsed
    inspector: Any  # Of its geometry: outlines.
    context: Any  # With each joint at its `held` position.
    held: dict[str, float]  # Where joints are unless they are driven [rad], [m].
    B: Any  # Frame of the base, once it is put where it is.

    def way(self, body: Any) -> list[str]:
        """Returns the names of the joints on the way to a body, from its root on.

        A joint that holds the root to the world is not on it.
        """
        above = {x.child_body().index(): n for n, x in self.parsed.joints.items()}
        names: list[str] = []
        while body.index() in above:
            joint = self.parsed.joints[above[body.index()]]
            if on_world(self.plant, joint):
                break
            names.insert(0, above[body.index()])
            body = joint.parent_body()
        return names

    def root(self, body: Any) -> Any:
        """Returns the body that the way to a body begins at."""
        way = self.way(body)
        return self.parsed.joints[way[0]].parent_body() if way else body

    def name_of(self, frame: Any) -> str:
        """Returns the name of a frame, as `Parsed` has it."""
        frames = self.parsed.frames.items()
        return next(n for n, x in frames if x.index() == frame.index())

    def put_base(self, F: Any, X_FB: RigidTransform) -> None:
        """Puts the frame B to a pose in a frame F, at the joints' positions."""
        X_WF = F.CalcPoseInWorld(self.context)
        self.B.SetPoseInParentFrame(self.context, X_WF @ X_FB)

    def X_FM(self, joint: str) -> RigidTransform:
        """Returns the pose of a joint's child frame in its parent frame."""
        it = self.parsed.joints[joint]
        return it.frame_on_child().CalcPose(self.context, it.frame_on_parent())


def loose(models: Sequence[Mounted], held: dict[str, float]) -> Loose:
    """Returns the model of a robot file, as it comes.

    Args:
        models: of the file.
        held: where joints are held [rad], [m].

    Raises:
        ParameterError: where a model cannot be used, or a joint cannot be held.
    """
    plant, scene_graph = MultibodyPlant(0.0), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    parsed = parse(models, plant, Shapes.OUTLINE)
    tops = roots(plant, parsed.instances)
    if len(tops) > 1:
        names = ", ".join(top.name() for top in tops[:5])
        valid = f"its links must all be joined; apart from each other are {names}"
        raise ParameterError("model", models[0].model.path.name, valid)
    place = FixedOffsetFrame(f"{INSTANCE}::B", plant.world_frame(), RigidTransform())
    B = plant.AddFrame(place)
    try:
        plant.Finalize()
    except RuntimeError as error:
        valid = "its links must not form a loop"
        if "loop" not in str(error):
            valid = f"Drake says: {' '.join(str(error).split())[:160]}"
        raise ParameterError("model", models[0].model.path.name, valid) from None
    positions = _held(parsed, held)
    context = plant.CreateDefaultContext()
    q = plant.GetPositions(context)
    for name, at in positions.items():
        q[parsed.joints[name].position_start()] = at
    plant.SetPositions(context, q)
    inspector = scene_graph.model_inspector()
    return Loose(plant, parsed, inspector, context, positions, B)


def _held(parsed: Parsed, held: dict[str, float]) -> dict[str, float]:
    """Returns the positions of all joints of one degree of freedom.

    As given, or as they follow another; else 0, or what is nearest to it in range.
    """
    single = {n: x for n, x in parsed.joints.items() if x.num_positions() == 1}
    for name, at in held.items():
        joint = found(f"held.{name}", name, single, "a joint that moves")
        low, high = _range(joint)
        if not low <= at <= high:
            valid = f"must be within the joint's [{low:g}, {high:g}]"
            raise ParameterError(f"held.{name}", at, valid)
    positions = {n: float(np.clip(0.0, *_range(x))) for n, x in single.items()} | held
    for _ in range(3):  # A joint may follow one that follows another.
        for name, mimic in parsed.mimics.items():
            if name in single and name not in held and mimic.joint in positions:
                at = mimic.multiplier * positions[mimic.joint] + mimic.offset
                positions[name] = at
    return positions


def _range(joint: Any) -> tuple[float, float]:
    return joint.position_lower_limits()[0], joint.position_upper_limits()[0]
