"""What to know of a robot before it is driven, in one line each."""

import math
from collections.abc import Iterator

from drake_mobman.robots.derive.field import body_edge
from drake_mobman.robots.derive.posture import TILTED
from drake_mobman.robots.file.described import Described
from drake_mobman.robots.file.resolved import Resolved

_LIMITS = ("velocity", "acceleration")


def warnings(robot: Described, known: Resolved) -> list[str]:
    """Returns lines on what a robot's model lacks, and on what may not be as meant."""
    found = *_limits(robot), *_chain(robot), *_posture(known), *_body(known)
    return list(found)


def _limits(robot: Described) -> Iterator[str]:
    """Yields lines on joints whose limits the model does not have."""
    for key in _LIMITS:
        given = getattr(robot.contents.limits, f"joint_{key}")
        none: dict[str, list[str]] = {}
        for name in robot.layout.arm:
            joint = robot.loose.parsed.joints[name]
            own = float(getattr(joint, f"{key}_upper_limits")()[0])
            if name not in given and not 0 < own < math.inf:
                none.setdefault("is 0" if own == 0 else "is missing", []).append(name)
        for how, names in none.items():
            yield (
                f"limits: the model's {key} limit {how} for {', '.join(names)}; "
                f"limits.joint_{key} holds"
            )


def _chain(robot: Described) -> Iterator[str]:
    """Yields a line on joints between base and tool that are held."""
    model, layout = robot.loose, robot.layout
    way = model.way(model.parsed.frames[layout.tool].body())
    first = way.index(layout.arm[0])
    held = [
        name
        for name in way[first:]
        if model.parsed.joints[name].num_velocities() and name not in layout.arm
    ]
    if held:
        yield f"arm: {', '.join(held)} between its joints is held"


def _posture(known: Resolved) -> Iterator[str]:
    """Yields lines on a posture that is not as it should be."""
    if known.arm.level and known.posture.source.endswith(TILTED):
        yield "arm: the tool cannot be level, ahead or down; it keeps its tilt"
    if known.arm.is_near_singular(known.arm.posture):
        yield "arm.posture: the arm is near a singularity, and slow there"


def _body(known: Resolved) -> Iterator[str]:
    """Yields lines on a body that the wrist may touch."""
    if not known.body_radius.value:
        yield "base.body_radius: unknown, as the base has no geometry"
    edge = body_edge(known.reach.value, known.body_radius.value)
    b_d = known.field.value.b_d
    if b_d < edge:
        yield (
            f"field: b_d = {b_d:.3g} m is inside the body, whose edge is {edge:.3g} m "
            "from the shoulder; the wrist may pass over it"
        )
