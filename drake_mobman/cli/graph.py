"""`mobman graph`: the wired diagram of a scenario."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drake_mobman.cli.loading import load
from drake_mobman.cli.messages import complain, refuse
from drake_mobman.cli.options import Overrides, Scenario
from drake_mobman.cli.stopping import interrupted, until_stopped
from drake_mobman.exit_status import DIED

if TYPE_CHECKING:
    from drake_mobman.simulation.stop import Stop


def graph(
    scenario: Scenario,
    out: Annotated[Path, typer.Option(help="File to write; must end in .svg or .dot.")],
    set_: Overrides = [],  # noqa: B006 - typer makes a new list each time.
) -> None:
    """Draws the blocks of a scenario and how they are wired."""

    def work(stop: "Stop") -> int:
        from drake_mobman.diagrams import make_diagram
        from drake_mobman.diagrams.graph import GraphError, graph_of, write_graph
        from drake_mobman.simulation.output_folder import FolderError

        loaded = load(scenario, set_)
        try:
            diagram = make_diagram(loaded, logged=False)
            content = stop.cut_short(1, lambda: graph_of(diagram, out))
            write_graph(content, out)
        except (GraphError, FolderError) as error:
            refuse(error)
        except OSError as error:
            complain(f"{out}: not written: {error}")
            return DIED
        except KeyboardInterrupt:
            return interrupted(stop)
        return 0

    until_stopped(work)
