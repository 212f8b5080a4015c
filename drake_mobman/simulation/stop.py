"""Asked to end: by Ctrl-C, by `kill`, or by a terminal that closes.

A signal only notes that the user wants to end. Whoever works looks at that where he can
end without a loss; so nothing is cut off in the middle of a file, at any moment.
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
"""Signals that ask to end."""

_T = TypeVar("_T")


class Stop:
    """Whether the user has asked to end; while entered, signals say so.

    One that the process was told to ignore, as by `nohup`, is ignored.
    """

    def __init__(self) -> None:
        self.received: list[int] = []
        self._raises_at: int | None = None
        self._before: dict[int, Any] = {}

    def __call__(self) -> bool:
        """Returns whether it was asked."""
        return bool(self.received)

    @property
    def status(self) -> int:
        """Returns the exit status by which a shell knows the first signal, or 0."""
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
        """Returns what `work` returns, unless there have been so many signals by then.

        It may be ended anywhere: it writes nothing.

        Raises:
            KeyboardInterrupt: if there have.
        """
        if len(self.received) >= signals:
            raise KeyboardInterrupt
        try:
            self._raises_at = signals
            return work()
        finally:
            # Python looks for signals at calls: there is none between work and this.
            self._raises_at = None

    def _take(self, number: int, _frame: FrameType | None) -> None:
        self.received.append(number)
        if self._raises_at is not None and len(self.received) >= self._raises_at:
            raise KeyboardInterrupt
