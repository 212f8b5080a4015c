"""The base moves forward as its wheels roll, and turns as a gyroscope measures."""

import dataclasses as dc
from typing import ClassVar

from drake_mobman import signals
from drake_mobman.estimation.measuring import Measuring
from drake_mobman.scalars import Scalar, Vector


@dc.dataclass
class Gyro(Measuring):
    """By encoders and a gyroscope, which sees all turning."""

    measures: ClassVar[dict[str, int]] = {
        signals.BASE_ODOMETRY: 2,
        signals.BASE_GYRO: 1,
    }

    def measured(self, *values: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns v, v_y [m/s], omega [rad/s] by `base_odometry`, `base_gyro`."""
        (v, _), (omega,) = values
        return v, 0.0 * v, omega
