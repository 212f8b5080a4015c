"""A robot's model, as Drake's parser takes it."""

import dataclasses as dc
import enum
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from drake_mobman.parameters import ParameterError
from drake_mobman.robots.file.packages import Packages, missing


class Shapes(enum.Enum):
    """Which shapes a model's text has."""

    NONE = enum.auto()
    """Links and joints alone."""
    OUTLINE = enum.auto()
    """Those for collisions, or what is drawn where a link has none; no meshes."""
    DRAWN = enum.auto()
    """Those that are drawn."""


class Mimic(NamedTuple):
    """How a joint follows another."""

    joint: str  # The other.
    multiplier: float
    offset: float  # [rad], [m].


@dc.dataclass(frozen=True)
class Model:
    """A robot's model, read from its file.

    It may lack what a parser of Drake's tells of a model only in part: how joints
    follow others, and the largest efforts of joints that have no actuator.
    """

    path: Path
    kind: str  # Drake's name of the format: urdf, sdf, xml (MJCF) or dmd.yaml.
    text: Callable[[Shapes], str]
    efforts: Mapping[str, float] = dc.field(default_factory=dict)  # [N m], [N].
    mimics: Mapping[str, Mimic] = dc.field(default_factory=dict)
    meshes: tuple[Path, ...] = ()
    packages: Mapping[str, Path] = dc.field(default_factory=dict)


def refused(path: Path, why: str) -> ParameterError:
    """Returns the error of a model that cannot be used."""
    return ParameterError("model", path.name, why)


def mesh_file(uri: str, path: Path, packages: Packages, folder: Path) -> Path:
    """Returns the file of a model's mesh.

    Args:
        uri: as the model has it.
        path: of the model.
        packages: that it may refer to.
        folder: that a relative path starts from.

    Raises:
        ParameterError: where it is missing.
    """
    file = packages.path(uri, folder)
    if file is None:
        raise refused(path, f"its mesh {uri} is missing: {missing(uri)}")
    if not file.is_file():
        raise refused(path, f"its mesh {uri} is missing: there is no {file}")
    return file.resolve()


def refuse_macros(root: ET.Element, path: Path) -> None:
    """Raises `ParameterError` where a model has xacro's macros left in."""
    for x in root.iter():
        texts = [str(x.tag), x.text or "", *x.attrib.values()]
        if any("ros.org/wiki/xacro" in t or "${" in t or "$(" in t for t in texts):
            expanded = path.name.removesuffix(".xacro")
            how = f"expand it first: xacro {path.name} > {expanded}"
            raise refused(path, f"it has macros of xacro in <{x.tag}>; {how}")
