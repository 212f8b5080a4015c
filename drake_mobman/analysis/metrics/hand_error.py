"""How far the tool was from the hand that guides it."""

from typing import ClassVar

import numpy as np

from drake_mobman import signals
from drake_mobman.analysis.metrics.largest import Largest
from drake_mobman.analysis.metrics.window import Window
from drake_mobman.analysis.motion import holding


class HandError(Largest):
    """Distance between guiding hand and tool, while the hand holds the tool."""

    group = "hand"
    units: ClassVar = {"hand_error_max": "m"}
    needs = (signals.HAND_FORCE,)

    def values(self, window: Window) -> dict[str, np.ndarray]:
        """Returns the distance (N,) [m]."""
        gap = window.fresh(signals.HAND_POSITION) - window.fresh(signals.TOOL_POSITION)
        held = holding(window.part)[window.repeated :]
        return {"hand_error_max": np.linalg.norm(gap, axis=1)[held]}
