"""A scenario's robot file: where it is, and what is to be said of it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from drake_mobman.robots.file import File
from drake_mobman.robots.file.complaints import summary
from drake_mobman.robots.file.kept import changed_files
from drake_mobman.scenario_files import robot_paths
from drake_mobman.schema import TAG


def located(data: Any, folder: Path) -> Any:
    """Returns a scenario's YAML data with an absolute path of its robot file, if any.

    A name without a suffix is that of a built-in robot file.

    Args:
        data: of a whole scenario; it need not be valid.
        folder: that a relative path starts from.
    """
    robot = data.get("robot") if isinstance(data, dict) else None
    if not isinstance(robot, dict) or not isinstance(robot.get("path"), str):
        return data
    if str(robot.get(TAG)).lstrip("!").lower() != File.__name__.lower():
        return data
    given = robot["path"]
    path = robot_paths().get(given, folder / given) if given else ""
    return data | {"robot": robot | {"path": str(path)}}


def robot_warnings(robot: Any) -> Iterator[str]:
    """Yields lines on a robot that can be used, but not without a word.

    Args:
        robot: of a scenario, checked.
    """
    if not isinstance(robot, File):
        return
    found = robot.described()
    if found.loose.parsed.complaints:
        yield f"{found.path.name}: {summary(found.loose.parsed.complaints)}"
    if changed := changed_files(found):
        names, more = ", ".join(changed[:3]), ", ..." if len(changed) > 3 else ""
        yield f"{found.path.name}: changed since this run was made: {names}{more}"
