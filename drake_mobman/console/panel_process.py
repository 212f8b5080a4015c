"""Meshcat's panel in a process of its own, which may end, freeze or be killed.

Any web site that finds its port can end Meshcat by a frame that it cannot read. That
ends this process alone: the robot stops, as nobody is heard, and the panel is started
again where it was, so that its page in the browser comes back by itself.
"""

import json
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any, NamedTuple, NoReturn

from pydrake.common import use_native_cpp_logging

from drake_mobman.console.mailbox import OperatorInput
from drake_mobman.console.plain import Panel
from drake_mobman.console.session import LiveSession, Snapshot
from drake_mobman.console.view import PERIOD
from drake_mobman.meshcat import local_meshcat, unguessed_host
from drake_mobman.scenario import AnyScenario

EXPOSED = (
    "Meshcat's panel asks nobody who they are: whoever on this machine finds its "
    "address, a web site open in a browser included, sees and drives the robot"
)
"""What is to be known by who drives from it."""

_STARTS = 30.0
"""How long the panel may take until it serves [s]."""

_SILENT = 3.0
"""After what silence it counts as frozen, and is killed [s]."""

_AGAIN = 1.0
"""Between two starts of it, at least [s]."""

_LOWEST = 1024
"""Of ports that Meshcat takes."""


class Place(NamedTuple):
    """Where the panel is served."""

    host: str
    port: int


def free_place(port: int | None = None) -> Place:
    """Returns where a panel may be served, on this machine alone.

    Args:
        port: at 127.0.0.1; 0 or None for any, at an address that nobody guesses.

    Raises:
        OSError: where the port cannot be had.
    """
    if port and port < _LOWEST:
        raise OSError(0, f"it must be {_LOWEST} or above")
    host = "127.0.0.1" if port else unguessed_host()
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        probe.bind((host, port or 0))
        return Place(*probe.getsockname())


class PanelProcess:
    """Keeps the panel's process going, and passes on to the session what it says.

    Args:
        session: that is driven.
        place: where the panel is served.
        complain: is told, in a line, when the panel has to be started again.
    """

    def __init__(
        self, session: LiveSession, place: Place, complain: Callable[[str], None]
    ) -> None:
        self._session = session
        self._place = place
        self._complain = complain
        self._closing = threading.Event()
        self._start()

    @property
    def address(self) -> str:
        """Returns what to open in a browser."""
        return f"http://{self._place.host}:{self._place.port}/?tracked_camera=on"

    def run(self) -> None:
        """Goes on until `close`, or until it is interrupted."""
        try:
            while why := self._attend():
                self._end()
                # Who drove is gone: the next panel counts anew, and is to be armed.
                self._session.hand_over()
                self._complain(f"the panel {why}; the robot stops, it is started again")
                self._closing.wait(_AGAIN)
                self._start()
        finally:
            self._end()

    def close(self) -> None:
        """Has `run` return."""
        self._closing.set()

    def _start(self) -> None:
        ours, theirs = Pipe()
        with theirs:
            number = theirs.fileno()
            # -P: what is installed, whatever folder one happens to be in.
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", __name__, str(number)],
                pass_fds=[number],
                # What Drake says there of nonsense that it hears, is for nobody.
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C is for the session.
            )
        self._pipe = ours
        about = self._session.scenario, self._session.choices, self._place
        with suppress(OSError):  # It has ended already.
            self._pipe.send(about)
            self._pipe.poll(_STARTS)

    def _attend(self) -> str:
        """Answers the panel until it says no more; returns why, or "" to end."""
        try:
            while self._pipe.poll(_SILENT):
                if self._closing.is_set():
                    return ""
                said = json.loads(self._pipe.recv_bytes())
                late = max(0.0, time.monotonic() - said["at"])
                for what, *details in said["calls"]:
                    self._obey(what, details, late)
                self._pipe.send(self._session.snapshot())
        except (EOFError, OSError):
            return "has ended"
        return "is not heard any more"

    def _obey(self, what: str, details: list[Any], late: float) -> None:
        match what:
            case "tell":
                self._session.tell(OperatorInput(*details), late)
            case "stop" | "choose" | "reset":
                getattr(self._session, what)(*details)

    def _end(self) -> None:
        self._pipe.close()
        self._process.kill()
        self._process.wait()


class RemoteSession:
    """A session in another process, as far as a panel asks for it.

    Args:
        scenario: of the session.
        choices: of the session.
        pipe: to the session.
    """

    def __init__(
        self, scenario: AnyScenario, choices: list[str], pipe: Connection
    ) -> None:
        self.scenario = scenario
        self.choices = choices
        self._pipe = pipe
        self._calls: list[tuple[Any, ...]] = []

    def tell(self, said: OperatorInput) -> None:
        """Passes on what the operator says."""
        self._calls.append(
            ("tell", said.sequence, said.v_c, said.omega_c, said.v_z, said.dead_man)
        )

    def stop(self, who: str) -> None:
        """Stops the robot."""
        self._calls.append(("stop", who))

    def choose(self, name: str) -> None:
        """Lets one of `choices` drive."""
        self._calls.append(("choose", name))

    def reset(self) -> None:
        """Starts over."""
        self._calls.append(("reset",))

    def snapshot(self) -> Snapshot:
        """Says all that there is to say, and returns the session as it is."""
        # The monotonic clock is one for all of a machine's processes.
        said = {"at": time.monotonic(), "calls": self._calls}
        self._calls = []
        self._pipe.send_bytes(json.dumps(said).encode())
        snapshot: Snapshot = self._pipe.recv()
        return snapshot


def serve(pipe: Connection) -> NoReturn:
    """Serves a panel until Meshcat or the session has ended."""
    try:
        scenario, choices, place = pipe.recv()
        use_native_cpp_logging()
        session = RemoteSession(scenario, choices, pipe)
        panel = Panel(session, local_meshcat(*place))
        while True:
            panel.step()
            time.sleep(PERIOD)
    finally:
        # At once: Meshcat waits for a thread that may be at work, or has ended.
        os._exit(0)


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])))
