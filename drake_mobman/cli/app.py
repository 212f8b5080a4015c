"""The command line, `mobman`.

Nothing of Drake is imported until a command needs it: `mobman --help` is quick.
"""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from drake_mobman.exit_status import BAD_INPUT, DIED, INTERRUPTED
from drake_mobman.output import refused
from drake_mobman.terminal import visible

app = typer.Typer(
    help="Steer the hand of a mobile manipulator, and the wheels follow.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
# A name is no markup: `[bold].yaml` is a file like any other.
console = Console(emoji=False, markup=False)
errors = Console(stderr=True, soft_wrap=True, emoji=False, markup=False)

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
    with suppress(OSError):  # Of a terminal that has gone.
        errors.print(visible(line), highlight=False)


def say(line: str) -> None:
    """Prints one line to the standard output, as it is."""
    console.print(visible(line), soft_wrap=True, highlight=False)


def refuse(message: object) -> NoReturn:
    """Ends the command over bad input, with one line and exit status 2."""
    complain(message)
    raise typer.Exit(BAD_INPUT)


@app.command("list")
def list_() -> None:
    """Lists the scenarios with a line each."""
    from drake_mobman.scenario import load_scenario, scenario_paths

    paths = scenario_paths()
    width = max(map(len, paths))
    for name in paths:
        say(f"{name:{width}}  {load_scenario(name).description}")


@app.command()
def run(
    scenarios: Scenarios,
    out: Annotated[Path, typer.Option(help="Where the run folders go.")] = Path("runs"),
    set_: Overrides = [],  # noqa: B006 - typer makes a new list each time.
    figures: Annotated[bool, typer.Option(help="Draw the figures.")] = True,
    scene: Annotated[bool, typer.Option("--scene", help="Write the 3D scene.")] = False,
    log_period: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS", help="Between samples of log.npz; metrics see them all."
        ),
    ] = None,
) -> None:
    """Simulates scenarios headless, and writes a run folder for each."""
    from drake_mobman.simulation.stop import Stop

    with Stop() as stop:
        from drake_mobman.parameters import ParameterError
        from drake_mobman.report.job import Job, Shown, Wanted
        from drake_mobman.simulation.run_folder import RUN

        loaded = load_all(scenarios, set_, out, RUN)
        every = {
            name: samples_between(scenario, log_period)
            for name, scenario in loaded.items()
        }
        results: dict[str, Any] = {}
        status = 0
        for name, scenario in loaded.items():
            if stop():
                complain(f"{name}: interrupted, not run")
                break
            wanted = Wanted(figures, scene, every[name])
            shown = Shown(complain, progress_bar)
            job = Job(name, scenario, out / name, wanted, stop, shown)
            try:
                job.run()
            except ParameterError as error:
                refuse(f"{name}: {error}")
            if job.numbers:
                results[name] = job.numbers
            status = status or job.status
        if results:
            print_metrics(results)
            say(f"written to {out}")
        raise typer.Exit(stop.status or status)


def samples_between(scenario: Any, log_period: float | None) -> int:
    """Returns of how many samples one is kept, or refuses."""
    if log_period is None:
        return 1
    every = log_period / scenario.period
    if not 0.5 < every < 1e9 or abs(every - round(every)) > 1e-6 * every:
        whole = f"a multiple of the period, {scenario.period:g}"
        refuse(f"--log-period: {log_period:g} is not valid; must be {whole}")
    return round(every)


def load_all(
    scenarios: list[str], overrides: list[str], out: Path, ours: tuple[str, ...]
) -> dict[str, Any]:
    """Returns the scenarios by name, or refuses: all is looked through before a run.

    Each gets its own folder in `out`, which is new or holds nothing but `ours`.
    """
    from drake_mobman.parameters import ParameterError
    from drake_mobman.simulation.output_folder import FolderError
    from drake_mobman.simulation.run_folder import check_run_folder
    from drake_mobman.simulation.size import check_room

    loaded: dict[str, Any] = {}
    for given in scenarios:
        name, scenario = load_runnable(given, overrides)
        if name in loaded:
            refuse(f"{given}: {name} is given twice; each goes to its own folder")
        try:
            check_run_folder(out / name, ours)
            check_room(scenario, out / name)
        except FolderError as error:
            refuse(error)
        except ParameterError as error:
            refuse(f"{given}: {error}")
        loaded[name] = scenario
    return loaded


def load_runnable(given: str, overrides: list[str]) -> tuple[str, Any]:
    """Returns a scenario's name, and the scenario, or refuses."""
    from drake_mobman.scenario import ScenarioError, load_scenario
    from drake_mobman.teleop.external import External
    from drake_mobman.teleop.live import Operator

    try:
        scenario = load_scenario(given, overrides)
        name = scenario.name
    except ScenarioError as error:
        refuse(error)
    source = getattr(scenario, "source", None)
    if isinstance(source, External | Operator):
        kind = type(source).__name__
        refuse(f"{given}: source: !{kind} is fed by a program, not from here")
    return name, scenario


@app.command()
def compare(
    scenarios: Scenarios,
    decomposers: Annotated[
        str, typer.Option(metavar="NAME,...", help="As `--set decomposer=` takes them.")
    ],
    out: Annotated[Path, typer.Option(help="Where the comparisons go.")] = Path(
        "comparison"
    ),
    set_: Overrides = [],  # noqa: B006 - typer makes a new list each time.
) -> None:
    """Runs scenarios with each of some decomposers, and writes what they make of it."""
    from drake_mobman.simulation.stop import Stop

    with Stop() as stop:
        from drake_mobman.analysis.compare import chosen_decomposers, with_each
        from drake_mobman.parameters import ParameterError
        from drake_mobman.scenario import ScenarioError
        from drake_mobman.simulation.run_folder import COMPARISON

        try:
            chosen = chosen_decomposers(decomposers.split(","))
        except ParameterError as error:
            refuse(error)
        loaded = load_all(scenarios, set_, out, COMPARISON)
        for name, scenario in loaded.items():
            try:
                with_each(scenario, chosen)
            except ScenarioError as error:
                refuse(f"{name}: {error}")

        status = 0
        for name, scenario in loaded.items():
            if stop():
                complain(f"{name}: interrupted, not run")
                break
            ended = compare_one(name, scenario, chosen, out / name, stop)
            status = status or ended
            if ended == INTERRUPTED:
                break
        raise typer.Exit(stop.status or status)


def compare_one(
    name: str, scenario: Any, decomposers: dict[str, type], folder: Path, stop: Any
) -> int:
    """Compares decomposers on a scenario into a folder; returns an exit status.

    If the user will not wait, it is a comparison as far as it goes.
    """
    from drake_mobman.analysis.compare import compared, draw, write_comparison
    from drake_mobman.simulation.output_folder import OutputFolder
    from drake_mobman.simulation.run_folder import COMPARISON
    from drake_mobman.simulation.simulate import simulated, tick_times

    def run_with(decomposer: str, variant: Any) -> Any:
        title = f"{name}, {decomposer}"
        part = opened.file(f"{decomposer}.part")
        with progress_bar(title, variant.duration) as progress:
            result = simulated(variant, progress=progress, stop=stop, part=part)
        if result.died:
            complain(f"{title}: {result.died}")
        elif not stop():
            result.tick_times = tick_times(variant)
        return result

    status = 0
    try:
        with OutputFolder(folder, COMPARISON) as opened:
            comparison = compared(scenario, decomposers, run_with, stop)
            write_comparison(comparison, name, opened)
            try:
                picture = stop.cut_short(2, lambda: draw(comparison))
                opened.put("comparison.png", picture)
            except (Exception, SystemExit) as error:
                complain(f"{folder}: picture not written: {error}")
                status = DIED
    except (Exception, SystemExit) as error:
        complain(f"{folder}: not written: {error}")
        return DIED
    except KeyboardInterrupt:
        complain(f"{folder}: interrupted, not written")
        return INTERRUPTED
    print_metrics(comparison.metrics, title=name)
    say(f"written to {folder}")
    if any(run.interrupted for run in comparison.runs.values()):
        return INTERRUPTED
    died = any(run.died for run in comparison.runs.values())
    return status or (DIED if died else 0)


@app.command()
def bench(
    scenario: Annotated[
        str, typer.Argument(metavar="SCENARIO", help="Whose ticks are timed.")
    ] = "kwon_arbitrary",
    out: Annotated[
        Path | None, typer.Option(help="A .json file for the numbers.")
    ] = None,
    turns: Annotated[int, typer.Option(min=1, help="Over which all is spread.")] = 20,
    set_: Overrides = [],  # noqa: B006 - typer makes a new list each time.
) -> None:
    """Times a tick of each decomposer beside optimisers, and whole runs."""
    from drake_mobman.simulation.stop import Stop

    with Stop() as stop:
        status = bench_one(scenario, out, turns, set_, stop)
        raise typer.Exit(stop.status or status)


def bench_one(
    scenario: str, out: Path | None, turns: int, set_: list[str], stop: Any
) -> int:
    """Times it all; returns an exit status."""
    import json

    from drake_mobman.analysis.compare import with_each
    from drake_mobman.benchmarking.bench import bench as timed
    from drake_mobman.benchmarking.bench import report
    from drake_mobman.parameters import ParameterError
    from drake_mobman.scenario import ScenarioError
    from drake_mobman.simulation.output_folder import FolderError, new_file
    from drake_mobman.simulation.simulate import simulated
    from drake_mobman.simulation.size import check_room

    name, loaded = load_runnable(scenario, set_)
    try:
        with_each(loaded, {})
        check_room(loaded)
    except (ScenarioError, ParameterError) as error:
        refuse(f"{name}: {error}")
    if out and out.suffix != ".json":
        refuse(f"{out}: must end in .json")
    try:
        with new_file(out) if out else nullcontext() as draft:
            recorded = simulated(loaded, stop=stop)
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
            console.print(
                report(content, name), soft_wrap=True, highlight=False, markup=False
            )
    except FolderError as error:
        refuse(error)
    except OSError as error:
        complain(f"{out}: not written: {error}")
        return DIED
    except KeyboardInterrupt:
        complain("interrupted")
        return INTERRUPTED
    return 0


@app.command()
def drive(
    scenario: Annotated[str, typer.Argument(metavar="SCENARIO")],
    record: Annotated[
        Path | None, typer.Option(help="A folder to record to, from the start.")
    ] = None,
    host: Annotated[
        str, typer.Option(help="Where it is served; beyond this machine, by a token.")
    ] = "127.0.0.1",
    port: Annotated[
        int | None, typer.Option(min=0, max=65535, help="The same; 0 for any.")
    ] = None,
    set_: Overrides = [],  # noqa: B006 - typer makes a new list each time.
    plain: Annotated[
        bool, typer.Option("--plain", help="Drive from Meshcat's own panel.")
    ] = False,
) -> None:
    """Simulates in real time, to be driven from a page in the browser.

    SCENARIO may be a run folder too: then what has been run is driven.
    """
    from drake_mobman.simulation.stop import Stop

    # A signal only says that one wants to end; so nothing is cut off, at any moment.
    with Stop() as stop:
        from drake_mobman.console.driving import scenario_file
        from drake_mobman.scenario import ScenarioError, load_scenario

        try:
            loaded = load_scenario(scenario_file(scenario), set_)
        except ScenarioError as error:
            refuse(error)
        desk = (
            desk_in_meshcat(host, port) if plain else desk_on_a_page(loaded.name, host, port)
        )
        raise typer.Exit(drive_one(loaded.name, loaded, record, desk, stop))


def drive_one(
    name: str, scenario: Any, record: Path | None, desk: Callable[[Any], Any], stop: Any
) -> int:
    """Has a scenario driven from a desk until one wants to end; returns a status."""
    from drake_mobman.console.driving import open_page, serve
    from drake_mobman.console.session import LiveSession
    from drake_mobman.parameters import ParameterError
    from drake_mobman.simulation.output_folder import FolderError

    if stop():
        return interrupted(stop)
    try:
        session = LiveSession(scenario, record)
    except ParameterError as error:
        refuse(f"{name}: {error}")
    except FolderError as error:
        refuse(error)
    try:
        served = desk(session)
        if stop():
            return interrupted(stop)
        say(f"drive {name} at {served.address}; Ctrl-C ends it")
        if refused(sys.stdout):
            return DIED  # Nobody could find it.
        open_page(served.address)
        serve(served, stop)
    finally:
        # Who asks a second time does not wait for his recordings.
        if not session.close(lambda: len(stop.received) > 1):
            complain("recordings are completed without you; that takes some seconds")
    last = session.snapshot()
    for problem in filter(None, [last.died and f"{name}: {last.died}", last.problem]):
        complain(problem)
    return DIED if last.died or last.problem else 0


def interrupted(stop: Any) -> int:
    """Says that nothing has been done; returns the exit status."""
    complain("interrupted")
    status: int = stop.status
    return status


def desk_on_a_page(name: str, host: str, port: int | None) -> Callable[[Any], Any]:
    """Returns what serves a session by a page, or refuses where that cannot be."""
    from importlib.util import find_spec

    if not find_spec("nicegui"):
        refuse(
            "the page needs NiceGUI: pip install 'drake_mobman[console]'; "
            "--plain goes without"
        )
    from drake_mobman.console.server import Server, listening
    from drake_mobman.terminal import log_in_lines

    log_in_lines()
    wanted = 8080 if port is None else port
    try:
        place = listening(host, wanted)
    except OSError as error:
        refuse(f"cannot serve at {host}, port {wanted}: {error.strerror}")
    except UnicodeError:
        refuse(f"cannot serve at {host}: no name of a host is like that")
    return lambda session: Server(name, session, place)


def desk_in_meshcat(host: str, port: int | None) -> Callable[[Any], Any]:
    """Returns what serves a session by Meshcat alone, or refuses."""
    from drake_mobman.console.panel_process import EXPOSED, PanelProcess, free_place

    if host != "127.0.0.1":
        refuse("--plain is served to this machine alone; --host is for the page")
    try:
        place = free_place(port)
    except OSError as error:
        refuse(f"cannot serve at port {port}: {error.strerror}")

    def desk(session: Any) -> Any:
        complain(EXPOSED)
        return PanelProcess(session, place, complain)

    return desk


@app.command()
def graph(
    scenario: Annotated[str, typer.Argument(metavar="SCENARIO")],
    out: Annotated[Path, typer.Option(help="An .svg or .dot file.")],
    set_: Overrides = [],  # noqa: B006 - typer makes a new list each time.
) -> None:
    """Draws the wired diagram of a scenario."""
    from drake_mobman.simulation.stop import Stop

    with Stop() as stop:
        from drake_mobman.diagrams import make_diagram
        from drake_mobman.diagrams.graph import GraphError, graph_of, write_graph
        from drake_mobman.scenario import ScenarioError, load_scenario
        from drake_mobman.simulation.output_folder import FolderError

        try:
            loaded = load_scenario(scenario, set_)
            diagram = make_diagram(loaded, logged=False)
            content = stop.cut_short(1, lambda: graph_of(diagram, out))
            write_graph(content, out)
        except (ScenarioError, GraphError, FolderError) as error:
            refuse(error)
        except OSError as error:
            complain(f"{out}: not written: {error}")
            raise typer.Exit(DIED) from None
        except KeyboardInterrupt:
            complain("interrupted")
        raise typer.Exit(stop.status)


@app.command()
def field(
    scenario: Annotated[str, typer.Argument(metavar="SCENARIO")],
    out: Annotated[Path, typer.Option(help="Where the figures go.")] = Path("field"),
    set_: Overrides = [],  # noqa: B006 - typer makes a new list each time.
) -> None:
    """Draws the velocity field that a scenario's base follows."""
    from drake_mobman.simulation.stop import Stop

    with Stop() as stop:
        from drake_mobman.scenario import ScenarioError, load_scenario
        from drake_mobman.simulation.output_folder import FolderError
        from drake_mobman.simulation.run_folder import (
            FIELD,
            check_run_folder,
            write_field,
        )

        try:
            loaded = load_scenario(scenario, set_)
            if loaded.base_controller is None:
                refuse(
                    f"{scenario}: its base follows no velocity field; "
                    "petric_guided does"
                )
            check_run_folder(out, FIELD)
        except (ScenarioError, FolderError) as error:
            refuse(error)
        try:
            write_field(loaded, out, lambda draw: stop.cut_short(1, draw))
        except (Exception, SystemExit) as error:
            complain(f"{out}: not written: {error}")
            raise typer.Exit(DIED) from None
        except KeyboardInterrupt:
            complain("interrupted")
            raise typer.Exit(stop.status) from None
        say(f"written to {out}")


@contextmanager
def progress_bar(name: str, total: float, unit: str = " s") -> Iterator[Any]:
    """Shows a bar while its body runs, in a terminal; gives what to tell the progress.

    A terminal that has gone is nothing to end for.
    """
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn(f"{{task.completed:.0f}} of {{task.total:.0f}}{unit}"),
        TimeRemainingColumn(),
    )
    shown = errors.is_terminal
    bar = Progress(*columns, console=errors, disable=not shown, transient=True)
    with suppress(OSError):
        bar.start()
    task = bar.add_task(name, total=total)

    def tell(completed: float) -> None:
        with suppress(OSError):
            bar.update(task, completed=completed)

    try:
        yield tell
    finally:
        with suppress(OSError):
            bar.stop()


def print_metrics(results: dict[str, Any], title: str | None = None) -> None:
    """Prints metrics, a row each and a column for each scenario or decomposer.

    In as many tables as it takes, that none be wider than the console.
    """
    from drake_mobman.analysis.compare import shown, table_of

    room = console.width - max(map(len, table_of(results)), default=0) - 4
    tables: list[list[str]] = [[]]
    for name in results:
        used = sum(_column(other) for other in tables[-1])
        if tables[-1] and used + _column(name) > room:
            tables.append([])
        tables[-1].append(name)
    for names in tables:
        heading = map(visible, names)
        table = Table("metric", *heading, title=title and visible(title))
        for key, row in table_of({name: results[name] for name in names}).items():
            table.add_row(key, *map(shown, row.values()))
        console.print(table)


def _column(name: str) -> int:
    """Returns how wide a column of metrics is, borders included."""
    return max(len(name), len("1.234e-05")) + 3


def main() -> None:
    """Runs the command line."""
    from drake_mobman.__main__ import main as run_all

    run_all()


if __name__ == "__main__":
    main()
