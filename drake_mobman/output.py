"""Output streams of a process: a full disk or a reader who has left ends no work."""

import io
import os
from typing import Any, TextIO


class Output(io.FileIO):
    """An output stream that is given up after the first write that fails.

    Whatever is written after that is dropped, also what Drake writes by itself.

    Attributes:
        error: why it was given up; empty if it was not.
    """

    error = ""

    def write(self, data: Any) -> int:
        """Writes data, or drops it."""
        try:
            return super().write(data)
        except OSError as error:
            self.error = error.strerror or str(error)
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.fileno())
            os.close(nowhere)
            return super().write(data)


def text_on(output: Output, like: TextIO) -> TextIO:
    """Returns a text stream on an output, to take the place of another.

    Characters that the other's encoding does not have are written as escapes.
    """
    return io.TextIOWrapper(
        io.BufferedWriter(output),
        encoding=like.encoding,
        errors="backslashreplace",
        line_buffering=bool(getattr(like, "line_buffering", True)),
    )


def write_error(stream: TextIO) -> str:
    """Returns why a stream's output was given up; empty if it was not."""
    raw = getattr(getattr(stream, "buffer", None), "raw", None)
    return raw.error if isinstance(raw, Output) else ""
