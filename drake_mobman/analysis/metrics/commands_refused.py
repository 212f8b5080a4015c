"""How many commands the guard stopped."""

from typing import Any, ClassVar

import numpy as np

from drake_mobman import signals
from drake_mobman.analysis.metrics.metric import COMMANDED, Metric
from drake_mobman.analysis.metrics.window import Window


class CommandsRefused(Metric):
    """In how many samples the guard stopped the command."""

    group = "end effector"
    units: ClassVar = {"commands_refused": ""}
    needs = (*COMMANDED, signals.GUARD_STATUS)

    def __init__(self) -> None:
        self._count = 0

    def take(self, window: Window) -> None:
        """Takes the next window into account."""
        self._count += int(np.count_nonzero(window.fresh(signals.GUARD_STATUS)))

    def numbers(self) -> dict[str, Any]:
        """Returns the count."""
        return {"commands_refused": self._count}
