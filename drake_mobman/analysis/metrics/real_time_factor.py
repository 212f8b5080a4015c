"""How much faster than real time a run was."""

from typing import Any, ClassVar

from drake_mobman.analysis.metrics.metric import Metric
from drake_mobman.analysis.metrics.window import Window


class RealTimeFactor(Metric):
    """Simulated time over the time that the simulation took."""

    group = "time"
    units: ClassVar = {"real_time_factor": ""}

    def __init__(self) -> None:
        self._factor = 0.0

    def take(self, window: Window) -> None:
        """Takes the next window into account; the last one counts."""
        self._factor = float(window["time"][-1] / window.run.wall_time)

    def numbers(self) -> dict[str, Any]:
        """Returns the factor."""
        return {"real_time_factor": self._factor}
