"""Meshcat's panel in a process of its own, which may end, freeze or be killed.

Any web site that finds its port can end Meshcat with a frame that it cannot read. That
ends the panel's process alone: the robot stops, as no input comes, and the panel starts
again at the same address, so that its page in the browser comes back by itself.
"""

import json
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import Pipe
from typing import Any

from drake_mobman.console.addresses import Address
from drake_mobman.console.mailbox import OperatorInput
from drake_mobman.console.session import LiveSession

EXPOSED = (
    "Meshcat's panel has no login: whoever on this machine finds its address, even a "
    "web site open in a browser, can see and drive the robot"
)
"""A warning to those who drive from it."""

_MODULE = "drake_mobman.console.panel_main"
"""What the process runs."""

_START_TIMEOUT = 30.0
"""Longest that the panel may take until it serves [s]."""

_SILENCE_TIMEOUT = 3.0
"""After this time without a message it counts as frozen, and is killed [s]."""

_RESTART_DELAY = 1.0
"""Time between the end of one panel and the start of the next [s]."""


class PanelProcess:
    """Keeps the panel's process running, and passes on its calls to the session.

    Args:
        session: that is driven.
        address: where the panel is served.
        complain: called with a line of text when the panel has to be started again.
    """

    def __init__(
        self, session: LiveSession, address: Address, complain: Callable[[str], None]
    ) -> None:
        self._session = session
        self._address = address
        self._complain = complain
        self._closing = threading.Event()
        self._start()

    @property
    def address(self) -> str:
        """Returns what to open in a browser."""
        return f"http://{self._address.host}:{self._address.port}/?tracked_camera=on"

    def run(self) -> None:
        """Serves until `close`, or until it is interrupted."""
        try:
            while problem := self._serve():
                self._kill()
                # The next panel's operator counts from 1, and has to arm.
                self._session.release()
                self._complain(f"the panel {problem}; the robot stops, it starts again")
                self._closing.wait(_RESTART_DELAY)
                self._start()
        finally:
            self._kill()

    def close(self) -> None:
        """Has `run` return."""
        self._closing.set()

    def _start(self) -> None:
        ours, theirs = Pipe()
        with theirs:
            number = theirs.fileno()
            # -P: the installed package, whatever the working folder is.
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", _MODULE, str(number)],
                pass_fds=[number],
                # Drake prints warnings about frames that it cannot read.
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C ends the session, which ends it.
            )
        self._pipe = ours
        session = self._session
        with suppress(OSError):  # It has ended already.
            self._pipe.send(
                (session.scenario, session.signals, session.choices, self._address)
            )
            self._pipe.poll(_START_TIMEOUT)

    def _serve(self) -> str:
        """Answers the panel; returns its problem when it stops, or "" to end."""
        try:
            while self._pipe.poll(_SILENCE_TIMEOUT):
                if self._closing.is_set():
                    return ""
                message = json.loads(self._pipe.recv_bytes())
                latency = max(0.0, time.monotonic() - message["at"])
                for name, *arguments in message["calls"]:
                    self._call(name, arguments, latency)
                self._pipe.send(self._session.snapshot())
        except (EOFError, OSError):
            return "has ended"
        return "does not respond"

    def _call(self, name: str, arguments: list[Any], latency: float) -> None:
        match name:
            case "send":
                self._session.send(OperatorInput(*arguments), latency)
            case "stop" | "choose" | "reset":
                getattr(self._session, name)(*arguments)
            case other:
                raise AssertionError(f"nothing is done for {other!r}")

    def _kill(self) -> None:
        self._pipe.close()
        self._process.kill()
        self._process.wait()
