"""A draft of a robot file: guessed, derived, and written out."""

import dataclasses as dc
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from drake_mobman.parameters import ParameterError
from drake_mobman.robots.draft.guess import guessed
from drake_mobman.robots.draft.write import written
from drake_mobman.robots.file.contents import Arm, Part, RobotFile
from drake_mobman.robots.file.packages import Packages

BASES = {"husky": "top_plate", "tiago_base": "deck", "waffle": "plate"}
"""Bases that come with the package, and the link of each that an arm stands on."""

_OURS = "package://drake_mobman"


class Mount(NamedTuple):
    """A base that an arm is mounted on, and where."""

    on: str = ""  # One of `BASES`, or a model; "" where the model has its own base.
    at: str = ""  # Link or frame of the base.
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)  # Place of the arm there [m].


def drafted(
    model: str, tool: str, packages: Mapping[str, str], mount: Mount = Mount()
) -> str:
    """Returns a robot file for a model, with all that is derived written out.

    Args:
        model: path or URI of the model.
        tool: link or frame of the end effector.
        packages: folders by name.
        mount: base of an arm that has none.

    Raises:
        ParameterError: where it cannot be used.
    """
    uri = portable(model, packages)
    contents = RobotFile(model=uri, packages=dict(packages), arm=Arm(tool=tool))
    if mount.on:
        base, frame = based_on(mount, packages)
        part = Part(model=uri, frame=frame, xyz=[*mount.xyz])
        contents = dc.replace(contents, model=base, parts=[part])
    elif mount.at:
        raise ParameterError("--at", mount.at, "needs a base; give --on too")
    return contents


def based_on(mount: Mount, packages: Mapping[str, str]) -> tuple[str, str]:
    """Returns the model of a base, and the link or frame that an arm stands on."""
    if mount.on in BASES:
        return f"{_OURS}/{mount.on}.urdf", mount.at or BASES[mount.on]
    if not mount.at:
        valid = f"must name a link or frame of {mount.on}"
        raise ParameterError("--at", mount.at, valid)
    return portable(mount.on, packages), mount.at


def portable(model: str, packages: Mapping[str, str]) -> str:
    """Returns a model's URI by its package, where it is in one; else its path."""
    if "://" in model:
        return model
    path = Path(model).absolute()
    known = Packages(packages, Path.cwd())
    for folder in path.parents:
        at = known.folder(folder.name) if folder.name else None
        if at is None or at.resolve() != folder.resolve():
            continue
        if not folder.is_relative_to(Path.cwd()):
            return f"package://{folder.name}/{path.relative_to(folder).as_posix()}"
    return str(path)
