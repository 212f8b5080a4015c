"""What every estimate of the base's motion has, so that one can replace another."""

from typing import Any, ClassVar, Protocol

from drake_mobman.estimation.drive_model import DriveModel
from drake_mobman.scalars import Scalar, Vector


class EstimateParams(Protocol):
    """Parameters of a block that tells how the base is about to move."""

    measures: ClassVar[dict[str, int]]  # Signals that it needs, and their sizes.

    def measured(self, *values: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Returns v, v_y [m/s] and omega [rad/s] by the values of these signals."""

    def model(self, period: float) -> DriveModel:
        """Returns the drive as it is known, for a control period [s]."""

    def check_period(self, period: float) -> None:
        """Raises `ParameterError` unless its times are whole control periods [s]."""

    def build(self, period: float) -> Any:
        """Returns the block, for a control period [s].

        Raises:
            ParameterError: where a parameter is not valid.
        """
