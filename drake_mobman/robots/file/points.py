"""The points of a mesh's file: STL, OBJ and Collada, for its size and its shape."""

import functools
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from drake_mobman.scalars import Matrix

_TRIANGLE = np.dtype([("normal", "<3f4"), ("corners", "<9f4"), ("more", "<u2")])


def points_of(file: Path) -> Matrix:
    """Returns the points (N, 3) of a mesh, in the file's own unit; (0, 3) if unknown.

    A Collada file tells its unit: its points are in metres.
    """
    status = file.stat()
    return _points(file, status.st_mtime_ns, status.st_size)


def triangles_of_stl(file: Path) -> Matrix:
    """Returns the corners (N, 3, 3) of the triangles of an STL file."""
    data = file.read_bytes()
    count = int.from_bytes(data[80:84], "little")
    if len(data) >= 84 + 50 * count > 84:
        corners = np.frombuffer(data, _TRIANGLE, count, 84)["corners"]
        return corners.reshape(-1, 3, 3).astype(float)
    words = [line.split() for line in data.decode("ascii", "replace").splitlines()]
    corners = np.array([w[1:4] for w in words if w[:1] == ["vertex"]], float)
    return corners.reshape(-1, 3, 3)


def unit_of_collada(file: Path) -> float:
    """Returns the unit of a Collada file [m]."""
    return _unit(_collada(file))


@functools.lru_cache(maxsize=512)
def _points(file: Path, _changed: int, _size: int) -> Matrix:
    kinds = {".stl": triangles_of_stl, ".obj": _of_obj, ".dae": _of_collada}
    read = kinds.get(file.suffix.lower())
    try:
        points = read(file).reshape(-1, 3) if read else np.zeros((0, 3))
    except (ValueError, KeyError, ET.ParseError):
        return np.zeros((0, 3))
    return points[np.isfinite(points).all(axis=1)]


def _of_obj(file: Path) -> Matrix:
    lines = file.read_text("utf-8", "replace").splitlines()
    return np.array([line.split()[1:4] for line in lines if line[:2] == "v "], float)


def _unit(root: ET.Element) -> float:
    unit = root.find("asset/unit")
    return float(unit.get("meter", 1.0)) if unit is not None else 1.0


def _collada(file: Path) -> ET.Element:
    """Returns the root of a Collada file, its tags without their namespace."""
    root = ET.parse(file).getroot()
    for x in root.iter():
        x.tag = x.tag.rpartition("}")[2]
    return root


def _of_collada(file: Path) -> Matrix:
    root = _collada(file)
    meshes = {f"#{x.get('id')}": _positions(x) for x in root.iter("geometry")}
    placed = [
        meshes[url] @ X[:3, :3].T + X[:3, 3]
        for scene in root.iter("visual_scene")
        for url, X in _instances(scene, np.eye(4))
        if url in meshes
    ]
    return _unit(root) * np.concatenate(placed or list(meshes.values()))


def _positions(geometry: ET.Element) -> Matrix:
    """Returns the points (N, 3) of a geometry."""
    sources = {f"#{x.get('id')}": x for x in geometry.iter("source")}
    found = [
        np.array((sources[x.get("source", "")].findtext("float_array") or "").split())
        for vertices in geometry.iter("vertices")
        for x in vertices.findall("input")
        if x.get("semantic") == "POSITION"
    ]
    return np.concatenate([*found, np.zeros(0)]).astype(float).reshape(-1, 3)


def _instances(node: ET.Element, X: Matrix) -> Iterator[tuple[str, Matrix]]:
    """Yields the geometries below a node, and where they are (4, 4)."""
    for x in node:
        numbers = np.array((x.text or "").split(), float) if x.tag in _MOVES else None
        if numbers is not None:
            X = X @ _MOVES[x.tag](numbers)
        elif x.tag == "instance_geometry":
            yield x.get("url", ""), X
        elif x.tag == "node":
            yield from _instances(x, X)


def _translated(p: Matrix) -> Matrix:
    X = np.eye(4)
    X[:3, 3] = p
    return X


def _rotated(axis_angle: Matrix) -> Matrix:
    """Returns a rotation (4, 4) about an axis by an angle [degrees]."""
    (x, y, z), angle = axis_angle[:3], np.radians(axis_angle[3])
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    X = np.eye(4)
    X[:3, :3] += np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    return X


_MOVES: dict[str, Callable[[Matrix], Matrix]] = {
    "matrix": lambda numbers: numbers.reshape(4, 4),
    "translate": _translated,
    "rotate": _rotated,
    "scale": lambda size: np.diag([*size, 1.0]),
}
"""How the elements of a node move what is below it."""
