"""A robot file's contents with all that is derived filled in."""

import dataclasses as dc
from typing import Any

import numpy as np

from drake_mobman.robots.file import File
from drake_mobman.robots.file.contents import RobotFile, Workspace

_DIGITS = 4
"""After the point: a tenth of a millimetre, or of a milliradian."""


def filled(contents: RobotFile, robot: File) -> tuple[RobotFile, dict[str, str]]:
    """Returns contents with all that is derived, and where that is from, by its key.

    Args:
        contents: of a robot file.
        robot: of the same file.
    """
    placed, known = robot.described().placement, robot.resolved()
    base: dict[str, Any] = {"body_radius": known.body_radius}
    if placed.wheel_radius and placed.track:
        base |= {"wheel_radius": placed.wheel_radius, "track": placed.track}
    arm: dict[str, Any] = {"orientation": known.orientation, "posture": known.posture}
    limits = dc.asdict(known.workspace.value)
    why = {"workspace": known.workspace.source}
    # Not a radius of 0, of a base without geometry.
    why |= {f"base.{key}": x.source for key, x in base.items() if x.value > 0}
    why |= {f"arm.{key}": x.source for key, x in arm.items()}
    return (
        dc.replace(
            contents,
            base=_with(contents.base, base),
            arm=_with(contents.arm, arm),
            workspace=Workspace(**{key: _plain(x) for key, x in limits.items()}),
        ),
        why,
    )


def _with(params: Any, found: dict[str, Any]) -> Any:
    """Returns parameters with values that are derived."""
    values = {key: _plain(x.value) for key, x in found.items()}
    return dc.replace(params, **{key: x for key, x in values.items() if x})


def _plain(value: Any) -> Any:
    """Returns a value as it is written: numbers rounded, and none of numpy's."""
    if isinstance(value, str):
        return value
    if isinstance(value, np.ndarray | list):
        return [_plain(x) for x in value]
    return round(float(value), _DIGITS) + 0.0
