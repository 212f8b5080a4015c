"""`mobman robot new`: a draft of a robot file, from a model and its tool's link."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from drake_mobman.cli.messages import refuse


def new(
    model: Annotated[
        str, typer.Argument(help="Model: URDF, SDFormat, MJCF or .dmd.yaml.")
    ],
    tool: Annotated[str, typer.Option(help="Link or frame of the end effector.")],
    on: Annotated[
        str,
        typer.Option(
            metavar="BASE",
            help="Base that the model, an arm, is mounted on: husky, tiago_base, "
            "waffle, or a model.",
        ),
    ] = "",
    at: Annotated[
        str, typer.Option(metavar="FRAME", help="Link or frame of the base for that.")
    ] = "",
    xyz: Annotated[
        tuple[float, float, float], typer.Option(help="Place of the arm there [m].")
    ] = (0.0, 0.0, 0.0),
    package: Annotated[
        list[str],
        typer.Option(metavar="NAME=FOLDER", help="Where package://NAME is."),
    ] = [],  # noqa: B006 - typer makes a new list each time.
) -> None:
    """Prints a robot file for a model, with all that is derived written out."""
    from drake_mobman.parameters import ParameterError
    from drake_mobman.robots.draft import Mount, drafted

    try:
        text = drafted(model, tool, folders(package), Mount(on, at, xyz))
    except ParameterError as error:
        refuse(error)
    sys.stdout.write(text)


def folders(given: list[str]) -> dict[str, str]:
    """Returns the folders of packages by name, or refuses."""
    found = {}
    for each in given:
        name, equals, path = each.partition("=")
        if not (name and equals and path):
            refuse(f"--package: {each} is not valid; must be NAME=FOLDER")
        found[name] = str(Path(path).absolute())
    return found
