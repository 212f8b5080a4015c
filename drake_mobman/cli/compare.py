"""`mobman compare`: decomposers side by side on the same scenarios."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drake_mobman.cli.loading import load_all
from drake_mobman.cli.messages import complain, console, refuse, say_path
from drake_mobman.cli.options import MaybeScenarios, Overrides
from drake_mobman.cli.progress import progress_bar
from drake_mobman.cli.stopping import until_stopped
from drake_mobman.cli.study import compare_over, completed_studies
from drake_mobman.cli.table import print_metrics
from drake_mobman.exit_status import DIED, INTERRUPTED

if TYPE_CHECKING:
    from drake_mobman.analysis.compare import Comparison
    from drake_mobman.scenario import AnyScenario, Teleop
    from drake_mobman.simulation.output_folder import OutputFolder
    from drake_mobman.simulation.run import Run
    from drake_mobman.simulation.stop import Stop

Decomposers = dict[str, type]
"""Classes of parameters by the decomposers' names."""


def compare(
    scenarios: MaybeScenarios = [],  # noqa: B006 - typer makes a new list each time.
    decomposers: Annotated[
        str,
        typer.Option(
            metavar="NAME,...",
            help="As in exact,blending,switching; a wrong name shows all valid ones.",
        ),
    ] = "",
    over: Annotated[
        str,
        typer.Option(
            metavar="STUDY",
            help="As in robots, a table with a row each; it may need no scenario.",
            autocompletion=completed_studies,
        ),
    ] = "",
    out: Annotated[Path, typer.Option(help="Folder for the comparisons.")] = Path(
        "comparison"
    ),
    set_: Overrides = [],  # noqa: B006 - typer makes a new list each time.
) -> None:
    """Compares decomposers on scenarios, or all that a study is over, in a table."""
    if bool(decomposers) == bool(over):
        refuse("give --decomposers NAME,... or --over STUDY, one of the two")
    if over:
        compare_over(over, scenarios, set_, out)
    if not scenarios:
        refuse("give a SCENARIO to compare decomposers on")

    def work(stop: "Stop") -> int:
        from drake_mobman.report.comparison import COMPARISON

        chosen = chosen_or_refused(decomposers)
        loaded = load_all(scenarios, set_, out, COMPARISON)
        check_each(loaded, chosen)
        status = 0
        for name, scenario in loaded.items():
            if stop():
                complain(f"{name}: interrupted, not run")
                break
            ended = compare_one(scenario, chosen, out / name, stop)
            status = status or ended
            if ended == INTERRUPTED:
                break
        return status

    until_stopped(work)


def chosen_or_refused(names: str) -> Decomposers:
    """Returns the decomposers that are named, with commas between, or refuses."""
    from drake_mobman.analysis.compare import chosen_decomposers
    from drake_mobman.parameters import ParameterError

    try:
        return chosen_decomposers(names.split(","))
    except ParameterError as error:
        refuse(error)


def check_each(loaded: "dict[str, AnyScenario]", decomposers: Decomposers) -> None:
    """Refuses unless every scenario works with every decomposer."""
    from drake_mobman.analysis.compare import with_each
    from drake_mobman.scenario import ScenarioError

    for name, scenario in loaded.items():
        try:
            with_each(scenario, decomposers)
        except ScenarioError as error:
            refuse(f"{name}: {error}")


def compare_one(
    scenario: "AnyScenario",
    decomposers: Decomposers,
    folder: Path,
    stop: "Stop",
) -> int:
    """Compares decomposers on a scenario into a folder; returns an exit status.

    If the user does not wait, it is a comparison of what was run until then.
    """
    from drake_mobman.analysis.compare import compared
    from drake_mobman.report.comparison import COMPARISON, write_comparison
    from drake_mobman.simulation.output_folder import OutputFolder

    try:
        with OutputFolder(folder, COMPARISON) as opened:

            def run_with(decomposer: str, variant: "Teleop") -> "Run":
                return run_one(decomposer, variant, opened, stop)

            comparison = compared(scenario, decomposers, run_with, stop)
            write_comparison(comparison, scenario.name, opened)
            status = add_picture(comparison, opened, folder, stop)
    except (Exception, SystemExit) as error:
        complain(f"{folder}: not written: {error}")
        return DIED
    except KeyboardInterrupt:
        complain(f"{folder}: interrupted, not written")
        return INTERRUPTED
    print_metrics(comparison.metrics, title=scenario.name)
    console.print()
    say_path("written to", folder)
    if any(run.interrupted for run in comparison.runs.values()):
        return INTERRUPTED
    died = any(run.died for run in comparison.runs.values())
    return status or (DIED if died else 0)


def run_one(
    decomposer: str, variant: "Teleop", folder: "OutputFolder", stop: "Stop"
) -> "Run":
    """Returns the run of a scenario with one of the decomposers."""
    from drake_mobman.simulation.simulate import simulate
    from drake_mobman.simulation.tick_times import tick_times

    title = f"{variant.name}, {decomposer}"
    part = folder.file(f"{decomposer}.part")
    with progress_bar(title, variant.duration) as progress:
        run = simulate(variant, progress=progress, stop=stop, part=part)
    if run.died:
        complain(f"{title}: {run.died}")
    elif not stop():
        run.tick_times = tick_times(variant)
    return run


def add_picture(
    comparison: "Comparison", opened: "OutputFolder", folder: Path, stop: "Stop"
) -> int:
    """Adds the figure to a comparison that is written; returns an exit status."""
    from drake_mobman.report.comparison import draw

    try:
        picture = stop.cut_short(2, lambda: draw(comparison))
        opened.put("comparison.png", picture)
    except (Exception, SystemExit) as error:
        complain(f"{folder}: picture not written: {error}")
        return DIED
    return 0
