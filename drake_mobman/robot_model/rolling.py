"""A robot on its own wheels: what rolls and what slides on the floor."""

import dataclasses as dc
from typing import Any

import numpy as np

from drake_mobman.parameters import LENGTH, OFFSET, ParameterError, within


@dc.dataclass(frozen=True)
class Caster:
    """A wheel that is not driven and turns wherever it is pushed."""

    x: float  # Where it stands on the floor, in B [m].
    y: float  # The same to the left [m].
    radius: float  # [m].

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, OFFSET, "x", "y")
        within(self, LENGTH, "radius")


@dc.dataclass(frozen=True)
class RollingBase:
    """A robot in a plant, its base free and its driven wheels turning.

    The controller knows radius and track; a fidelity may let the true ones differ.
    """

    instances: list[Any]  # Of the robot's models in the plant.
    left: tuple[Any, ...]  # Joints of the driven wheels on the left.
    right: tuple[Any, ...]  # The same on the right; each turns about an axis along y.
    wheel_radius: float  # [m].
    track: float  # Between left and right wheels, or what acts as that [m].
    casters: tuple[Caster, ...] = ()

    def wheel_rates(self) -> np.ndarray:
        """Returns the matrix (2, 2) from v, omega to the rates of left and right.

        Rates [rad/s] of wheels that roll ahead, at v [m/s] forward and omega [rad/s].
        """
        half = self.track / 2
        return np.array([[1.0, -half], [1.0, half]]) / self.wheel_radius

    def check(self) -> None:
        """Raises `ParameterError` unless it can roll and turn."""
        within(self, LENGTH, "wheel_radius", "track")
        for side in ("left", "right"):
            if not getattr(self, side):
                raise ParameterError(side, [], "must hold a driven wheel or more")


def no_wheels(robot: Any) -> ParameterError:
    """Returns the error of a robot that cannot roll."""
    name = type(robot).__name__
    valid = f"!{name} has no wheels; use !Servo or !Kinematic"
    return ParameterError("fidelity", "!Wheels", valid)
