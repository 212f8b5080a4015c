"""What all estimates by sensors have in common."""

import dataclasses as dc

from drake_mobman.estimation.drive_model import DriveModel
from drake_mobman.estimation.sent import Sent
from drake_mobman.parameters import SPEED, YAW_RATE, Range, check_whole, within


@dc.dataclass
class Measuring(Sent):
    """A drive that may be known, and how far the base may be from what it is sent."""

    latency: float = 0.0  # Of the sensors, whole control periods [s].
    # A base that is further from its command than this, for longer than `patience`, is
    # astray: the robot is stopped.
    apart: float = 0.15  # [m/s].
    turning_apart: float = 0.4  # [rad/s].
    patience: float = 0.5  # [s].

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        super().check()
        within(self, Range(0.0, 2.0, "s"), "latency")
        within(self, Range(1e-4, SPEED.high, "m/s"), "apart")
        within(self, Range(1e-4, YAW_RATE.high, "rad/s"), "turning_apart")
        within(self, Range(0.0, 60.0, "s"), "patience")

    def check_period(self, period: float) -> None:
        """Raises `ParameterError` unless its times are whole control periods [s]."""
        super().check_period(period)
        check_whole(self, "latency", period, "control periods")

    def model(self, period: float) -> DriveModel:
        """Returns the drive as it is known, with its past."""
        return DriveModel.of(self.delay, self.bandwidth, period, self.latency)
