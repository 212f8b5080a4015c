"""How far the end effector's velocity is from the commanded one."""

from typing import Any, ClassVar

import numpy as np

from drake_mobman.analysis.metrics.metric import COMMANDED, Metric
from drake_mobman.analysis.metrics.tally import Tally
from drake_mobman.analysis.metrics.window import Window


class EndEffectorError(Metric):
    """Norm of the end effector's velocity less the commanded one, in the plane."""

    group = "end effector"
    units: ClassVar = {"ee_error_rms": "m/s", "ee_error_max": "m/s"}
    needs = COMMANDED

    def __init__(self) -> None:
        self._error = Tally()

    def take(self, window: Window) -> None:
        """Takes the next window into account."""
        fresh = window.motion.error[window.repeated :]
        self._error.take(np.linalg.norm(fresh, axis=1))

    def numbers(self) -> dict[str, Any]:
        """Returns root mean square and largest value [m/s]."""
        return {"ee_error_rms": self._error.rms, "ee_error_max": self._error.largest}
