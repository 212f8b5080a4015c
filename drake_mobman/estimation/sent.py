"""The base moves as it is sent, through a drive that is known."""

import dataclasses as dc
from typing import Any, ClassVar

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import MatrixGain

from drake_mobman import signals
from drake_mobman.estimation.base_estimator import BaseEstimator
from drake_mobman.estimation.drive_model import DriveModel
from drake_mobman.parameters import Range, check_whole, within
from drake_mobman.scalars import Scalar, Vector

_TO_ESTIMATE = np.array([[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]])


@dc.dataclass
class Sent:
    """By what is sent, without a sensor."""

    delay: float = 0.0  # Of the drive, whole control periods [s].
    bandwidth: float = 0.0  # Of its lag of first order; 0: none [Hz].
    measures: ClassVar[dict[str, int]] = {}

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, Range(0.0, 2.0, "s"), "delay")
        within(self, Range(0.0, 1e3, "Hz"), "bandwidth")

    def check_period(self, period: float) -> None:
        """Raises `ParameterError` unless its times are whole control periods [s]."""
        check_whole(self, "delay", period, "control periods")

    def model(self, period: float) -> DriveModel:
        """Returns the drive as it is known."""
        return DriveModel.of(self.delay, self.bandwidth, period)

    def measured(self, *_: Vector) -> tuple[Scalar, Scalar, Scalar]:
        """Nothing is measured."""
        raise NotImplementedError

    def build(self, period: float) -> Any:
        """Returns the block for a control period [s].

        Raises:
            ParameterError: where a parameter is not valid.
        """
        if self.measures or self.delay or self.bandwidth:
            return BaseEstimator(self, period)
        return _as_sent()


def _as_sent() -> Diagram:
    """Returns a block that puts out what is sent, without Python.

    .. pydrake_system::

        name: as_sent
        input_ports:
        - base_command_smoothed
        output_ports:
        - base_estimate
    """
    builder = DiagramBuilder()
    gain = builder.AddSystem(MatrixGain(_TO_ESTIMATE))
    builder.ExportInput(gain.get_input_port(), signals.BASE_COMMAND_SMOOTHED)
    builder.ExportOutput(gain.get_output_port(), signals.BASE_ESTIMATE)
    diagram = builder.Build()
    diagram.set_name("as_sent")
    return diagram
