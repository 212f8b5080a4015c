"""A random operator: commands drawn by a seed, each held for a while."""

import dataclasses as dc
from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from drake_mobman.parameters import SPEED, TIME, YAW_RATE, Range, in_order, within
from drake_mobman.teleop.scripted import Held, Script, ScriptedSource

_HOLD = Range(0.01, 1e3, "s")

_LEAST = 1e-6
"""What is left of the time without another command [s]."""


@dc.dataclass
class RandomHeld:
    """Commands that are drawn, each held for a while; the same seed draws the same."""

    fed: ClassVar[bool] = False
    finite: ClassVar[bool] = True

    seed: int = 0  # Of the random numbers.
    length: float = 60.0  # Of all commands together; then rest [s].
    hold_min: float = 0.5  # Shortest that one is held [s].
    hold_max: float = 4.0  # Longest [s].
    max_v_c: float = 0.4  # Largest |v_c| [m/s].
    max_omega_c: float = 0.4  # Largest |omega_c| [rad/s].
    max_v_z: float = 0.0  # Largest |v_z| [m/s].
    rest: float = 0.2  # Share of commands that are zero, as of a stick let go.

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, Range(0, 999_999_999), "seed")
        within(self, TIME, "length")
        within(self, _HOLD, "hold_min", "hold_max")
        in_order(self, "hold_min", "hold_max")
        within(self, Range(0.0, SPEED.high, "m/s"), "max_v_c", "max_v_z")
        within(self, Range(0.0, YAW_RATE.high, "rad/s"), "max_omega_c")
        within(self, Range(0.0, 1.0), "rest")

    def script(self) -> Script:
        """Returns the commands that are drawn."""
        return Script(list(self._segments()))

    def build(self, period: float) -> ScriptedSource:
        """Returns the block, for a control period [s]."""
        return ScriptedSource(self.script(), period)

    def _segments(self) -> Iterator[Held]:
        # Only uniform numbers of this generator: they are the same in all versions.
        random = np.random.Generator(np.random.PCG64(self.seed)).random
        largest = self.max_v_c, self.max_omega_c, self.max_v_z
        left = self.length
        while left > _LEAST:
            hold, rests, *shares = (float(random()) for _ in range(5))
            duration = self.hold_min + hold * (self.hold_max - self.hold_min)
            command = [
                0.0 if rests < self.rest else (2 * share - 1) * most
                for share, most in zip(shares, largest, strict=True)
            ]
            yield Held(min(duration, left), *command)
            left -= duration
