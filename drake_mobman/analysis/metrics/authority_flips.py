"""How often authority passed between arm and base."""

from typing import Any, ClassVar

import numpy as np

from drake_mobman import signals
from drake_mobman.analysis.metrics.metric import Metric
from drake_mobman.analysis.metrics.window import Window


class AuthorityFlips(Metric):
    """How often the base's share of a command, while not zero, crossed one half."""

    group = "end effector"
    units: ClassVar = {"authority_flips.linear": "", "authority_flips.angular": ""}
    needs = (signals.EE_COMMAND, signals.BASE_CONTRIBUTION)

    def __init__(self) -> None:
        self._flips = {"linear": _Flips(0), "angular": _Flips(1)}

    def take(self, window: Window) -> None:
        """Takes the next window into account."""
        command = window.fresh(signals.EE_COMMAND)
        contribution = window.fresh(signals.BASE_CONTRIBUTION)
        for flips in self._flips.values():
            flips.take(command, contribution)

    def numbers(self) -> dict[str, Any]:
        """Returns the counts for the linear and the angular command."""
        counts = {name: flips.count for name, flips in self._flips.items()}
        return {"authority_flips": counts}


class _Flips:
    """The flips of one component of the command."""

    def __init__(self, component: int) -> None:
        self.count = 0
        self._component = component
        self._last: list[bool] = []  # Whether the base had authority, once known.

    def take(self, command: np.ndarray, contribution: np.ndarray) -> None:
        """Takes the next samples of command and base contribution (N, size)."""
        part = command[:, self._component]
        base = contribution[:, self._component]
        given = part != 0
        with_base = [*self._last, *(base[given] / part[given] > 0.5)]
        self.count += int(np.count_nonzero(np.diff(with_base)))
        self._last = with_base[-1:]
