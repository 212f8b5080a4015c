"""`mobman field`: the velocity field that a base follows."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drake_mobman.cli.loading import load
from drake_mobman.cli.messages import complain, refuse, say_path
from drake_mobman.cli.options import Overrides, Scenario
from drake_mobman.cli.stopping import interrupted, until_stopped
from drake_mobman.exit_status import DIED

if TYPE_CHECKING:
    from drake_mobman.simulation.stop import Stop


def field(
    scenario: Scenario,
    out: Annotated[Path, typer.Option(help="Folder for the figures.")] = Path("field"),
    set_: Overrides = [],  # noqa: B006 - typer makes a new list each time.
) -> None:
    """Draws the velocity field that the base of a scenario follows."""

    def work(stop: "Stop") -> int:
        from drake_mobman.report.field import FIELD, write_field
        from drake_mobman.simulation.output_folder import FolderError
        from drake_mobman.simulation.run_folder import check_run_folder

        loaded = load(scenario, set_)
        if loaded.base_controller is None:
            refuse(
                f"{scenario}: its base follows no velocity field; petric_guided does"
            )
        try:
            check_run_folder(out, FIELD)
        except FolderError as error:
            refuse(error)
        try:
            write_field(loaded, out, lambda draw: stop.cut_short(1, draw))
        except (Exception, SystemExit) as error:
            complain(f"{out}: not written: {error}")
            return DIED
        except KeyboardInterrupt:
            return interrupted(stop)
        say_path("written to", out)
        return 0

    until_stopped(work)
