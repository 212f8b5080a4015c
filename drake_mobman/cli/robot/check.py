"""`mobman robot check`: all that is known of a robot, and where that is from."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drake_mobman.cli.messages import complain, console, refuse, say_path
from drake_mobman.cli.robot.loading import Robot, load_robot
from drake_mobman.exit_status import DIED

if TYPE_CHECKING:
    from drake_mobman.robots.file import File
    from drake_mobman.robots.file.facts import Fact


def check(
    file: Robot,
    draw: Annotated[
        Path | None,
        typer.Option(metavar="PNG", help="File for a picture; must end in .png."),
    ] = None,
) -> None:
    """Prints what a robot file gives and what is derived, with warnings."""
    from drake_mobman.parameters import ParameterError
    from drake_mobman.robots.file.facts import facts
    from drake_mobman.robots.file.warnings import warnings

    if draw and draw.suffix != ".png":
        refuse(f"{draw}: must end in .png")
    name, robot = load_robot(file)
    try:
        known = facts(robot)
    except ParameterError as error:
        refuse(error)
    print_facts(name, known)
    for line in warnings(robot.described(), robot.resolved()):
        complain(f"warning: {line}")
    if draw:
        write_picture(robot, name, draw)


def print_facts(name: str, known: "Sequence[Fact]") -> None:
    """Prints what is known of a robot as a table, in groups."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    from drake_mobman.terminal import visible

    table = Table(
        title=visible(name),
        title_justify="left",
        box=box.SIMPLE_HEAD,
        show_edge=False,
        pad_edge=False,
    )
    table.add_column("", no_wrap=True)
    table.add_column("value", ratio=3)
    table.add_column("where it is from", style="dim", ratio=2)
    group = ""
    for fact in known:
        if fact.group != group:
            group = fact.group
            table.add_section()
            table.add_row(Text(group, style="bold"))
        table.add_row(
            f"  {visible(fact.name)}", visible(fact.value), visible(fact.source)
        )
    console.print(table)


def write_picture(robot: "File", name: str, path: Path) -> None:
    """Writes the picture of a robot, or ends with status 1."""
    from drake_mobman.figures.robot import draw_robot
    from drake_mobman.files import FolderError, new_file
    from drake_mobman.report.pictures import png

    try:
        with new_file(path) as draft:
            draft.write_bytes(png(draw_robot(robot, name)))
    except FolderError as error:
        refuse(error)
    except OSError as error:
        complain(f"{path}: not written: {error}")
        raise typer.Exit(DIED) from None
    say_path("drawn in", path)
