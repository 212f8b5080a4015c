"""URDF as Drake takes it: what Drake does not know is left out, and kept aside."""

import copy
import hashlib
import xml.etree.ElementTree as ET
from pathlib import Path

from pydrake.math import RollPitchYaw

from drake_mobman.parameters import ParameterError
from drake_mobman.robots.file.fitted import Fit
from drake_mobman.robots.file.model import (
    Mimic,
    Model,
    Shapes,
    mesh_file,
    refuse_macros,
    refused,
)
from drake_mobman.robots.file.packages import Packages
from drake_mobman.robots.file.shapes import (
    numbers,
    pose_of,
    put_geometry,
    with_shapes,
    words,
)

_KEPT = {"link", "joint", "material"}
"""What is read at the top; the rest is for simulators, controllers and planners."""

_JOINT_KEPT = {"origin", "parent", "child", "axis", "limit", "dynamics"}
"""What is read of a joint."""


def urdf_model(root: ET.Element, path: Path, packages: Packages) -> Model:
    """Returns a model in URDF.

    Raises:
        ParameterError: where xacro's macros are left in, or a mesh is missing.
    """
    refuse_macros(root, path)
    efforts, mimics = _efforts(root, path), _mimics(root, path)
    for x in [x for x in root if x.tag not in _KEPT]:
        root.remove(x)
    for joint in root.iter("joint"):
        for x in [x for x in joint if x.tag not in _JOINT_KEPT]:
            joint.remove(x)
        for x in joint.iter("dynamics"):
            x.attrib.pop("friction", None)  # Drake has none in joints.
    for link in root.iter("link"):
        link.attrib.pop("type", None)
        _clean_mass(link, path)
    _define_materials(root)
    _rename_materials(root)
    files = {
        uri: mesh_file(uri, path, packages, path.parent)
        for uri in (mesh.get("filename", "") for mesh in root.iter("mesh"))
    }

    def text(shapes: Shapes) -> str:
        written = with_shapes(root, shapes, _Urdf(), files)
        return ET.tostring(written, encoding="unicode")

    meshes = tuple(dict.fromkeys(files.values()))
    return Model(path, "urdf", text, efforts, mimics, meshes)


class _Urdf:
    """How URDF writes shapes: a `Dialect`."""

    def mesh(self, shape: ET.Element) -> tuple[str, list[float]] | None:
        mesh = shape.find("geometry/mesh")
        if mesh is None:
            return None
        return mesh.get("filename", ""), numbers(mesh.get("scale"), "1 1 1")

    def put_primitive(self, shape: ET.Element, fit: Fit) -> None:
        put_geometry(shape, ET.Element(fit.kind, fit.size))
        origin = shape.find("origin")
        if origin is None:
            origin = ET.SubElement(shape, "origin")
        given = (numbers(origin.get(key), "0 0 0") for key in ("xyz", "rpy"))
        X_LG = pose_of(*given) @ fit.X_MG
        origin.set("xyz", words(X_LG.translation()))
        origin.set("rpy", words(RollPitchYaw(X_LG.rotation()).vector()))

    def put_mesh(self, shape: ET.Element, uri: str, rgba: str) -> None:
        scale = shape.find("geometry/mesh")
        size = {} if scale is None else {"scale": scale.get("scale", "1 1 1")}
        put_geometry(shape, ET.Element("mesh", {"filename": uri} | size))
        if rgba and shape.find("material") is None:
            material = ET.SubElement(shape, "material", {"name": f"colour_{rgba}"})
            ET.SubElement(material, "color", {"rgba": rgba})


def _clean_mass(link: ET.Element, path: Path) -> None:
    """Takes an inertia without mass off a link: Drake would make it a ball of 1 kg."""
    for inertial in link.findall("inertial"):
        mass = inertial.find("mass")
        value = 0.0 if mass is None else _number(mass, "value", path)
        if value < 0:
            raise refused(
                path, f"its link {link.get('name')} has a mass of {value:g} kg"
            )
        if value == 0:
            link.remove(inertial)


def _efforts(root: ET.Element, path: Path) -> dict[str, float]:
    found = {}
    for joint in root.findall("joint"):
        limit = joint.find("limit")
        if limit is not None and limit.get("effort"):
            found[joint.get("name", "")] = _number(limit, "effort", path)
    return found


def _mimics(root: ET.Element, path: Path) -> dict[str, Mimic]:
    found = {}
    for joint in root.findall("joint"):
        mimic = joint.find("mimic")
        if mimic is not None:
            found[joint.get("name", "")] = Mimic(
                mimic.get("joint", ""),
                _number(mimic, "multiplier", path, 1.0),
                _number(mimic, "offset", path, 0.0),
            )
    return found


def _number(x: ET.Element, key: str, path: Path, default: float = 0.0) -> float:
    try:
        return float(x.get(key, default))
    except ValueError:
        valid = f"its <{x.tag}> has {key} = {x.get(key)!r}, which must be a number"
        raise ParameterError("model", path.name, valid) from None


def _define_materials(root: ET.Element) -> None:
    """Gives materials that are only named the colour of their name, or takes them off.

    Drake takes a name only where the top of the file defines it; others define it at
    its first use, or at any.
    """

    def is_defined(material: ET.Element) -> bool:
        return any(material.find(x) is not None for x in ("color", "texture"))

    at_top = {x.get("name") for x in root.findall("material") if is_defined(x)}
    colours: dict[str | None, ET.Element] = {}
    for material in root.iter("material"):
        colour = material.find("color")
        if colour is not None:
            colours.setdefault(material.get("name"), colour)
    for parent in (root, *root.iter("visual")):
        for material in parent.findall("material"):
            name = material.get("name")
            if is_defined(material) or name in at_top:
                continue
            if name in colours:
                material.append(copy.deepcopy(colours[name]))
            else:
                parent.remove(material)


def _rename_materials(root: ET.Element) -> None:
    """Names materials by their colours too: Drake refuses two colours of one name."""
    colours: dict[str, str] = {}
    # Those at the top keep their names, wherever they stand: others refer to them.
    at_top = root.findall("material")
    for material in (*at_top, *(x for x in root.iter("material") if x not in at_top)):
        colour = material.find("color")
        if colour is None:
            continue
        rgba = colour.get("rgba", "")
        name = material.get("name", "")
        if not name or colours.setdefault(name, rgba) != rgba:
            digest = hashlib.sha1(rgba.encode()).hexdigest()[:8]
            material.set("name", f"{name}_{digest}")
