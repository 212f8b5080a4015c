"""`mobman robot scenario`: scenarios fitted to a robot, as files to begin with."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drake_mobman.cli.messages import complain, refuse, say_path
from drake_mobman.cli.robot.loading import Robot, load_robot
from drake_mobman.exit_status import DIED
from drake_mobman.scenario_files import robot_names

if TYPE_CHECKING:
    from drake_mobman.robots.file import File


def scenario(
    file: Robot,
    out: Annotated[Path, typer.Option(help="Folder for the scenarios.")] = Path(),
) -> None:
    """Writes two scenarios that fit a robot: one driven by a stick, one by hand."""
    from drake_mobman.parameters import ParameterError, checked
    from drake_mobman.scenario.changes import dump_changes
    from drake_mobman.scenario.fitted import fitted_guided, fitted_teleop

    name, robot = load_robot(file)
    files = {
        out / f"{name}_kwon.yaml": fitted_teleop,
        out / f"{name}_guided.yaml": fitted_guided,
    }
    for path in files:
        if path.exists():
            refuse(f"{path}: is there already; take it away, or give another --out")
    texts = {}
    for path, fitted in files.items():
        try:
            made = checked(fitted(robot))
        except ParameterError as error:
            refuse(f"{name}: {error}")
        texts[path] = dump_changes(made, seen_from(robot, name, file, out))
    for path, text in texts.items():
        try:
            out.mkdir(parents=True, exist_ok=True)
            path.write_text(text, "utf-8")
        except OSError as error:
            complain(f"{path}: not written: {error.strerror}")
            raise typer.Exit(DIED) from None
        say_path("written to", path)


def seen_from(robot: "File", name: str, given: str, folder: Path) -> "File":
    """Returns a robot as a scenario in a folder names it."""
    import dataclasses as dc

    if given == name and name in robot_names():
        return dc.replace(robot, path=name)
    return dc.replace(robot, path=os.path.relpath(robot.path, folder))
