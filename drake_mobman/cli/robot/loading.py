"""A robot as a command gets it: loaded and checked, or refused with one line."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drake_mobman.cli.messages import refuse
from drake_mobman.scenario_files import ROBOT, robot_names, robot_paths

if TYPE_CHECKING:
    from drake_mobman.robots.file import File


def completed_robots(incomplete: str) -> list[str]:
    """Returns the names of robots that begin so, for the shell's completion."""
    return [name for name in robot_names() if name.startswith(incomplete)]


Robot = Annotated[
    str,
    typer.Argument(
        metavar="FILE",
        help="Path of a robot file, or name of a robot (`mobman list` shows them).",
        autocompletion=completed_robots,
    ),
]


def load_robot(given: str) -> "tuple[str, File]":
    """Returns a robot's name and its file, or refuses."""
    from drake_mobman.parameters import ParameterError
    from drake_mobman.robots.file import File

    path = robot_paths().get(given, Path(given))
    if not path.exists():
        known = ", ".join(robot_names())
        refuse(f"{given}: no such robot; valid names are {known}, or a path")
    robot = File(str(path.absolute()))
    try:
        robot.check()
    except ParameterError as error:
        refuse(error)
    return path.name.removesuffix(ROBOT).removesuffix(".yaml"), robot
