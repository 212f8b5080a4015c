"""URDF files of the package, with their lengths filled in."""

import string
from importlib import resources
from typing import Any

from pydrake.multibody.parsing import Parser


def add_urdf(plant: Any, text: str) -> list[Any]:
    """Adds a robot's URDF to a plant; returns its model instances."""
    return list(Parser(plant).AddModelsFromString(text, "urdf"))


def filled_urdf(name: str, **lengths: float) -> str:
    """Returns this package's URDF `name` with `lengths` [m] filled in.

    Half of each length is filled in too, as `half_...`: a primitive is placed by its
    middle.
    """
    text = resources.files(__package__).joinpath(f"{name}.urdf").read_text()
    halves = {f"half_{key}": length / 2 for key, length in lengths.items()}
    return string.Template(text).substitute(lengths, **halves)
