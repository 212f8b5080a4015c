"""Meshes as Drake draws them: STL and Collada written as OBJ, once for each content."""

import functools
import hashlib
import importlib.util
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from drake_mobman.files import new_file
from drake_mobman.robots.file.cache import cache_folder
from drake_mobman.robots.file.points import triangles_of_stl, unit_of_collada
from drake_mobman.scalars import Matrix

DRAWN = {".obj", ".gltf", ".vtk"}
"""Suffixes of the files that Drake reads by itself."""


class Piece(NamedTuple):
    """A part of a mesh that has one colour."""

    file: Path  # That Drake can draw.
    rgba: str  # Its colour; empty where the mesh has none.


def pieces(file: Path) -> list[Piece]:
    """Returns what to draw for a mesh; nothing where that takes the extra `meshes`."""
    status = file.stat()
    return _pieces(file, status.st_mtime_ns, status.st_size)


@functools.lru_cache(maxsize=512)
def _pieces(file: Path, _changed: int, _size: int) -> list[Piece]:
    kind = file.suffix.lower()
    if kind in DRAWN:
        return [Piece(file, "")]
    if kind == ".stl":
        corners = triangles_of_stl(file)
        faces = np.arange(3 * len(corners)).reshape(-1, 3)
        return [Piece(_written(file, "", corners.reshape(-1, 3), faces), "")]
    if kind == ".dae" and all(map(importlib.util.find_spec, ("trimesh", "collada"))):
        parts = enumerate(_coloured(file))
        return [
            Piece(_written(file, f"_{i}", *mesh), rgba) for i, (mesh, rgba) in parts
        ]
    return []


def _coloured(file: Path) -> Iterator[tuple[tuple[Matrix, Matrix], str]]:
    """Yields a file's meshes, points (N, 3) and faces (M, 3), with their colours."""
    import trimesh  # noqa: PLC0415 - an extra.

    metre = unit_of_collada(file)
    loaded: list[Any] = trimesh.load_scene(file).dump()
    for mesh in loaded:
        colour = getattr(mesh.visual, "main_color", None)
        if colour is None:
            colour = mesh.visual.material.main_color
        rgba = " ".join(f"{x / 255:.3g}" for x in colour)
        yield (metre * np.asarray(mesh.vertices), np.asarray(mesh.faces)), rgba


def _written(file: Path, part: str, points: Matrix, faces: Matrix) -> Path:
    """Returns an OBJ file of a mesh, from the cache or new."""
    digest = hashlib.sha256(file.read_bytes()).hexdigest()[:24]
    written = cache_folder() / f"{digest}{part}.obj"
    if not written.exists():
        points, index = np.unique(points.round(7), axis=0, return_inverse=True)
        lines = [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in points.tolist()]
        corners = index.reshape(-1)[faces] + 1
        lines += [f"f {a} {b} {c}" for a, b, c in corners.tolist()]
        with new_file(written) as draft:
            draft.write_text("\n".join([*lines, ""]))
    return written
