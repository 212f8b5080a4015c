"""`mobman bench`: how long a control tick takes, and whole runs."""

import json
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drake_mobman.cli.loading import load_runnable
from drake_mobman.cli.messages import complain, console, errors, refuse
from drake_mobman.cli.options import Overrides, Scenario
from drake_mobman.cli.stopping import until_stopped
from drake_mobman.exit_status import DIED, INTERRUPTED

if TYPE_CHECKING:
    from drake_mobman.scenario import AnyScenario
    from drake_mobman.simulation.stop import Stop


def bench(
    scenario: Scenario = "kwon_arbitrary",
    out: Annotated[
        Path | None, typer.Option(help="File for the numbers; must end in .json.")
    ] = None,
    turns: Annotated[
        int, typer.Option(min=1, help="Number of rounds; more give steadier numbers.")
    ] = 20,
    set_: Overrides = [],  # noqa: B006 - typer makes a new list each time.
) -> None:
    """Times a control tick of each decomposer, and whole runs."""
    until_stopped(lambda stop: bench_one(scenario, out, turns, set_, stop))


def bench_one(
    scenario: str, out: Path | None, turns: int, set_: list[str], stop: "Stop"
) -> int:
    """Times it all; returns an exit status."""
    from drake_mobman.benchmarking.bench import bench as timed
    from drake_mobman.benchmarking.tables import report
    from drake_mobman.files import FolderError, new_file
    from drake_mobman.simulation.simulate import simulate

    loaded = load_comparable(scenario, set_)
    name = loaded.name
    if out and out.suffix != ".json":
        refuse(f"{out}: must end in .json")
    try:
        with new_file(out) if out else nullcontext() as draft:
            recorded = simulate(loaded, stop=stop)
            if recorded.died:
                complain(f"{name}: {recorded.died}; nothing is timed")
                return INTERRUPTED if recorded.interrupted else DIED
            with errors.status("") as shown:
                content = stop.cut_short(
                    1, lambda: timed(loaded, recorded, turns, shown.update)
                )
            text = json.dumps({"scenario": name} | content, indent=2)
            if draft:
                draft.write_text(text + "\n", "utf-8")
            console.print(report(content, name), soft_wrap=True, highlight=False)
    except FolderError as error:
        refuse(error)
    except OSError as error:
        complain(f"{out}: not written: {error}")
        return DIED
    except KeyboardInterrupt:
        complain("interrupted")
        return INTERRUPTED
    return 0


def load_comparable(given: str, set_: list[str]) -> "AnyScenario":
    """Returns a scenario that decomposers can be compared on, or refuses."""
    from drake_mobman.analysis.compare import with_each
    from drake_mobman.parameters import ParameterError
    from drake_mobman.scenario import ScenarioError
    from drake_mobman.simulation.size import check_room

    loaded = load_runnable(given, set_)
    try:
        with_each(loaded, {})
        check_room(loaded)
    except (ScenarioError, ParameterError) as error:
        refuse(f"{loaded.name}: {error}")
    return loaded
