"""How near a joint came to the end of its range."""

import math
from typing import Any, ClassVar

import numpy as np

from drake_mobman import signals
from drake_mobman.analysis.metrics.metric import Metric
from drake_mobman.analysis.metrics.window import Window


class JointMargin(Metric):
    """The least distance of a joint from its nearer limit; below 0, beyond it."""

    group = "arm"
    units: ClassVar = {"joint_margin_min": "rad"}

    def __init__(self) -> None:
        self._least = math.inf

    def take(self, window: Window) -> None:
        """Takes the next window into account."""
        limits, q = window.run.model.joint_limits, window[signals.ARM_POSITION]
        least = min(np.min(q - limits.lower), np.min(limits.upper - q))
        self._least = min(self._least, float(least))

    def numbers(self) -> dict[str, Any]:
        """Returns the least distance [rad]."""
        return {"joint_margin_min": self._least}
