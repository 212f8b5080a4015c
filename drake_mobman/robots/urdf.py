"""URDF files of the package, with their lengths filled in."""

import string
from importlib import resources


def filled_urdf(name: str, **lengths: float) -> str:
    """Returns this package's URDF `name` with `lengths` [m] filled in.

    Half of each length is filled in too, as `half_...`: a primitive is placed by its
    middle.
    """
    text = resources.files(__package__).joinpath(f"{name}.urdf").read_text()
    halves = {f"half_{key}": length / 2 for key, length in lengths.items()}
    return string.Template(text).substitute(lengths, **halves)
