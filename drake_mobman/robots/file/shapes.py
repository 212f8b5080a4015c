"""The shapes of links, in URDF and SDFormat alike: those that are needed, as Drake can.

For an outline, meshes are replaced by the primitives around them. To be drawn, they
are converted; where that cannot be, their primitives are drawn.
"""

import copy
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Protocol

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from drake_mobman.robots.file.drawn import pieces
from drake_mobman.robots.file.fitted import Fit, fitted
from drake_mobman.robots.file.model import Shapes
from drake_mobman.robots.file.points import points_of


class Dialect(Protocol):
    """How a format writes shapes; each element `shape` is a visual or a collision."""

    def mesh(self, shape: ET.Element) -> tuple[str, list[float]] | None:
        """Returns the URI and the scale (3,) of its mesh, if it is one."""

    def put_primitive(self, shape: ET.Element, fit: Fit) -> None:
        """Puts a primitive in the place of its mesh, at the fit's pose in the mesh."""

    def put_mesh(self, shape: ET.Element, uri: str, rgba: str) -> None:
        """Puts another mesh in its place, with a colour where the shape has none."""


def with_shapes(
    root: ET.Element, shapes: Shapes, dialect: Dialect, files: dict[str, Path]
) -> ET.Element:
    """Returns a copy of a model whose links have the shapes that are needed.

    Args:
        root: of the model.
        shapes: that are needed.
        dialect: of its format.
        files: of its meshes, by URI.
    """
    written = copy.deepcopy(root)
    for link in written.iter("link"):
        visuals, collisions = link.findall("visual"), link.findall("collision")
        needed = {
            Shapes.NONE: [],
            Shapes.OUTLINE: collisions or visuals,
            Shapes.DRAWN: visuals,
        }[shapes]
        for shape in [*visuals, *collisions]:
            mesh = dialect.mesh(shape)
            if shape not in needed:
                link.remove(shape)
            elif mesh is not None:
                _replace(link, shape, mesh, shapes, dialect, files)
    return written


def _replace(
    link: ET.Element,
    shape: ET.Element,
    mesh: tuple[str, list[float]],
    shapes: Shapes,
    dialect: Dialect,
    files: dict[str, Path],
) -> None:
    """Replaces a mesh in a link by what Drake takes; nothing where it is empty."""
    uri, scale = mesh
    parts = pieces(files[uri]) if shapes is Shapes.DRAWN else []
    if not parts:
        fit = fitted(points_of(files[uri]) * scale)
        if fit is None:
            link.remove(shape)
        else:
            dialect.put_primitive(shape, fit)
        return
    place = list(link).index(shape)
    link.remove(shape)
    for i, part in enumerate(parts):
        piece = copy.deepcopy(shape)
        if i and piece.get("name"):
            piece.set("name", f"{piece.get('name')}_{i}")
        dialect.put_mesh(piece, part.file.as_uri(), part.rgba)
        link.insert(place + i, piece)


def numbers(text: str | None, default: str) -> list[float]:
    """Returns the numbers in an attribute or element."""
    return [float(x) for x in (text or default).split()]


def words(values: np.ndarray | list[float]) -> str:
    """Returns numbers as text."""
    return " ".join(f"{x:.12g}" for x in values)


def pose_of(xyz: list[float], rpy: list[float]) -> RigidTransform:
    """Returns a pose [m], [rad]."""
    return RigidTransform(RollPitchYaw(rpy), xyz)


def put_geometry(shape: ET.Element, geometry: ET.Element) -> None:
    """Puts another geometry in a shape."""
    for holder in shape.findall("geometry"):
        holder[:] = [geometry]
