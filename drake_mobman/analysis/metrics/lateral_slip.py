"""How fast the base slid sideways."""

from typing import ClassVar

import numpy as np

from drake_mobman import signals
from drake_mobman.analysis.metrics.largest import Largest
from drake_mobman.analysis.metrics.window import Window


class LateralSlip(Largest):
    """Sideways velocity of the base, which rolling wheels do not allow."""

    group = "base"
    units: ClassVar = {"lateral_slip_max": "m/s"}

    def values(self, window: Window) -> dict[str, np.ndarray]:
        """Returns the sideways velocity (N,) [m/s]."""
        return {"lateral_slip_max": window[signals.BASE_VELOCITY][:, 1]}
