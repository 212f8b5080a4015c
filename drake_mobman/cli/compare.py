"""`mobman compare`: decomposers and engines side by side on the same scenarios."""

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
    from drake_mobman.scenario import AnyScenario
    from drake_mobman.simulation.output_folder import OutputFolder
    from drake_mobman.simulation.run import Run
    from drake_mobman.simulation.stop import Stop

Kinds = dict[str, type]
"""Classes of parameters by the names of their kinds."""


def compare(
    scenarios: MaybeScenarios = [],  # noqa: B006 - typer makes a new list each time.
    decomposers: Annotated[
        str,
        typer.Option(
            metavar="NAME,...",
            help="As in exact,blending,switching; a wrong name shows all valid ones.",
        ),
    ] = "",
    engine: Annotated[
        str,
        typer.Option(
            metavar="NAME,...",
            help="As in drake,mujoco: what steps the robot; alone, or with any other.",
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
    """Compares decomposers, engines or all that a study is over, in a table."""
    if not (decomposers or engine or over):
        refuse("give --decomposers NAME,..., --engine NAME,... or --over STUDY")
    if over:
        if decomposers:
            refuse("--over STUDY has its own decomposers; give it alone")
        compare_over(over, scenarios, set_, out, engine)
    if not scenarios:
        refuse("give a SCENARIO to compare on")

    def work(stop: "Stop") -> int:
        from drake_mobman.report.comparison import COMPARISON

        chosen = chosen_or_refused(decomposers, engine)
        loaded = load_all(scenarios, set_, out, COMPARISON)
        variants = {x: variants_or_refused(y, *chosen) for x, y in loaded.items()}
        status = 0
        for name, scenario in loaded.items():
            if stop():
                complain(f"{name}: interrupted, not run")
                break
            ended = compare_one(scenario, variants[name], out / name, stop)
            status = status or ended
            if ended == INTERRUPTED:
                break
        return status

    until_stopped(work)


def chosen_or_refused(decomposers: str, engines: str) -> tuple[Kinds, Kinds]:
    """Returns what is named, with commas between, or refuses."""
    from drake_mobman.analysis.compare import chosen_decomposers, chosen_engines
    from drake_mobman.parameters import ParameterError

    try:
        return (
            chosen_decomposers(decomposers.split(",")) if decomposers else {},
            chosen_engines(engines.split(",")) if engines else {},
        )
    except ParameterError as error:
        refuse(error)


def variants_or_refused(
    scenario: "AnyScenario", decomposers: Kinds, engines: Kinds
) -> "dict[str, AnyScenario]":
    """Returns a scenario with each decomposer in each engine, or refuses."""
    from drake_mobman.analysis.compare import variants_of
    from drake_mobman.scenario import ScenarioError

    try:
        return variants_of(scenario, decomposers, engines)
    except ScenarioError as error:
        refuse(f"{scenario.name}: {error}")


def compare_one(
    scenario: "AnyScenario",
    variants: "dict[str, AnyScenario]",
    folder: Path,
    stop: "Stop",
) -> int:
    """Compares variants of a scenario into a folder; returns an exit status.

    If the user does not wait, it is a comparison of what was run until then.
    """
    from drake_mobman.analysis.compare import compared
    from drake_mobman.report.comparison import COMPARISON, write_comparison
    from drake_mobman.simulation.output_folder import OutputFolder

    try:
        with OutputFolder(folder, COMPARISON) as opened:

            def run(name: str, variant: "AnyScenario") -> "Run":
                return run_one(name, variant, opened, stop)

            comparison = compared(scenario, variants, run, stop)
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
    name: str, variant: "AnyScenario", folder: "OutputFolder", stop: "Stop"
) -> "Run":
    """Returns the run of one of a scenario's variants."""
    from drake_mobman.simulation.simulate import simulate
    from drake_mobman.simulation.tick_times import tick_times

    title = f"{variant.name}, {name}"
    part = folder.file(f"{name}.part")
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
