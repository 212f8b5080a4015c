"""How smoothly the base was driven."""

from typing import Any, ClassVar

import numpy as np

from drake_mobman import signals
from drake_mobman.analysis.metrics.metric import Metric
from drake_mobman.analysis.metrics.tally import Tally
from drake_mobman.analysis.metrics.window import Window


class BaseJerk(Metric):
    """Second difference of the smoothed forward command over the period squared."""

    group = "base"
    units: ClassVar = {"base_jerk_rms": "m/s^3"}

    def __init__(self) -> None:
        self._jerk = Tally()

    def take(self, window: Window) -> None:
        """Takes the next window into account; it repeats the two samples it needs."""
        speed = window[signals.BASE_COMMAND_SMOOTHED][:, 0]
        self._jerk.take(np.diff(speed, 2) / window.period**2)

    def numbers(self) -> dict[str, Any]:
        """Returns the root mean square [m/s^3]."""
        return {"base_jerk_rms": self._jerk.rms}
