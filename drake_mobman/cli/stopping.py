"""Commands that end gently when a signal asks them to."""

from collections.abc import Callable
from typing import TYPE_CHECKING, NoReturn

import typer

from drake_mobman.cli.messages import complain

if TYPE_CHECKING:
    from drake_mobman.simulation.stop import Stop


def until_stopped(work: "Callable[[Stop], int]") -> NoReturn:
    """Does the work of a command, and exits with its status or that of a signal.

    Args:
        work: looks at the stop whether the user wants to end; returns an exit status.
    """
    from drake_mobman.simulation.stop import Stop

    with Stop() as stop:
        status = work(stop)
        raise typer.Exit(stop.status or status)


def interrupted(stop: "Stop") -> int:
    """Prints that nothing has been done; returns the exit status."""
    complain("interrupted")
    return stop.status
