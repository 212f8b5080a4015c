"""How fast the arm's joints moved."""

from typing import ClassVar

import numpy as np

from drake_mobman import signals
from drake_mobman.analysis.metrics.largest import Largest
from drake_mobman.analysis.metrics.window import Window


class JointSpeed(Largest):
    """Speed of the fastest joint."""

    group = "arm"
    units: ClassVar = {"joint_speed_max": "rad/s"}

    def values(self, window: Window) -> dict[str, np.ndarray]:
        """Returns the joint rates (N, n) [rad/s]."""
        return {"joint_speed_max": window[signals.ARM_VELOCITY]}
