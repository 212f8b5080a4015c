"""How long a control tick took."""

from typing import Any, ClassVar

import numpy as np

from drake_mobman.analysis.metrics.metric import Metric
from drake_mobman.analysis.metrics.window import Window

NAME = "step_time_us"


class StepTime(Metric):
    """Time of a control tick, where ticks were timed (`Run.tick_times`)."""

    group = "time"
    units: ClassVar = {
        f"{NAME}.{part}": "µs" for part in ("mean", "median", "p99", "max")
    }

    def __init__(self) -> None:
        self._times = np.zeros(0)

    def take(self, window: Window) -> None:
        """Takes the run's tick times, which come with each of its windows."""
        self._times = window.run.tick_times * 1e6

    def numbers(self) -> dict[str, Any]:
        """Returns mean, median, 99th percentile and largest time [us], or None."""
        times = self._times
        if not times.size:
            return {NAME: None}
        spread = {
            "mean": float(np.mean(times)),
            "median": float(np.median(times)),
            "p99": float(np.percentile(times, 99)),
            "max": float(np.max(times)),
        }
        return {NAME: spread}
