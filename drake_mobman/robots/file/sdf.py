"""SDFormat as Drake takes it."""

import copy
import xml.etree.ElementTree as ET
from pathlib import Path

from drake_mobman.robots.file.model import (
    Model,
    Shapes,
    mesh_file,
    refuse_macros,
    refused,
)
from drake_mobman.robots.file.packages import Packages
from drake_mobman.robots.file.shapes import keep_shapes


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
    meshes = [
        mesh_file((uri.text or "").strip(), path, packages, path.parent)
        for uri in root.iterfind(".//mesh/uri")
    ]

    def text(shapes: Shapes) -> str:
        written = copy.deepcopy(root)
        for link in written.iter("link"):
            keep_shapes(link, shapes)
        return ET.tostring(written, encoding="unicode")

    return Model(path, "sdf", text, meshes=tuple(dict.fromkeys(meshes)))
