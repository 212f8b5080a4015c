"""`mobman compare --over STUDY`: rows of runs, and a table of their numbers."""

from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from drake_mobman.cli.loading import load_runnable
from drake_mobman.cli.messages import complain, console, refuse, say_path
from drake_mobman.cli.progress import progress_bar
from drake_mobman.cli.stopping import until_stopped
from drake_mobman.exit_status import DIED, INTERRUPTED

if TYPE_CHECKING:
    from drake_mobman.analysis.studies import Studied, Study
    from drake_mobman.scenario import AnyScenario
    from drake_mobman.simulation.run import Run
    from drake_mobman.simulation.stop import Stop

_NAMES = ("faults", "robots")
"""Of all studies, for the shell's completion, which must not wait for Drake."""


def completed_studies(incomplete: str) -> list[str]:
    """Returns the names of studies that begin so, for the shell's completion."""
    return [name for name in _NAMES if name.startswith(incomplete)]


def compare_over(
    name: str, scenarios: list[str], overrides: list[str], out: Path, engines: str = ""
) -> NoReturn:
    """Runs a study, in each of some engines, and exits with its status."""

    def work(stop: "Stop") -> int:
        study = chosen_or_refused(name, engines)
        given = scenarios or [""]
        if study.own and (scenarios or overrides):
            refuse(
                f"--over {name} has scenarios of its own; give no SCENARIO, no --set"
            )
        if not study.own and not scenarios:
            refuse(f"give a SCENARIO for --over {name}")
        loaded = {each: rows_or_refused(study, each, overrides) for each in given}
        folders = {each: folder_or_refused(out, each, name) for each in given}
        status = 0
        for each, rows in loaded.items():
            status = status or study_one(study, rows, folders[each], stop)
        return status

    until_stopped(work)


def chosen_or_refused(name: str, engines: str) -> "Study":
    """Returns a study by its name, in the engines that are named, or refuses."""
    from drake_mobman.analysis.compare import chosen_engines
    from drake_mobman.analysis.studies import STUDIES, InEngines
    from drake_mobman.parameters import ParameterError

    if name not in STUDIES:
        known = ", ".join(STUDIES)
        refuse(f"--over: {name} is not valid; must be one of {known}")
    if not engines:
        return STUDIES[name]
    try:
        return InEngines(STUDIES[name], chosen_engines(engines.split(",")))
    except ParameterError as error:
        refuse(error)


def rows_or_refused(
    study: "Study", given: str, overrides: list[str]
) -> "dict[str, dict[str, AnyScenario]]":
    """Returns the scenarios of a study, all checked, or refuses."""
    from drake_mobman.scenario import ScenarioError

    scenario = load_runnable(given, overrides) if given else None
    try:
        return study.rows(scenario)
    except ScenarioError as error:
        refuse(error)


def folder_or_refused(out: Path, given: str, name: str) -> Path:
    """Returns where a study is written to, or refuses."""
    from drake_mobman.report.study import STUDY
    from drake_mobman.simulation.output_folder import FolderError
    from drake_mobman.simulation.run_folder import check_run_folder

    title = f"{Path(given).stem}_over_{name}" if given else f"over_{name}"
    try:
        check_run_folder(out / title, STUDY)
    except FolderError as error:
        refuse(error)
    return out / title


def study_one(
    study: "Study",
    rows: "dict[str, dict[str, AnyScenario]]",
    folder: Path,
    stop: "Stop",
) -> int:
    """Runs a study into a folder and prints its table; returns an exit status."""
    from drake_mobman.analysis.studies import studied
    from drake_mobman.report.study import STUDY, write_study
    from drake_mobman.simulation.output_folder import OutputFolder

    died: list[str] = []

    def run(title: str, scenario: "AnyScenario") -> "Run":
        from drake_mobman.simulation.simulate import simulate

        with progress_bar(title, scenario.duration) as progress:
            done = simulate(scenario, progress=progress, stop=stop)
        if done.died:
            died.append(title)
            complain(f"{title}: {done.died}")
        return done

    try:
        with OutputFolder(folder, STUDY) as opened:
            done = studied(study, rows, run, stop)
            write_study(done, folder.name, opened)
    except (Exception, SystemExit) as error:
        complain(f"{folder}: not written: {error}")
        return DIED
    except KeyboardInterrupt:
        complain(f"{folder}: interrupted, not written")
        return INTERRUPTED
    print_study(done)
    say_path("written to", folder)
    return stop.status or (DIED if died else 0)


def print_study(done: "Studied") -> None:
    """Prints the table of a study."""
    from rich import box
    from rich.table import Table

    from drake_mobman.analysis.table import shown

    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    table.add_column(done.study.name)
    for column in done.study.columns:
        unit = f"\n{column.unit}" if column.unit else ""
        table.add_column(f"{column.name}{unit}", justify="right")
    for row, numbers in done.numbers().items():
        table.add_row(row, *map(shown, numbers.values()))
    console.print(table)
    console.print()
