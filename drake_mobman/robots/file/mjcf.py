"""MJCF, MuJoCo's format, as Drake takes it."""

import xml.etree.ElementTree as ET
from pathlib import Path

from drake_mobman.robots.file.model import Model
from drake_mobman.robots.file.packages import Packages


def mjcf_model(root: ET.Element, path: Path, packages: Packages) -> Model:
    """Returns a model in MJCF.

    Raises:
        ParameterError: where a mesh is missing.
    """
    del packages
    written = ET.tostring(root, encoding="unicode")
    return Model(path, "xml", lambda _: written)
