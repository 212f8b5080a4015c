"""A robot's model read from its file, whichever its format."""

import dataclasses as dc
import difflib
import functools
import xml.etree.ElementTree as ET
from pathlib import Path

from drake_mobman.files import read_file
from drake_mobman.parameters import ParameterError
from drake_mobman.robots.file.directives import directives_model
from drake_mobman.robots.file.mjcf import mjcf_model
from drake_mobman.robots.file.model import Model
from drake_mobman.robots.file.packages import Packages, missing, package_names
from drake_mobman.robots.file.sdf import sdf_model
from drake_mobman.robots.file.urdf import urdf_model

_LARGEST = 100_000_000
"""Largest size of a model's file [bytes]."""

_FORMATS = {"robot": urdf_model, "sdf": sdf_model, "mujoco": mjcf_model}
"""By the tag at the top."""


def read_model(
    uri: str, packages: Packages, folder: Path, above: tuple[Path, ...] = ()
) -> Model:
    """Returns a model.

    Args:
        uri: of its file: `package://NAME/...` or a path.
        packages: that the model may refer to.
        folder: that a relative path starts from.
        above: files of directives that it is part of.

    Raises:
        ParameterError: with the key `model`, where it cannot be used.
    """
    path = packages.path(uri, folder)
    if path is None:
        raise ParameterError("model", uri, missing(uri))
    text = _text(uri, path)
    path = path.resolve()
    named = {name: packages.folder(name) for name in package_names(f"{uri}\n{text}")}
    known = {name: folder for name, folder in named.items() if folder is not None}
    if path.suffix in {".yaml", ".yml"}:
        if path in above:
            raise ParameterError("model", uri, "must not be part of itself")
        inner = functools.partial(read_model, above=(*above, path))
        model = directives_model(text, path, packages, inner)
        return dc.replace(model, packages=known)
    root = _root(uri, text)
    if root.tag not in _FORMATS:
        valid = "must begin with <robot>, <sdf> or <mujoco>, or end in .dmd.yaml"
        raise ParameterError("model", f"{uri}, <{root.tag}>", valid)
    return dc.replace(_FORMATS[root.tag](root, path, packages), packages=known)


def _text(uri: str, path: Path) -> str:
    """Returns the text of a model's file."""
    try:
        text = read_file(path, _LARGEST).decode()
    except FileNotFoundError:
        raise ParameterError("model", uri, _not_there(path)) from None
    except UnicodeDecodeError:
        raise ParameterError("model", uri, "must be text; it is binary") from None
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise ParameterError("model", uri, f"cannot be read; {why}") from None
    if not text.strip():
        raise ParameterError("model", uri, "must hold a model; it is empty")
    return text


def _not_there(path: Path) -> str:
    """Returns for a message what there is in place of a file."""
    if not path.parent.is_dir():
        return f"must be a file; there is no folder {path.parent}"
    beside = [x.name for x in path.parent.iterdir() if x.is_file()]
    near = difflib.get_close_matches(path.name, beside, 3, 0.3)
    also = f"; near are {', '.join(near)}" if near else ""
    return f"must be a file; there is none in {path.parent}{also}"


def _root(uri: str, text: str) -> ET.Element:
    try:
        return ET.fromstring(text.encode())
    except (ET.ParseError, ValueError) as error:
        raise ParameterError("model", uri, f"must be XML; {error}") from None
