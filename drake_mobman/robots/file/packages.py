"""Packages of robot models: where `package://NAME` is on this machine."""

import functools
import importlib.util
import os
import re
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from drake_mobman.parameters import ParameterError
from drake_mobman.scenario_files import models_folder

_URI = re.compile(r"""package:/{2,}([^/"'<>\s]+)(/[^"'<>]*)?""")
"""Some makers write three slashes."""

_OURS = "drake_mobman"
"""Package of the models that come with this one."""

_EXTRAS = {"example-robot-data": "drake_mobman[robots]"}
"""What brings a package, by its name, where it is an extra of ours."""

_DEEPEST = 4
"""How many folders down from a search path a package may be."""


def package_names(text: str) -> list[str]:
    """Returns the names of the packages that a text refers to, in order."""
    return sorted({match[1] for match in _URI.finditer(text)})


class Packages:
    """Finds packages: by given folders, by ROS, or among installed Python packages.

    Args:
        given: folders by name; they come first.
        folder: that a relative one of them is in.
    """

    def __init__(self, given: Mapping[str, str], folder: Path) -> None:
        self._given = {name: folder / path for name, path in given.items()}

    def check(self) -> None:
        """Raises `ParameterError` unless all given folders are there."""
        for name, path in self._given.items():
            if not path.is_dir():
                valid = "must be a folder that is there"
                raise ParameterError(f"packages.{name}", str(path), valid)

    def folder(self, name: str) -> Path | None:
        """Returns the folder of a package; None where it is not found."""
        if name in self._given:
            return self._given[name]
        if name == _OURS:
            return models_folder()
        paths = (os.environ.get(key, "") for key in _VARIABLES)
        return _found(name, *paths)

    def path(self, uri: str, beside: Path) -> Path | None:
        """Returns the file of a URI or path; None where its package is not found.

        Args:
            uri: `package://NAME/...`, `model://NAME/...`, `file://...` or a path.
            beside: folder that a relative path starts from.
        """
        if match := re.match(r"(?:package|model):/{2,}([^/]+)/?(.*)", uri):
            package = self.folder(match[1])
            return None if package is None else package / match[2]
        return beside / uri.removeprefix("file://")


def missing(uri: str) -> str:
    """Returns for a message what to do where the package of a URI is not found."""
    name = re.sub(r"^\w+:/{2,}", "", uri).partition("/")[0]
    how = f"packages: {{{name}: FOLDER}}, ROS_PACKAGE_PATH or AMENT_PREFIX_PATH"
    if name in _EXTRAS:
        return f"package {name} is not found; pip install '{_EXTRAS[name]}'"
    return f"package {name} is not found; name its folder by {how}, or pip install it"


_VARIABLES = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "ROBOT_DESCRIPTIONS_CACHE")


@functools.lru_cache(maxsize=64)
def _found(name: str, ros: str, ament: str, cache: str) -> Path | None:
    """Returns the folder of a package by the values of `_VARIABLES`."""
    folders = (
        folder
        for find in (_by_ros, _by_ament, _by_python, _by_cache)
        for folder in find(name, ros, ament, cache)
    )
    return next((folder for folder in folders if folder.is_dir()), None)


def _split(paths: str) -> Iterator[Path]:
    return (Path(path) for path in paths.split(os.pathsep) if path)


def _by_ros(name: str, ros: str, *_: str) -> Iterator[Path]:
    for path in _split(ros):
        yield from _packages_below(path, name)


def _by_ament(name: str, _ros: str, ament: str, _cache: str) -> Iterator[Path]:
    return (path / "share" / name for path in _split(ament))


def _by_python(name: str, *_: str) -> Iterator[Path]:
    """Yields where installed Python packages keep models of that name."""
    for site in map(Path, filter(None, [*sys.path, sys.prefix])):
        yield site / "cmeel.prefix" / "share" / name
        yield site / "share" / name
    module = name.replace("-", "_")
    if module.isidentifier() and module not in sys.stdlib_module_names:
        try:
            spec = importlib.util.find_spec(module)
        except (ImportError, ValueError):
            return
        yield from map(Path, (spec and spec.submodule_search_locations) or ())


def _by_cache(name: str, _ros: str, _ament: str, cache: str) -> Iterator[Path]:
    """Yields where `robot_descriptions` has loaded a model before; loads nothing."""
    home = Path(cache or Path("~/.cache/robot_descriptions").expanduser())
    if home.is_dir():
        yield home / name
        yield from _packages_below(home, name, manifest=False)


def _packages_below(path: Path, name: str, manifest: bool = True) -> Iterator[Path]:
    """Yields the folders of a package at a path or below it.

    Args:
        path: to search.
        name: of the package.
        manifest: whether only a folder with a `package.xml` is one.
    """
    for at, folders, files in os.walk(path):
        here = Path(at)
        is_package = "package.xml" in files
        of_name = _named(here / "package.xml", here.name) if is_package else here.name
        if of_name == name and (is_package or not manifest):
            yield here
        depth = len(here.relative_to(path).parts)
        if depth >= _DEEPEST or (is_package and manifest):
            folders.clear()  # Packages have none inside.
        folders[:] = sorted(x for x in folders if not x.startswith("."))


def _named(manifest: Path, folder: str) -> str:
    """Returns the name in a `package.xml`, or that of its folder."""
    text = manifest.read_text("utf-8", "replace")
    match = re.search(r"<name>\s*([^<\s]+)\s*</name>", text)
    return match[1] if match else folder
