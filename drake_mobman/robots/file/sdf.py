"""SDFormat as Drake takes it."""

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from pydrake.math import RollPitchYaw

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


def sdf_model(root: ET.Element, path: Path, packages: Packages) -> Model:
    """Returns a model in SDFormat.

    Raises:
        ParameterError: where it is not just one model, or a mesh is missing.
    """
    refuse_macros(root, path)
    models = [*root.findall("model"), *root.findall("world/model")]
    if len(models) != 1:
        raise refused(path, f"it holds {len(models)} models, and must hold one")
    for static in models[0].findall("static"):
        models[0].remove(static)
    files = {
        uri: mesh_file(uri, path, packages, path.parent)
        for uri in (_text(mesh, "uri") for mesh in root.iter("mesh"))
    }

    def text(shapes: Shapes) -> str:
        written = with_shapes(root, shapes, _Sdf(), files)
        return ET.tostring(written, encoding="unicode")

    mimics = {
        joint.get("name", ""): mimic
        for joint in root.iter("joint")
        for mimic in _mimics(joint)
    }
    meshes = tuple(dict.fromkeys(files.values()))
    return Model(path, "sdf", text, mimics=mimics, meshes=meshes)


def _text(x: ET.Element, path: str) -> str:
    return (x.findtext(path) or "").strip()


def _mimics(joint: ET.Element) -> Iterator[Mimic]:
    for mimic in joint.findall("axis/mimic"):
        multiplier, offset, reference = (
            float(mimic.findtext(key) or default)
            for key, default in (("multiplier", 1), ("offset", 0), ("reference", 0))
        )
        yield Mimic(mimic.get("joint", ""), multiplier, offset - multiplier * reference)


class _Sdf:
    """How SDFormat writes shapes: a `Dialect`."""

    def mesh(self, shape: ET.Element) -> tuple[str, list[float]] | None:
        mesh = shape.find("geometry/mesh")
        if mesh is None:
            return None
        return _text(mesh, "uri"), numbers(mesh.findtext("scale"), "1 1 1")

    def put_primitive(self, shape: ET.Element, fit: Fit) -> None:
        primitive = ET.Element(fit.kind)
        for key, value in fit.size.items():
            ET.SubElement(primitive, key).text = value
        put_geometry(shape, primitive)
        pose = shape.find("pose")
        if pose is None:
            pose = ET.SubElement(shape, "pose")
        given = numbers(pose.text, "0 0 0 0 0 0")
        if pose.attrib.pop("degrees", "") in {"true", "1"}:
            given[3:] = np.radians(given[3:]).tolist()
        X_LG = pose_of(given[:3], given[3:]) @ fit.X_MG
        angles = RollPitchYaw(X_LG.rotation()).vector()
        pose.text = words([*X_LG.translation(), *angles])

    def put_mesh(self, shape: ET.Element, uri: str, rgba: str) -> None:
        mesh = ET.Element("mesh")
        ET.SubElement(mesh, "uri").text = uri
        ET.SubElement(mesh, "scale").text = shape.findtext(
            "geometry/mesh/scale", "1 1 1"
        )
        put_geometry(shape, mesh)
        if rgba and shape.find("material") is None:
            material = ET.SubElement(shape, "material")
            ET.SubElement(material, "diffuse").text = rgba
