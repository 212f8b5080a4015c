"""Starting and ending `mobman drive`: finds the scenario, serves, opens the browser."""

import os
import sys
import threading
import webbrowser
from pathlib import Path
from typing import Protocol

from drake_mobman.scenario import ScenarioError, scenario_paths
from drake_mobman.simulation.stop import Stop

SCENARIO = "scenario.yaml"
"""The scenario in a run folder."""

_POLL = 0.05
"""Time between two checks whether to end [s]."""


class SessionServer(Protocol):
    """Serves a session to those who drive it."""

    @property
    def address(self) -> str:
        """Returns what to open in a browser."""

    def run(self) -> None:
        """Serves until `close`."""

    def close(self) -> None:
        """Has `run` return."""


def scenario_file(given: str) -> str:
    """Returns the name or file that `load_scenario` takes; of a run folder, its file.

    Raises:
        ScenarioError: where a folder holds no scenario.
    """
    try:
        if given in scenario_paths() or not Path(given).is_dir():
            return given
        if (Path(given) / SCENARIO).is_file():
            return str(Path(given) / SCENARIO)
    except OSError as error:
        raise ScenarioError(f"{given}: cannot be read; {error.strerror}") from None
    raise ScenarioError(
        f"{given}: holds no {SCENARIO}; must be a run folder, a scenario's file or name"
    )


def serve(server: SessionServer, stop: Stop) -> None:
    """Serves a session until a signal asks to end it."""
    ended = threading.Event()

    def watch() -> None:
        while not stop():
            if ended.wait(_POLL):
                return
        server.close()

    watcher = threading.Thread(target=watch, name="stop", daemon=True)
    watcher.start()
    try:
        server.run()
    finally:
        ended.set()
        watcher.join()


def open_page(address: str) -> None:
    """Opens a page in the browser, if a person sits at a screen here."""
    # Without a screen, a text browser may start in the terminal.
    screens = ("DISPLAY", "WAYLAND_DISPLAY")
    screen = sys.platform in {"darwin", "win32"} or any(map(os.environ.get, screens))
    if screen and sys.stdout and sys.stdout.isatty():
        webbrowser.open(address)
