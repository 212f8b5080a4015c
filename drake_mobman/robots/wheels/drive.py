"""The wheels' drive: what it does otherwise than the controller believes."""

import dataclasses as dc
import math
from typing import Any

import numpy as np
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import DiscreteTimeDelay, LinearSystem

from drake_mobman.parameters import Range, check_whole, within

_RATIO = Range(0.5, 2.0)


@dc.dataclass
class Drive:
    """Motors and tyres. By default they do as they are told, up to their torque."""

    gain: float = 1e3  # Torque per error of a wheel's rate [N m s].
    delay: float = 0.0  # From the base's command to the motors, whole steps [s].
    bandwidth: float = 0.0  # Of the motors, a lag of first order; 0: none [Hz].
    # True radius of the wheels on each side over the one that the controller knows.
    left_radius: float = 1.0
    right_radius: float = 1.0  # The same on the right.
    track: float = 1.0  # The same of the track.

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, Range(0.1, 1e6, "N m s"), "gain")
        within(self, Range(0.0, 2.0, "s"), "delay")
        within(self, Range(0.0, 1e3, "Hz"), "bandwidth")
        within(self, _RATIO, "left_radius", "right_radius", "track")

    def check_step(self, step: float) -> None:
        """Raises `ParameterError` unless the delay is whole steps [s]."""
        check_whole(self, "delay", step, "steps")

    def ideal(self) -> "Drive":
        """Returns the drive without delay and lag, to stand still with."""
        return dc.replace(self, delay=0.0, bandwidth=0.0)


def delayed(
    builder: DiagramBuilder, port: OutputPort, delay: float, step: float
) -> OutputPort:
    """Returns a signal as it was `delay` [s] ago, whole steps; zero in the beginning.

    At a step all is read before any is renewed: a block of no step is one step late.
    """
    if not delay:
        return port
    block = builder.AddSystem(
        DiscreteTimeDelay(step, round(delay / step) - 1, port.size())
    )
    builder.Connect(port, block.get_input_port())
    return block.get_output_port()


def lagged(
    builder: DiagramBuilder, port: OutputPort, bandwidth: float, step: float
) -> OutputPort:
    """Returns a signal through a lag of first order, at its exact steps.

    Args:
        builder: to add to.
        port: the signal, constant in each step.
        bandwidth: of the lag [Hz]; 0: none.
        step: of the plant [s].
    """
    if not bandwidth:
        return port
    pole = math.exp(-2 * math.pi * bandwidth * step)
    eye: Any = np.eye(port.size())
    block = builder.AddSystem(
        LinearSystem(pole * eye, (1 - pole) * eye, eye, 0 * eye, step)
    )
    builder.Connect(port, block.get_input_port())
    return block.get_output_port()
