"""The base moves as its wheels roll."""

import dataclasses as dc
from typing import ClassVar

from drake_mobman import signals
from drake_mobman.estimation.measuring import Measuring
from drake_mobman.scalars import Scalar, Vector


@dc.dataclass
class Odometry(Measuring):
    """By encoders of the wheels, which see delay and lag, but no slip."""

    measures: ClassVar[dict[str, int]] = {signals.BASE_ODOMETRY: 2}

    def measured(self, *values: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns v, v_y [m/s] and omega [rad/s] by `base_odometry` (2,)."""
        ((v, omega),) = values
        return v, 0.0 * v, omega
