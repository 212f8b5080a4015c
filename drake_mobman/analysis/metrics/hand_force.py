"""How hard the guiding hand pulled."""

from typing import ClassVar

import numpy as np

from drake_mobman import signals
from drake_mobman.analysis.metrics.largest import Largest
from drake_mobman.analysis.metrics.window import Window


class HandForce(Largest):
    """Norm of the guiding hand's force."""

    group = "hand"
    units: ClassVar = {"hand_force_max": "N"}
    needs = (signals.HAND_FORCE,)

    def values(self, window: Window) -> dict[str, np.ndarray]:
        """Returns the force's norm (N,) [N]."""
        force = np.linalg.norm(window[signals.HAND_FORCE], axis=1)
        return {"hand_force_max": force}
