"""How fast the base was commanded to move."""

from typing import ClassVar

import numpy as np

from drake_mobman import signals
from drake_mobman.analysis.metrics.largest import Largest
from drake_mobman.analysis.metrics.window import Window


class BaseSpeed(Largest):
    """Speed and yaw rate of the smoothed base command."""

    group = "base"
    units: ClassVar = {"base_speed_max": "m/s", "base_yaw_rate_max": "rad/s"}

    def values(self, window: Window) -> dict[str, np.ndarray]:
        """Returns v_b (N,) [m/s] and omega_b (N,) [rad/s]."""
        speed, yaw_rate = window[signals.BASE_COMMAND_SMOOTHED].T
        return {"base_speed_max": speed, "base_yaw_rate_max": yaw_rate}
