"""The command line, `mobman`.

Nothing of Drake is imported until a command needs it: `mobman --help` is quick.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

app = typer.Typer(
    help="Steer the hand of a mobile manipulator, and the wheels follow.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
console = Console(emoji=False)
errors = Console(stderr=True, soft_wrap=True, emoji=False)

BAD_INPUT = 2
DIED = 1
INTERRUPTED = 130  # As a shell reports Ctrl-C.

Scenarios = Annotated[
    list[str], typer.Argument(metavar="SCENARIO...", help="Names or paths.")
]
Overrides = Annotated[
    list[str],
    typer.Option("--set", metavar="KEY.PATH=VALUE", help="Overrides one value."),
]


def complain(message: object) -> None:
    """Prints one line to the standard error."""
    line = f"mobman: {' '.join(str(message).split())}"
    errors.print(line, markup=False, highlight=False)


def refuse(message: object) -> NoReturn:
    """Ends the command over bad input, with one line and exit status 2."""
    complain(message)
    raise typer.Exit(BAD_INPUT)


@app.command("list")
def list_() -> None:
    """Lists the scenarios with a line each."""
    from drake_mobman.runs.scenario import load_scenario, scenario_paths

    paths = scenario_paths()
    width = max(map(len, paths))
    for name in paths:
        line = f"{name:{width}}  {load_scenario(name)[1].description}"
        console.print(line, soft_wrap=True, highlight=False, markup=False)


@app.command()
def run(
    scenarios: Scenarios,
    out: Annotated[Path, typer.Option(help="Where the run folders go.")] = Path("runs"),
    set_: Overrides = [],  # noqa: B006 - typer makes a new list each time.
    figures: Annotated[bool, typer.Option(help="Draw the figures.")] = True,
    scene: Annotated[bool, typer.Option("--scene", help="Write the 3D scene.")] = False,
) -> None:
    """Simulates scenarios headless, and writes a run folder for each."""
    from drake_mobman.runs.run_folder import FolderError, check_writable
    from drake_mobman.runs.scenario import External, ScenarioError, load_scenario

    # All of it is looked through before any of it runs.
    loaded: dict[str, Any] = {}
    try:
        for given in scenarios:
            name, scenario = load_scenario(given, set_)
            if name in loaded:
                refuse(f"{given}: {name} is given twice; each goes to its own folder")
            if isinstance(getattr(scenario, "source", None), External):
                refuse(f"{given}: source: !External is fed by a program, not by run")
            check_writable(out / name)
            loaded[name] = scenario
    except (ScenarioError, FolderError) as error:
        refuse(error)

    results: dict[str, Any] = {}
    status = 0
    for name, scenario in loaded.items():
        numbers, ended = run_one(name, scenario, out / name, figures, scene)
        if numbers:
            results[name] = numbers
        status = status or ended
        if ended == INTERRUPTED:
            break
    if results:
        print_metrics(results)
        console.print(f"written to {out}", highlight=False, markup=False)
    raise typer.Exit(status)


def run_one(
    name: str, scenario: Any, folder: Path, figures: bool, scene: bool
) -> tuple[dict[str, Any] | None, int]:
    """Runs a scenario into its folder; returns its metrics and an exit status.

    What was logged is kept however the run ends, and pictures come last, so that a
    disk that fills up, or a user who will not wait, costs pictures only.
    """
    from drake_mobman.runs.run_folder import new_folder, write_figures, write_run
    from drake_mobman.runs.scene import write_scene
    from drake_mobman.runs.simulate import simulate

    numbers, status = None, 0
    try:
        with new_folder(folder) as draft:
            with progress_bar(name, scenario.duration) as progress:
                result = simulate(scenario, progress=progress)
            if result.died:
                complain(f"{name}: {result.died}; the log until then is kept")
                status = INTERRUPTED if result.interrupted else DIED
            numbers = write_run(result, draft)
            try:
                if figures and not result.died:
                    write_figures(result, draft)
                if scene and not result.died:
                    write_scene(result, draft / "scene.html")
            except OSError as error:
                complain(f"{name}: pictures not written: {error}")
                status = DIED
            except KeyboardInterrupt:
                complain(f"{name}: interrupted while drawing; the log is kept")
                status = INTERRUPTED
    except OSError as error:
        complain(f"{folder}: not written: {error}")
        return None, DIED
    return numbers, status


@app.command()
def graph(
    scenario: Annotated[str, typer.Argument(metavar="SCENARIO")],
    out: Annotated[Path, typer.Option(help="An .svg or .dot file.")],
    set_: Overrides = [],  # noqa: B006 - typer makes a new list each time.
) -> None:
    """Draws the wired diagram of a scenario."""
    from drake_mobman.diagrams import make_diagram
    from drake_mobman.runs.graph import GraphError, write_graph
    from drake_mobman.runs.scenario import ScenarioError, load_scenario

    try:
        _, loaded = load_scenario(scenario, set_)
        write_graph(make_diagram(loaded, logged=False), out)
    except (ScenarioError, GraphError) as error:
        refuse(error)


@app.command()
def field(
    scenario: Annotated[str, typer.Argument(metavar="SCENARIO")],
    out: Annotated[Path, typer.Option(help="Where the figures go.")] = Path("field"),
    set_: Overrides = [],  # noqa: B006 - typer makes a new list each time.
) -> None:
    """Draws the velocity field that a scenario's base follows."""
    from drake_mobman.runs.figures.field import field_figures
    from drake_mobman.runs.run_folder import FIELD, FolderError, new_folder
    from drake_mobman.runs.scenario import ScenarioError, field_of, load_scenario

    try:
        _, loaded = load_scenario(scenario, set_)
        params = field_of(loaded)
        if params is None:
            refuse(
                f"{scenario}: its base follows no velocity field; petric_guided does"
            )
        with new_folder(out, FIELD) as draft:
            figures = field_figures(params, loaded.robot.reach(), loaded.smoother)
            for name, figure in figures:
                figure.savefig(draft / f"{name}.png")
    except (ScenarioError, FolderError) as error:
        refuse(error)
    console.print(f"written to {out}", highlight=False, markup=False)


@contextmanager
def progress_bar(name: str, duration: float) -> Iterator[Any]:
    """Shows a bar while its body runs, in a terminal; gives what to tell the time."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.0f} of {task.total:.0f} s"),
        TimeRemainingColumn(),
    )
    shown = errors.is_terminal
    with Progress(
        *columns, console=errors, disable=not shown, transient=True
    ) as progress:
        task = progress.add_task(name, total=duration)
        yield lambda time: progress.update(task, completed=time)


def print_metrics(results: dict[str, Any]) -> None:
    """Prints metrics, a row each and a column for each scenario.

    In as many tables as it takes, that none be wider than the console.
    """
    flat = {name: dict(_flat(numbers)) for name, numbers in results.items()}
    keys = dict.fromkeys(key for numbers in flat.values() for key in numbers)
    rows = [key for key in keys if not key.startswith("versions")]
    room = console.width - max(map(len, rows), default=0) - 4
    tables: list[list[str]] = [[]]
    for name in flat:
        used = sum(_column(other) for other in tables[-1])
        if tables[-1] and used + _column(name) > room:
            tables.append([])
        tables[-1].append(name)
    for names in tables:
        table = Table("metric", *names)
        for key in rows:
            if any(key in flat[name] for name in names):
                table.add_row(key, *(_shown(flat[name].get(key)) for name in names))
        console.print(table)


def _column(name: str) -> int:
    """Returns how wide a scenario's column is, borders included."""
    return max(len(name), len("1.234e-05")) + 3


def _flat(numbers: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in numbers.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _shown(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def main() -> None:
    """Runs the command line."""
    app(prog_name="mobman")


if __name__ == "__main__":
    main()
