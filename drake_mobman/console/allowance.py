"""An allowance: so much at once, and so much a second (a token bucket)."""

import time
from collections.abc import Callable


class Allowance:
    """Room that fills up with time, and is taken from.

    Args:
        rate: how much comes each second.
        most: how much there may be at once.
        clock: the wall's [s].
    """

    def __init__(
        self,
        rate: float,
        most: float,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._rate = rate
        self._most = most
        self._clock = clock
        self._room = most
        self._last = clock()

    def takes(self, amount: float = 1.0) -> bool:
        """Takes so much, and returns whether there was enough; else takes nothing."""
        now = self._clock()
        self._room = min(self._most, self._room + self._rate * (now - self._last))
        self._last = now
        if amount > self._room:
            return False
        self._room -= amount
        return True
