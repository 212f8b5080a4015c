"""The shapes of a link, in URDF and SDFormat alike: those that are needed."""

import xml.etree.ElementTree as ET

from drake_mobman.robots.file.model import Shapes


def keep_shapes(link: ET.Element, shapes: Shapes) -> None:
    """Takes the shapes off a link that are not needed, and those that are meshes."""
    for tag, needed in (("visual", Shapes.DRAWN), ("collision", Shapes.OUTLINE)):
        for shape in link.findall(tag):
            if needed not in shapes or shape.find("geometry/mesh") is not None:
                link.remove(shape)
