"""How near the arm came to a singular posture."""

import math
from typing import Any, ClassVar

import numpy as np

from drake_mobman.analysis.metrics.metric import Metric
from drake_mobman.analysis.metrics.window import Window
from drake_mobman.analysis.motion import manipulability


class Manipulability(Metric):
    """The least sqrt(det(J J^T)) of T; its unit depends on the arm's joints."""

    group = "arm"
    units: ClassVar = {"manipulability_min": ""}

    def __init__(self) -> None:
        self._least = math.inf

    def take(self, window: Window) -> None:
        """Takes the next window into account."""
        self._least = min(self._least, float(np.min(manipulability(window.part))))

    def numbers(self) -> dict[str, Any]:
        """Returns the least value."""
        return {"manipulability_min": self._least}
