"""`mobman drive`: a scenario in real time, driven by a person."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drake_mobman.cli.loading import load
from drake_mobman.cli.messages import complain, refuse, say
from drake_mobman.cli.options import Overrides, completed_scenarios
from drake_mobman.cli.stopping import interrupted
from drake_mobman.exit_status import DIED
from drake_mobman.output import write_error

if TYPE_CHECKING:
    from drake_mobman.console.launch import SessionServer
    from drake_mobman.console.session import LiveSession
    from drake_mobman.scenario import AnyScenario
    from drake_mobman.simulation.stop import Stop

Serve = Callable[["LiveSession"], "SessionServer"]
"""Puts a session where a person can drive it."""


def drive(
    scenario: Annotated[
        str,
        typer.Argument(
            metavar="SCENARIO",
            help="Name of a scenario, path of its file, or a run folder.",
            autocompletion=completed_scenarios,
        ),
    ],
    record: Annotated[
        Path | None, typer.Option(help="Folder to record to, from the start.")
    ] = None,
    host: Annotated[
        str,
        typer.Option(
            help="Address of the page; other than this machine's, it needs a token."
        ),
    ] = "127.0.0.1",
    port: Annotated[
        int | None,
        typer.Option(
            min=0,
            max=65535,
            help="Port of the page, 8080 by default; 0 picks a free one.",
        ),
    ] = None,
    set_: Overrides = [],  # noqa: B006 - typer makes a new list each time.
    plain: Annotated[
        bool,
        typer.Option("--plain", help="Drive from Meshcat's own panel, without a page."),
    ] = False,
) -> None:
    """Drives a scenario in real time, from a page in the browser."""
    from drake_mobman.simulation.stop import Stop

    # A signal only says that one wants to end; so nothing is cut off, at any moment.
    with Stop() as stop:
        from drake_mobman.console.launch import scenario_file
        from drake_mobman.scenario import ScenarioError

        try:
            file = scenario_file(scenario)
        except ScenarioError as error:
            refuse(error)
        loaded = load(file, set_)
        served = on_meshcat(host, port) if plain else on_a_page(loaded.name, host, port)
        raise typer.Exit(drive_one(loaded, record, served, stop))


def drive_one(
    scenario: "AnyScenario",
    record: Path | None,
    serve_session: Serve,
    stop: "Stop",
) -> int:
    """Serves a scenario until its user wants to end; returns an exit status."""
    from drake_mobman.console.launch import open_page, serve
    from drake_mobman.console.session import LiveSession
    from drake_mobman.parameters import ParameterError
    from drake_mobman.simulation.output_folder import FolderError

    if stop():
        return interrupted(stop)
    try:
        session = LiveSession(scenario, record)
    except ParameterError as error:
        refuse(f"{scenario.name}: {error}")
    except FolderError as error:
        refuse(error)
    try:
        served = serve_session(session)
        if stop():
            return interrupted(stop)
        say(f"drive {scenario.name} at {served.address}; Ctrl-C ends it")
        if write_error(sys.stdout):
            return DIED  # Nobody sees the address.
        open_page(served.address)
        serve(served, stop)
    finally:
        # After a second signal, the recordings are completed without the user.
        if not session.close(lambda: len(stop.received) > 1):
            complain("recordings are completed without you; that takes some seconds")
    last = session.snapshot()
    for problem in filter(
        None, [last.died and f"{scenario.name}: {last.died}", last.problem]
    ):
        complain(problem)
    return DIED if last.died or last.problem else 0


def on_a_page(name: str, host: str, port: int | None) -> Serve:
    """Returns what serves a session on a page, or refuses where that cannot be."""
    from importlib.util import find_spec

    if not find_spec("nicegui"):
        refuse(
            "the page needs NiceGUI: pip install 'drake_mobman[console]'; "
            "--plain goes without"
        )
    from drake_mobman.console.addresses import listening
    from drake_mobman.console.server import Server
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


def on_meshcat(host: str, port: int | None) -> Serve:
    """Returns what serves a session by Meshcat alone, or refuses."""
    from drake_mobman.console.addresses import free_address
    from drake_mobman.console.panel_process import EXPOSED, PanelProcess

    if host != "127.0.0.1":
        refuse("--plain is served to this machine alone; --host is for the page")
    try:
        place = free_address(port)
    except OSError as error:
        refuse(f"cannot serve at port {port}: {error.strerror}")

    def serve_session(session: "LiveSession") -> "SessionServer":
        complain(EXPOSED)
        return PanelProcess(session, place, complain)

    return serve_session
