"""What `mobman drive` does around a session: opens what is named, serves, and ends."""

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

_LOOK = 0.05
"""Between two looks at whether one has been asked to end [s]."""


class Served(Protocol):
    """What a session is driven from."""

    address: str  # What to open in a browser.

    def run(self) -> None:
        """Serves until `close`."""

    def close(self) -> None:
        """Has `run` return."""


def scenario_file(given: str) -> str:
    """Returns what `load_scenario` takes: the same, or the scenario of a run folder.

    Raises:
        ScenarioError: where there is a folder, and none in it.
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


def serve(served: Served, stop: Stop) -> None:
    """Serves a session until its user asks to end, by whatever signal."""
    ended = threading.Event()

    def look() -> None:
        while not stop():
            if ended.wait(_LOOK):
                return
        served.close()

    looking = threading.Thread(target=look, name="stop", daemon=True)
    looking.start()
    try:
        served.run()
    finally:
        ended.set()
        looking.join()


def open_page(address: str) -> None:
    """Opens a page in the browser, if a person sits at a screen here."""
    # Without a screen, a browser in text may come up in the terminal.
    screens = ("DISPLAY", "WAYLAND_DISPLAY")
    seen = sys.platform in {"darwin", "win32"} or any(map(os.environ.get, screens))
    if seen and sys.stdout and sys.stdout.isatty():
        webbrowser.open(address)
