"""The largest value and the root mean square of numbers that come in parts."""

import math

import numpy as np


class Tally:
    """Takes arrays of numbers, and keeps only their largest value and their sums."""

    def __init__(self) -> None:
        self.largest: float | None = None  # Absolute value; None without any number.
        self._squares, self._count = 0.0, 0

    def take(self, x: np.ndarray) -> None:
        """Takes the numbers of an array of any shape."""
        if x.size:
            self.largest = max(self.largest or 0.0, float(np.max(np.abs(x))))
            self._squares += float(np.sum(x * x))
            self._count += x.size

    @property
    def rms(self) -> float | None:
        """Returns the root mean square; None without any number."""
        return math.sqrt(self._squares / self._count) if self._count else None
