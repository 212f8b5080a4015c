"""The terminal that a command runs in: Ctrl-C while it starts, output that is refused.

Imports little, so that there is next to nothing before it to be interrupted.
"""

import io
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO

INTERRUPTED = 130
"""Exit status, as a shell reports Ctrl-C."""


@contextmanager
def leaving_at_once() -> Iterator[None]:
    """Has Ctrl-C end the process, while its body loads what there is to load.

    An import that is cut short comes out as whatever error it likes, and there is
    nothing yet that could be lost.
    """

    def leave(*_: object) -> None:
        os.write(2, b"mobman: interrupted\n")
        os._exit(INTERRUPTED)

    try:
        before = signal.signal(signal.SIGINT, leave)
    except ValueError:  # A thread of a larger program, which keeps its own.
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


class Output(io.FileIO):
    """A stream to the outside that is let go of at the first write it refuses.

    All after that goes nowhere: a full disk, or a reader who has left, is no reason to
    lose what is being worked on.

    Attributes:
        lost: why it was let go of; empty if it was not.
    """

    lost = ""

    def write(self, data: Any) -> int:
        """Writes all of it, to nowhere if need be."""
        try:
            return super().write(data)
        except OSError as error:
            self.lost = error.strerror or str(error)
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.fileno())
            os.close(nowhere)
            return super().write(data)


def replaced(stream: TextIO) -> tuple[TextIO, Output]:
    """Returns a stream that writes to the same place, and its `Output`.

    What the place's encoding has no sign for is written as an escape.
    """
    raw = Output(stream.fileno(), "w", closefd=False)
    text = io.TextIOWrapper(
        io.BufferedWriter(raw),
        encoding=stream.encoding,
        errors="backslashreplace",
        line_buffering=stream is sys.stderr or stream.isatty(),
    )
    return text, raw
