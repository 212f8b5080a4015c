"""A part of a run's log, short enough for memory."""

import dataclasses as dc
import functools
from collections.abc import Iterator

import numpy as np

from drake_mobman.analysis.motion import EndEffectorMotion, ee_motion
from drake_mobman.simulation.log import Log, windows
from drake_mobman.simulation.run import Run

_REPEATED = 2
"""Samples of the window before that a window repeats: jerk needs three in a row."""


@dc.dataclass(frozen=True)
class Window:
    """A part of a run's log; `window["ee_command"]` is a signal (N, size)."""

    run: Run
    log: Log  # Of this window.
    repeated: int  # How many samples at its start were in the window before.

    def __getitem__(self, signal: str) -> np.ndarray:
        """Returns a signal over the window (N, size)."""
        return self.log[signal]

    def fresh(self, signal: str) -> np.ndarray:
        """Returns a signal without the samples repeated from the window before."""
        return self.log[signal][self.repeated :]

    @property
    def period(self) -> float:
        """Returns the control period [s]."""
        return self.run.scenario.period

    @functools.cached_property
    def motion(self) -> EndEffectorMotion:
        """Returns the end effector's motion, computed once for all metrics."""
        return ee_motion(self.part)

    @property
    def part(self) -> Run:
        """Returns the run with this window as its log."""
        return self.run.with_log(self.log)


def run_windows(run: Run) -> Iterator[Window]:
    """Yields a run's log in windows."""
    for repeated, log in windows(run.log, _REPEATED):
        yield Window(run, log, repeated)
