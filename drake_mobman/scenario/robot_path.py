"""Where a scenario's robot file is: beside what names it, or built in."""

from pathlib import Path
from typing import Any

from drake_mobman.robots.file import File
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
