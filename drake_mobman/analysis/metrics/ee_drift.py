"""How far the end effector drifts from the commanded path."""

from typing import Any, ClassVar

import numpy as np

from drake_mobman.analysis.metrics.metric import COMMANDED, Metric
from drake_mobman.analysis.metrics.tally import Tally
from drake_mobman.analysis.metrics.window import Window


class EndEffectorDrift(Metric):
    """Distance of the end effector from the integral of the commanded velocity."""

    group = "end effector"
    units: ClassVar = {"ee_drift_max": "m"}
    needs = COMMANDED

    def __init__(self) -> None:
        self._drift = Tally()
        self._last: np.ndarray | None = None  # End of the commanded path (2,) [m].

    def take(self, window: Window) -> None:
        """Takes the next window into account."""
        motion, repeated = window.motion, window.repeated
        path = motion.commanded_path(window.period)
        if self._last is not None:
            path += self._last - path[repeated - 1]
        self._last = path[-1]
        drift = np.linalg.norm(motion.position - path, axis=1)
        self._drift.take(drift[repeated:])

    def numbers(self) -> dict[str, Any]:
        """Returns the largest distance [m]."""
        return {"ee_drift_max": self._drift.largest}
