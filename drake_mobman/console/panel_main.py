"""The process of Meshcat's panel: `PanelProcess` starts it, and serves its session."""

import json
import os
import sys
import time
from multiprocessing.connection import Connection
from typing import Any, NoReturn

from pydrake.common import use_native_cpp_logging

from drake_mobman.console.mailbox import OperatorInput
from drake_mobman.console.meshcat_panel import MeshcatPanel
from drake_mobman.console.snapshot import Snapshot
from drake_mobman.console.view import FRAME_PERIOD
from drake_mobman.meshcat import local_meshcat
from drake_mobman.scenario import AnyScenario


class RemoteSession:
    """A session in another process, as far as a panel uses it.

    Args:
        scenario: of the session.
        signals: of the session.
        choices: of the session.
        pipe: to the session.
    """

    def __init__(
        self,
        scenario: AnyScenario,
        signals: frozenset[str],
        choices: list[str],
        pipe: Connection,
    ) -> None:
        self.scenario = scenario
        self.signals = signals
        self.choices = choices
        self._pipe = pipe
        self._calls: list[tuple[Any, ...]] = []

    def send(self, operator_input: OperatorInput) -> None:
        """Passes on the operator's input, without a drag."""
        sent = operator_input
        self._calls.append(
            ("send", sent.sequence, sent.v_c, sent.omega_c, sent.v_z, sent.dead_man)
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
        """Makes all calls since the last one, and returns the session as it is."""
        # All processes of a machine have the same monotonic clock.
        message = {"at": time.monotonic(), "calls": self._calls}
        self._calls = []
        self._pipe.send_bytes(json.dumps(message).encode())
        snapshot: Snapshot = self._pipe.recv()
        return snapshot


def main(pipe: Connection) -> NoReturn:
    """Serves a panel until Meshcat or the session has ended."""
    try:
        scenario, signals, choices, address = pipe.recv()
        use_native_cpp_logging()
        session = RemoteSession(scenario, signals, choices, pipe)
        panel = MeshcatPanel(session, local_meshcat(*address))
        while True:
            panel.step()
            time.sleep(FRAME_PERIOD)
    finally:
        # At once: Meshcat waits for a thread that may be at work, or has ended.
        os._exit(0)


if __name__ == "__main__":
    main(Connection(int(sys.argv[1])))
