"""What a process writes to: a full disk, or a reader who has left, ends no work."""

import io
import os
from typing import Any, TextIO


class Output(io.FileIO):
    """A stream to the outside that is let go of at the first write it refuses.

    All after that goes nowhere, also of what is written past Python.

    Attributes:
        lost: why it was let go of; empty if it was not.
    """

    lost = ""

    def write(self, data: Any) -> int:
        """Writes data, to nowhere if need be."""
        try:
            return super().write(data)
        except OSError as error:
            self.lost = error.strerror or str(error)
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.fileno())
            os.close(nowhere)
            return super().write(data)


def text_on(output: Output, like: TextIO) -> TextIO:
    """Returns a stream of text that takes the place of another on an output.

    What the other's encoding has no sign for is written as an escape.
    """
    return io.TextIOWrapper(
        io.BufferedWriter(output),
        encoding=like.encoding,
        errors="backslashreplace",
        line_buffering=bool(getattr(like, "line_buffering", True)),
    )


def refused(stream: TextIO) -> str:
    """Returns why what a stream writes to was let go of; empty if it was not."""
    raw = getattr(getattr(stream, "buffer", None), "raw", None)
    return raw.lost if isinstance(raw, Output) else ""
