"""A robot file with its models: read once, as long as no file of it changes."""

import dataclasses as dc
import functools
from collections.abc import Sequence
from pathlib import Path

from pydrake.math import RigidTransform, RollPitchYaw

from drake_mobman.files import read_file
from drake_mobman.parameters import ParameterError, checked
from drake_mobman.robots.file.assemble import Assembly
from drake_mobman.robots.file.contents import RobotFile
from drake_mobman.robots.file.layout import Layout, lay_out
from drake_mobman.robots.file.loose import Loose, loose
from drake_mobman.robots.file.packages import Packages
from drake_mobman.robots.file.parse import Mounted
from drake_mobman.robots.file.placement import Placement, place
from drake_mobman.robots.file.read import read_model
from drake_mobman.schema import load_typed, load_yaml

_LARGEST = 1_000_000
"""Largest size of a robot file [bytes]."""


class RobotFileError(ParameterError):
    """A robot file that cannot be used; its key is one of that file."""

    def __init__(self, file: str, error: ParameterError) -> None:
        super().__init__(error.key, error.value, error.valid)
        self.args = (f"{file}: {self.args[0]}",)

    def below(self, parent: str) -> "RobotFileError":
        """Returns the error as it is, whatever the scenario's key of the file."""
        del parent
        return self


@dc.dataclass(frozen=True, eq=False)
class Described:
    """A robot file, and what is known of its model before anything is derived."""

    path: Path
    text: str  # Of the file.
    contents: RobotFile
    models: Sequence[Mounted]
    loose: Loose
    layout: Layout
    placement: Placement
    stamps: list[tuple[int, int]] = dc.field(default_factory=list)  # Of `files`.

    @property
    def assembly(self) -> Assembly:
        """Returns what puts the robot together."""
        return Assembly(
            self.contents, self.models, self.loose, self.layout, self.placement
        )

    def files(self) -> list[Path]:
        """Returns the files of its models, with those of their meshes."""
        files = [f for it in self.models for f in (it.model.path, *it.model.meshes)]
        return list(dict.fromkeys(files))


def described(path: Path) -> Described:
    """Returns a robot file with its models.

    Raises:
        RobotFileError: where it cannot be used.
    """
    try:
        text = _text(path)
        found = _described(path, text)
        if found.stamps != _stamps(found.files()):
            _described.cache_clear()
            found = _described(path, text)
    except RobotFileError:
        raise
    except ParameterError as error:
        raise RobotFileError(path.name, error) from None
    return found


def _text(path: Path) -> str:
    try:
        return read_file(path, _LARGEST).decode()
    except FileNotFoundError:
        raise ParameterError("path", str(path), "must be a robot file") from None
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise ParameterError("path", str(path), f"cannot be read; {why}") from None


@functools.lru_cache(maxsize=16)
def _described(path: Path, text: str) -> Described:
    contents = checked(load_typed(RobotFile, load_yaml(text)))
    models = models_of(contents, path.parent)
    model = loose(models, contents.held)
    layout = lay_out(contents, model)
    placement = place(contents, model, layout)
    found = Described(path, text, contents, models, model, layout, placement)
    return dc.replace(found, stamps=_stamps(found.files()))


def _stamps(files: Sequence[Path]) -> list[tuple[int, int]]:
    """Returns when files were changed last, and their sizes; shorter if one is gone."""
    there = (file.stat() for file in files if file.exists())
    return [(status.st_mtime_ns, status.st_size) for status in there]


def models_of(contents: RobotFile, folder: Path) -> list[Mounted]:
    """Returns the models of a robot file, each where it goes."""
    packages = Packages(contents.packages, folder)
    packages.check()
    models = [Mounted(read_model(contents.model, packages, folder))]
    for i, part in enumerate(contents.parts):
        try:
            model = read_model(part.model, packages, folder)
        except ParameterError as error:
            raise error.below(f"parts[{i}]") from None
        X = RigidTransform(RollPitchYaw(part.rpy), part.xyz)
        models.append(Mounted(model, part.frame, X))
    return models
