"""Metrics that are the largest absolute value of something over a run."""

import abc
from typing import Any

import numpy as np

from drake_mobman.analysis.metrics.metric import Metric
from drake_mobman.analysis.metrics.tally import Tally
from drake_mobman.analysis.metrics.window import Window


class Largest(Metric):
    """The largest absolute value of each of one or more quantities."""

    def __init__(self) -> None:
        self._tallies = {name: Tally() for name in self.units}

    @abc.abstractmethod
    def values(self, window: Window) -> dict[str, np.ndarray]:
        """Returns the quantities in a window, by the names in `units`."""

    def take(self, window: Window) -> None:
        """Takes the next window into account; repeated samples make no difference."""
        for name, x in self.values(window).items():
            self._tallies[name].take(x)

    def numbers(self) -> dict[str, Any]:
        """Returns the largest values by name; None where there was no sample."""
        return {name: tally.largest for name, tally in self._tallies.items()}
