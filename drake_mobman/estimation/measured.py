"""The base moves as a tracker outside sees it."""

import dataclasses as dc
from typing import ClassVar

from drake_mobman import signals
from drake_mobman.estimation.measuring import Measuring
from drake_mobman.scalars import Scalar, Vector


@dc.dataclass
class Measured(Measuring):
    """By its measured velocity, with the slip to the side."""

    measures: ClassVar[dict[str, int]] = {signals.BASE_MEASURED: 3}

    def measured(self, *values: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns v, v_y [m/s] and omega [rad/s] by `base_measured` (3,)."""
        ((v, v_y, omega),) = values
        return v, v_y, omega
