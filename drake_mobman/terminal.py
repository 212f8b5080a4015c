"""Text that is safe to print in a terminal.

File names, paths and error messages come from elsewhere, and a terminal takes some
characters for commands: to change what was printed before, its title, or the clipboard.
"""

import logging
import sys


def visible(text: str) -> str:
    r"""Returns text in one line, with invisible characters written as escapes.

    These are control characters, those that change the direction of writing, and bytes
    that are no text: "\x1b[31m" is printed where the terminal would turn red.
    """
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode() for c in text
    )


class OneLine(logging.Formatter):
    """A log record in one line; of an exception, its message."""

    def format(self, record: logging.LogRecord) -> str:
        """Returns the line."""
        line = f"mobman: {record.getMessage()}"
        if record.exc_info and (error := record.exc_info[1]):
            line += f": {type(error).__name__}: {error}"
        return visible(" ".join(line.split()))


def log_in_lines() -> None:
    """Makes libraries log to the terminal in single lines from now on."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(OneLine())
    logging.basicConfig(handlers=[handler], level=logging.WARNING)
    for name in ("engineio.server", "socketio.server"):
        logging.getLogger(name).handlers.clear()  # They have their own.
