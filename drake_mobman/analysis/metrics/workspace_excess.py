"""How far the end effector went past the limits of the workspace."""

from typing import Any, ClassVar

import numpy as np

from drake_mobman.analysis.metrics.metric import COMMANDED, Metric
from drake_mobman.analysis.metrics.window import Window


class WorkspaceExcess(Metric):
    """How far the reach l and the angle psi went past their limits; 0 inside."""

    group = "end effector"
    units: ClassVar = {"workspace_excess_max.l": "m", "workspace_excess_max.psi": "rad"}
    needs = COMMANDED

    def __init__(self) -> None:
        self._l = self._psi = 0.0

    def take(self, window: Window) -> None:
        """Takes the next window into account."""
        motion, limits = window.motion, window.run.scenario.workspace
        self._l = max(self._l, excess(motion.reach, limits.l_min, limits.l_max))
        self._psi = max(self._psi, excess(motion.psi, limits.psi_min, limits.psi_max))

    def numbers(self) -> dict[str, Any]:
        """Returns the excess of l [m] and psi [rad]."""
        return {"workspace_excess_max": {"l": self._l, "psi": self._psi}}


def excess(x: np.ndarray, lower: float, upper: float) -> float:
    """Returns how far `x` (N,) goes beyond its limits; 0 where it does not."""
    return float(max(0.0, np.max(x) - upper, lower - np.min(x)))
