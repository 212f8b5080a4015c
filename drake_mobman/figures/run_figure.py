"""What a figure of a run is."""

import dataclasses as dc
from collections.abc import Callable

from matplotlib.figure import Figure

from drake_mobman.simulation.run import Run


def always(_: Run) -> bool:
    """Returns true: for a figure that applies to every run."""
    return True


@dc.dataclass(frozen=True)
class RunFigure:
    """A kind of figure of a run."""

    name: str  # Of its file, `figures/name.png`.
    draw: Callable[[Run], Figure]  # As wide as a page's text.
    applies: Callable[[Run], bool] = always  # Whether a run has anything to show in it.


def logged(*signals: str) -> Callable[[Run], bool]:
    """Returns a function: whether the log of a run holds all of some signals."""
    return lambda run: all(name in run.log for name in signals)
