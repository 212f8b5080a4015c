"""The command line, `mobman`: its commands, each in a file of its own.

Drake is imported when a command runs: `mobman --help` is quick.
"""

import platform
import warnings
from typing import Annotated

import typer

from drake_mobman import __version__
from drake_mobman.cli.bench import bench
from drake_mobman.cli.compare import compare
from drake_mobman.cli.drive import drive
from drake_mobman.cli.export import app as export
from drake_mobman.cli.field import field
from drake_mobman.cli.graph import graph
from drake_mobman.cli.list import list_
from drake_mobman.cli.messages import complain, say
from drake_mobman.cli.robot import app as robot
from drake_mobman.cli.run import run

app = typer.Typer(
    no_args_is_help=True, pretty_exceptions_enable=False, rich_markup_mode=None
)


def print_version(wanted: bool) -> None:
    """Prints the versions of what results depend on, and ends."""
    from importlib.metadata import PackageNotFoundError, version

    if not wanted:
        return
    try:
        drake = version("drake")
    except PackageNotFoundError:
        drake = "built from source"
    say(f"mobman {__version__}, Drake {drake}, Python {platform.python_version()}")
    raise typer.Exit


@app.callback()
def mobman(
    _: Annotated[
        bool,
        typer.Option(
            "--version",
            callback=print_version,
            is_eager=True,
            help="Show the versions of mobman and Drake, and exit.",
        ),
    ] = False,
) -> None:
    """Steer the end effector of a mobile manipulator; its base follows."""
    warnings.showwarning = lambda message, *_: complain(f"warning: {message}")


app.command("list")(list_)
for _command in (run, compare, bench, drive, graph, field):
    app.command()(_command)
app.add_typer(
    robot, name="robot", help="Robot files: checks, drafts, and scenarios that fit."
)
app.add_typer(export, name="export", help="Laws, written for the tools of others.")
