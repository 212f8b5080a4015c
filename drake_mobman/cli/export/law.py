"""`mobman export law`: the controller of a scenario as C."""

from pathlib import Path
from typing import Annotated

import typer

from drake_mobman.cli.loading import load
from drake_mobman.cli.messages import complain, refuse, say_path
from drake_mobman.cli.options import Overrides, Scenario
from drake_mobman.exit_status import DIED


def law(
    scenario: Scenario,
    out: Annotated[Path, typer.Option(help="Folder for the files.")],
    set_: Overrides = [],  # noqa: B006 - typer makes a new list each time.
) -> None:
    """Writes a scenario's controller as C99, with a program that tests it."""
    from drake_mobman.export.law.controller import Controller
    from drake_mobman.export.law.write import LAW, write_law
    from drake_mobman.scenario import ScenarioError
    from drake_mobman.simulation.output_folder import FolderError, check_folder

    loaded = load(scenario, set_)
    try:
        check_folder(out, LAW)
        files = Controller.of(loaded).files()
    except ScenarioError as error:
        refuse(f"{loaded.name}: {error}")
    except FolderError as error:
        refuse(error)
    try:
        write_law(files, out)
    except OSError as error:
        complain(f"{out}: not written: {error.strerror or error}")
        raise typer.Exit(DIED) from None
    say_path("written to", out)
