"""The wrist's centre T, where the axes of the wrist meet or come nearest."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from drake_mobman.arm.axes import axis, distance, nearest_on
from drake_mobman.arm.jacobian_arm import LEVEL
from drake_mobman.robots.derive.derived import Derived
from drake_mobman.scalars import Matrix

_MEET = 1e-4
"""Distance up to which two axes are said to meet [m]."""


class OnBody(NamedTuple):
    """A point that is fixed to a body."""

    body: Any
    p: Matrix  # From the body's origin, in its axes (3,) [m].


def tee(joints: Sequence[Any], context: Any, tool: Any) -> Derived[OnBody]:
    """Returns T: the point of the last axis but two that is nearest to the next.

    The last three joints then turn E about T and do not move it. An arm of fewer than
    six joints has no such wrist: T is E.

    Args:
        joints: of the arm, from the base on.
        context: of the finalized plant.
        tool: frame of E.
    """
    wrist = joints[-3:]
    if len(joints) < LEVEL or any(x.type_name() != "revolute" for x in wrist):
        X = tool.GetFixedPoseInBodyFrame()
        return Derived(OnBody(tool.body(), X.translation()), "E, as there is no wrist")
    body = wrist[0].parent_body()
    first, second = (axis(each, context, body.body_frame()) for each in wrist[:2])
    gap, names = distance(first, second), f"{wrist[0].name()} and {wrist[1].name()}"
    how = "meet" if gap < _MEET else f"come nearest ({1e3 * gap:.0f} mm)"
    point = nearest_on(first, second)
    return Derived(OnBody(body, point), f"where the axes of {names} {how}")
