"""A draft of a robot file: guessed, derived, and written out."""

import dataclasses as dc
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from drake_mobman.parameters import ParameterError
from drake_mobman.robots.draft.fill import filled
from drake_mobman.robots.draft.guess import guessed
from drake_mobman.robots.draft.write import written
from drake_mobman.robots.file import File
from drake_mobman.robots.file.contents import Arm, Part, RobotFile
from drake_mobman.robots.file.described import models_of
from drake_mobman.robots.file.loose import loose
from drake_mobman.robots.file.packages import Packages
from drake_mobman.scenario_files import ROBOT

BASES = {"husky": "top_plate", "tiago_base": "deck", "waffle": "plate"}
"""Bases that come with the package, and the link of each that an arm stands on."""

_OURS = "package://drake_mobman"

_TITLE = (
    "A draft of a robot file. What stands here with a remark is derived from the "
    "model: take a line out to have it derived anew, or change it."
)


class Mount(NamedTuple):
    """A base that an arm is mounted on, and where."""

    on: str = ""  # One of `BASES`, or a model; "" where the model has its own base.
    at: str = ""  # Link or frame of the base.
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)  # Place of the arm there [m].


def drafted(
    model: str,
    tool: str,
    packages: Mapping[str, str] | None = None,
    mount: Mount | None = None,
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
    contents = mounted(model, tool, packages or {}, mount or Mount())
    models = models_of(contents, Path.cwd())
    guess = guessed(contents, loose(models, contents.held))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"draft{ROBOT}"
        file.write_text(written(guess.contents, {}, ""), "utf-8")
        robot = File(str(file))
        robot.check()
        full, why = filled(guess.contents, robot)
    return written(full, guess.why | why, _TITLE)


def mounted(
    model: str, tool: str, packages: Mapping[str, str], mount: Mount
) -> RobotFile:
    """Returns the contents of a robot file for a model, on a base or by itself."""
    uri = portable(model, packages)
    contents = RobotFile(model=uri, packages=dict(packages), arm=Arm(tool=tool))
    if not mount.on:
        if mount.at:
            raise ParameterError("--at", mount.at, "needs a base; give --on too")
        return contents
    base, frame = _base(mount, packages)
    part = Part(model=uri, frame=frame, xyz=[*mount.xyz])
    return dc.replace(contents, model=base, parts=[part])


def _base(mount: Mount, packages: Mapping[str, str]) -> tuple[str, str]:
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
    path, known = Path(model).absolute(), Packages(packages, Path.cwd())
    for folder in path.parents[:-1]:
        if folder.is_relative_to(Path.cwd()) and folder.name not in packages:
            continue  # What is just here is no package.
        found = known.folder(folder.name)
        if found is not None and found.resolve() == folder.resolve():
            return f"package://{folder.name}/{path.relative_to(folder).as_posix()}"
    return str(path)
