"""What a terminal is shown: text, and nothing that it would obey.

Names of files, paths that are asked for and reasons of errors come from elsewhere. A
terminal takes some characters in them for commands: it may be told to change what has
been printed before, its title, or the clipboard.
"""

import logging
import sys


def visible(text: str) -> str:
    r"""Returns text in one line, with each character that is not seen as an escape.

    So are control characters, those that change the direction of writing, and bytes
    that are no text: "\x1b[31m" for what would turn the terminal red.
    """
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode() for c in text
    )


class OneLine(logging.Formatter):
    """A log record in one line; of an exception, what it says."""

    def format(self, record: logging.LogRecord) -> str:
        """Returns the line."""
        line = f"mobman: {record.getMessage()}"
        if record.exc_info and (error := record.exc_info[1]):
            line += f": {type(error).__name__}: {error}"
        return visible(" ".join(line.split()))


def log_in_lines() -> None:
    """Has whatever libraries log from now on come to the terminal in single lines."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(OneLine())
    logging.basicConfig(handlers=[handler], level=logging.WARNING)
    for name in ("engineio.server", "socketio.server"):
        logging.getLogger(name).handlers.clear()  # They bring their own.
