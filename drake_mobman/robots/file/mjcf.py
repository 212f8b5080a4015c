"""MJCF, MuJoCo's format, as Drake takes it."""

import copy
import xml.etree.ElementTree as ET
from pathlib import Path

from drake_mobman.files import read_file
from drake_mobman.robots.file.drawn import pieces
from drake_mobman.robots.file.model import Mimic, Model, Shapes, mesh_file, refused
from drake_mobman.robots.file.packages import Packages

_KEPT = {"compiler", "default", "asset", "worldbody", "actuator"}
"""What is read at the top; the rest is of a simulation, not of a robot."""

_LARGEST = 10_000_000
"""Largest size of an included file [bytes]."""

_DEEPEST = 10
"""How many files may include each other."""


def mjcf_model(root: ET.Element, path: Path, packages: Packages) -> Model:
    """Returns a model in MJCF.

    Its shapes stay, whether they are needed or not: masses may be told from them.

    Raises:
        ParameterError: where a mesh or an included file is missing.
    """
    _include(root, path)
    mimics = dict(_mimics(joint) for joint in root.iterfind("equality/joint[@joint2]"))
    for x in [x for x in root if x.tag not in _KEPT]:
        root.remove(x)
    folder = path.parent
    for compiler in root.iter("compiler"):
        assets = compiler.attrib.pop("assetdir", "")
        folder = path.parent / (compiler.attrib.pop("meshdir", "") or assets)
        compiler.attrib.pop("texturedir", None)
    for asset in root.iter("asset"):
        for texture in asset.findall("texture"):
            asset.remove(texture)
    for material in root.iter("material"):
        material.attrib.pop("texture", None)
    files = {}
    for mesh in root.iterfind("asset/mesh[@file]"):
        uri = mesh.get("file", "")
        files[uri] = mesh_file(uri, path, packages, folder)
        mesh.set("name", mesh.get("name") or Path(uri).stem)

    def text(_: Shapes) -> str:
        written = copy.deepcopy(root)
        for mesh in written.iterfind("asset/mesh[@file]"):
            drawn = pieces(files[mesh.get("file", "")])
            if drawn:
                mesh.set("file", str(drawn[0].file))
        return ET.tostring(written, encoding="unicode")

    meshes = tuple(dict.fromkeys(files.values()))
    return Model(path, "xml", text, mimics=mimics, meshes=meshes)


def _mimics(joint: ET.Element) -> tuple[str, Mimic]:
    """Returns a joint that is made equal to a line over another."""
    offset, multiplier = map(float, joint.get("polycoef", "0 1").split()[:2])
    return joint.get("joint1", ""), Mimic(joint.get("joint2", ""), multiplier, offset)


def _include(root: ET.Element, path: Path, depth: int = 0) -> None:
    """Puts the content of included files in their places."""
    for parent in list(root.iter()):
        for x in parent.findall("include"):
            name = x.get("file", "")
            if depth > _DEEPEST:
                raise refused(path, f"it includes {name}, which includes it")
            file = path.parent / name
            try:
                included = ET.fromstring(read_file(file, _LARGEST))
            except (OSError, ET.ParseError) as error:
                why = getattr(error, "strerror", None) or error
                raise refused(path, f"it includes {name}; {why}") from None
            _include(included, file, depth + 1)
            place = list(parent).index(x)
            parent[place : place + 1] = list(included)
