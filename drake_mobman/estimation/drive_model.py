"""What a base makes of the commands sent to it: a delay, then a lag of first order."""

import math
from typing import Any, NamedTuple

from drake_mobman.scalars import Scalar, Vector


class DriveModel(NamedTuple):
    """The model of a drive at its ticks, scalar by scalar.

    Its state is, two numbers each: the commands of the last `delay` periods, the oldest
    first; and the velocities at this tick and at the `memory` ticks before it, the
    newest first.
    """

    delay: int  # [periods].
    pole: float  # Of the lag: what is left of a step after a period; 0 for no lag.
    memory: int = 0  # [periods].

    @classmethod
    def of(
        cls, delay: float, bandwidth: float, period: float, memory: float = 0.0
    ) -> "DriveModel":
        """Returns the model.

        Args:
            delay: whole control periods [s].
            bandwidth: of the lag [Hz]; 0: none.
            period: control period [s].
            memory: whole control periods [s].
        """
        pole = math.exp(-2 * math.pi * bandwidth * period) if bandwidth else 0.0
        return cls(round(delay / period), pole, round(memory / period))

    @property
    def size(self) -> int:
        """Returns the size of its state."""
        return 2 * (self.delay + self.memory + 1)

    def mean(self, state: Vector, sent: Vector) -> list[Scalar]:
        """Returns the mean v [m/s] and omega [rad/s] (2,) over the period to come.

        Args:
            state: of the model.
            sent: `base_command_smoothed` (2,).
        """
        told = self._told(state, sent)
        if not self.pole:
            return told
        share = (1 - self.pole) / -math.log(self.pole)
        now = self._velocities(state)[:2]
        return [t + share * (v - t) for t, v in zip(told, now, strict=True)]

    def before(self, state: Vector) -> Any:
        """Returns v [m/s] and omega [rad/s] (2,) of `memory` periods ago."""
        return self._velocities(state)[-2:]

    def next(self, state: Vector, sent: Vector) -> list[Scalar]:
        """Returns the state after a period.

        Args:
            state: of the model.
            sent: `base_command_smoothed` (2,).
        """
        told, velocities = self._told(state, sent), self._velocities(state)
        newest = [
            t + self.pole * (v - t) for t, v in zip(told, velocities[:2], strict=True)
        ]
        commands = [*state[: 2 * self.delay], *sent][2:] if self.delay else []
        return [*commands, *newest, *velocities[:-2]]

    def _told(self, state: Vector, sent: Vector) -> list[Scalar]:
        """Returns what the motors are told for the period to come (2,)."""
        return list(state[:2] if self.delay else sent)

    def _velocities(self, state: Vector) -> list[Scalar]:
        return list(state[2 * self.delay :])
