"""What the command line prints: lines, paths one can click, and refusals."""

from contextlib import suppress
from pathlib import Path
from typing import NoReturn

import typer
from rich.console import Console
from rich.text import Text

from drake_mobman.exit_status import BAD_INPUT
from drake_mobman.terminal import visible

# A name is no markup: `[bold].yaml` is a file like any other.
console = Console(emoji=False, markup=False)
errors = Console(stderr=True, soft_wrap=True, emoji=False, markup=False)


def complain(message: object) -> None:
    """Prints one line to the standard error."""
    line = f"mobman: {' '.join(str(message).split())}"
    with suppress(OSError):  # Of a terminal that has gone.
        errors.print(visible(line), highlight=False)


def say(line: str) -> None:
    """Prints one line to the standard output, as it is."""
    console.print(visible(line), soft_wrap=True, highlight=False)


def say_path(before: str, path: Path) -> None:
    """Prints a line that ends in a path: a link, in a terminal that knows links.

    Everywhere else it is the plain path.
    """
    shown = Text(visible(str(path)))
    with suppress(OSError):  # Of a working folder that is gone.
        # The address holds no character that a terminal obeys: `as_uri` escapes them.
        shown.stylize(f"link {path.absolute().as_uri()}")
    console.print(Text.assemble(before, " ", shown), soft_wrap=True, highlight=False)


def refuse(message: object) -> NoReturn:
    """Ends the command over bad input, with one line and exit status 2."""
    complain(message)
    raise typer.Exit(BAD_INPUT)
