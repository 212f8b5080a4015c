"""`mobman run`: scenarios simulated, each into a folder of its own."""

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drake_mobman.cli.loading import load_all
from drake_mobman.cli.messages import complain, console, refuse, say_path
from drake_mobman.cli.options import Overrides, Scenarios
from drake_mobman.cli.progress import progress_bar
from drake_mobman.cli.stopping import until_stopped
from drake_mobman.cli.table import print_metrics

if TYPE_CHECKING:
    from drake_mobman.report.job import Job, Wanted
    from drake_mobman.scenario import AnyScenario
    from drake_mobman.simulation.stop import Stop


def run(
    scenarios: Scenarios,
    out: Annotated[Path, typer.Option(help="Folder for the run folders.")] = Path(
        "runs"
    ),
    set_: Overrides = [],  # noqa: B006 - typer makes a new list each time.
    figures: Annotated[bool, typer.Option(help="Draw the figures.")] = True,
    scene: Annotated[
        bool,
        typer.Option("--scene", help="Write the motion in 3D, a page for a browser."),
    ] = False,
    log_period: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            help="Time between two samples of log.npz; the metrics use them all.",
        ),
    ] = None,
    as_json: Annotated[
        bool,
        typer.Option("--json", help="Print folder, metrics and exit status as JSON."),
    ] = False,
) -> None:
    """Simulates scenarios, and writes a run folder for each."""

    def work(stop: "Stop") -> int:
        from drake_mobman.report.job import Wanted
        from drake_mobman.simulation.run_folder import RUN

        loaded = load_all(scenarios, set_, out, RUN)
        wanted = {
            name: Wanted(figures, scene, samples_between(scenario, log_period))
            for name, scenario in loaded.items()
        }
        jobs = run_each(loaded, wanted, out, stop)
        if as_json:
            print_json(jobs)
        else:
            print_results(jobs)
        return next((job.status for job in jobs if job.status), 0)

    until_stopped(work)


def samples_between(scenario: "AnyScenario", log_period: float | None) -> int:
    """Returns of how many samples one is kept in the log, or refuses."""
    if log_period is None:
        return 1
    every = log_period / scenario.period
    if not 0.5 < every < 1e9 or abs(every - round(every)) > 1e-6 * every:
        whole = f"a multiple of the period, {scenario.period:g}"
        refuse(f"--log-period: {log_period:g} is not valid; must be {whole}")
    return round(every)


def run_each(
    loaded: "dict[str, AnyScenario]",
    wanted: "dict[str, Wanted]",
    out: Path,
    stop: "Stop",
) -> "list[Job]":
    """Runs scenarios one by one until the user wants to end; returns what was run."""
    from drake_mobman.parameters import ParameterError
    from drake_mobman.report.job import Job, Shown

    jobs: list[Job] = []
    shown = Shown(complain, progress_bar)
    for name, scenario in loaded.items():
        if stop():
            complain(f"{name}: interrupted, not run")
            break
        job = Job(name, scenario, out / name, wanted[name], stop, shown)
        try:
            job.run()
        except ParameterError as error:
            refuse(f"{name}: {error}")
        jobs.append(job)
    return jobs


def print_results(jobs: "list[Job]") -> None:
    """Prints the metrics of runs in a table, then where each run was written to."""
    from drake_mobman.simulation.run_folder import SCENE

    results = {job.name: job.numbers for job in jobs if job.numbers}
    if not results:
        return
    print_metrics(results)
    console.print()
    for job in jobs:
        if job.numbers:
            say_path("written to", job.folder)
            if (job.folder / SCENE).exists():
                say_path("  scene in", job.folder / SCENE)


def print_json(jobs: "list[Job]") -> None:
    """Prints the same as one JSON object, by the name of the scenario.

    Each has `folder`; `metrics`, null where the run could not be written; and `status`,
    the exit status of `mobman` for it alone, 0 for a run without trouble.
    """
    content = {
        job.name: {
            "folder": str(job.folder),
            "metrics": job.numbers,
            "status": job.status,
        }
        for job in jobs
    }
    sys.stdout.write(json.dumps(content, indent=2, allow_nan=False) + "\n")
