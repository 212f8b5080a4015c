"""The base's radius, from the geometry of all that is fixed to it."""

from collections.abc import Sequence
from typing import Any

from drake_mobman.robots.derive.derived import Derived
from drake_mobman.robots.derive.extent import extents, shapes_of


def body_radius(
    plant: Any,
    inspector: Any,
    context: Any,
    bodies: Sequence[Any],
    B: Any,
    height: float,
) -> Derived[float]:
    """Returns the radius of the base about B's z axis [m]; 0 without geometry.

    Limbs that have joints of their own are no part of the base: a second arm, a head.
    What hangs over the arm's shoulder does not count either.

    Args:
        plant: finalized, with geometry, in which what is held still has its joint.
        inspector: of its `SceneGraph`.
        context: of the plant; joints that are held are where they are held.
        bodies: of which the base is made, with all that is fixed to them: the wheels,
            and those from the base up to that which carries the arm.
        B: frame of the base.
        height: of the arm's first joint above the floor [m].
    """
    parts = {x.index(): x for each in bodies for x in plant.GetBodiesWeldedTo(each)}
    found, kinds = [(0.0, "")], set()
    for _, part in sorted(parts.items()):
        shapes, kind = shapes_of(plant, inspector, context, part, B)
        low = [each.radius for each in extents(shapes) if each.lowest <= height]
        if low:
            found.append((max(low), part.name()))
            kinds.add(kind)
    radius, name = max(found)
    if not kinds:
        return Derived(0.0, "the base has no geometry")
    return Derived(radius, f"{' and '.join(sorted(kinds))}, furthest at {name}")
