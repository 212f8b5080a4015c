"""A robot file kept with a run: where its models are, and the hashes of their files."""

import hashlib
from collections.abc import Iterator
from typing import Any

from drake_mobman.robots.file.described import Described
from drake_mobman.schema import dump_yaml, load_yaml

KEPT = "robot.robot.yaml"
"""Name of a robot file that is kept."""

HASHES = "robot.sha256"
"""Name of the list beside it, in the form of `sha256sum`."""


def kept_files(robot: Described) -> dict[str, str]:
    """Returns the texts of files to keep with a run, by their names."""
    return {KEPT: _moved(robot), HASHES: _hashes(robot)}


def changed_files(robot: Described) -> list[str]:
    """Returns the model's files that are not as they were in the run it is kept with.

    Empty for a robot file that is kept with none.
    """
    before = robot.path.with_name(HASHES)
    if robot.path.name != KEPT or not before.is_file():
        return []
    then, now = _by_name(before.read_text("utf-8")), _by_name(_hashes(robot))
    names = dict.fromkeys([*then, *now])
    return [name for name in names if then.get(name) != now.get(name)]


def _moved(robot: Described) -> str:
    """Returns the robot file for another folder: its paths are absolute.

    What is in a package stays there.
    """
    data, folder = load_yaml(robot.text), robot.path.parent

    def absolute(path: str) -> str:
        return path if "://" in path else str((folder / path).resolve())

    packages = data.get("packages") or {}
    paths: dict[str, Any] = {"model": absolute(data["model"])}
    if packages:
        paths["packages"] = {name: absolute(path) for name, path in packages.items()}
    if data.get("parts"):
        parts = data["parts"]
        paths["parts"] = [x | {"model": absolute(x["model"])} for x in parts]
    return dump_yaml(data | paths)


def _hashes(robot: Described) -> str:
    return "".join(f"{digest}  {name}\n" for name, digest in sorted(_digests(robot)))


def _digests(robot: Described) -> Iterator[tuple[str, str]]:
    """Yields the names of the model's files, in their packages, and their hashes."""
    places = {
        folder.resolve(): f"package://{name}"
        for mounted in robot.models
        for name, folder in mounted.model.packages.items()
    }
    for file in robot.files():
        for folder, package in places.items():
            if file.is_relative_to(folder):
                name = f"{package}/{file.relative_to(folder).as_posix()}"
                break
        else:
            name = str(file)
        yield name, hashlib.sha256(file.read_bytes()).hexdigest()


def _by_name(text: str) -> dict[str, str]:
    lines = (line.partition("  ") for line in text.splitlines())
    return {name: digest for digest, _, name in lines}
