"""Ending a run on request: by Ctrl-C, by `kill`, or by closing the terminal.

A signal only sets a flag. The work checks the flag where it can end without loss, so
that no file is cut off in the middle.
"""

import signal
import threading
from collections.abc import Callable
from types import FrameType
from typing import Any, Self, TypeVar

NUMBERS = tuple(
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP")
    if hasattr(signal, name)
)
"""Signals by which a user ends a process."""

_T = TypeVar("_T")


class Stop:
    """Whether the user wants to end; handles the signals in a `with` statement.

    A signal that the process ignores, as under `nohup`, stays ignored.
    """

    def __init__(self) -> None:
        self.received: list[int] = []
        self._raises_at: int | None = None
        self._before: dict[int, Any] = {}

    def __call__(self) -> bool:
        """Returns whether the user wants to end."""
        return bool(self.received)

    @property
    def status(self) -> int:
        """Returns the exit status for the first signal, as in shells, or 0."""
        return 128 + self.received[0] if self.received else 0

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            for number in NUMBERS:
                if signal.getsignal(number) is not signal.SIG_IGN:
                    self._before[number] = signal.signal(number, self._take)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def cut_short(self, signals: int, work: Callable[[], _T]) -> _T:
        """Returns what `work` returns, if it ends before a number of signals.

        `work` may be ended anywhere, so it must not write any file.

        Raises:
            KeyboardInterrupt: once there are that many signals.
        """
        if len(self.received) >= signals:
            raise KeyboardInterrupt
        try:
            self._raises_at = signals
            return work()
        finally:
            # Python handles signals at calls; there is none between `work` and this.
            self._raises_at = None

    def _take(self, number: int, _frame: FrameType | None) -> None:
        self.received.append(number)
        if self._raises_at is not None and len(self.received) >= self._raises_at:
            raise KeyboardInterrupt
