"""How near the robot on its wheels came to tipping over."""

import math
from typing import Any, ClassVar

import numpy as np

from drake_mobman import signals
from drake_mobman.analysis.metrics.metric import Metric
from drake_mobman.analysis.metrics.window import Window
from drake_mobman.robot_model.tipping import SupportPolygon


class TipMargin(Metric):
    """The least distance of the zero-moment point from its polygon's edge.

    At 0 a wheel lifts that the robot needs to stand.
    """

    group = "base"
    units: ClassVar = {"tip_margin_min": "m"}
    needs = (signals.FLOOR_FORCE,)

    def __init__(self) -> None:
        self._least = math.inf
        self._polygon: SupportPolygon | None = None

    def take(self, window: Window) -> None:
        """Takes the next window into account."""
        if self._polygon is None:
            scenario: Any = window.run.scenario  # With a fidelity that has wheels.
            self._polygon = scenario.fidelity.support(scenario.robot)
        # The force is the mean of the period before: at the start there was none.
        x, y, up = window[signals.FLOOR_FORCE][window["time"] > 0].T
        inside = np.where(up > 0, self._polygon.inside(np.stack([x, y], 1)), 0.0)
        self._least = float(np.min(inside, initial=self._least))

    def numbers(self) -> dict[str, Any]:
        """Returns the least distance [m]."""
        return {"tip_margin_min": self._least}
