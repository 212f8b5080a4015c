"""A token bucket: limits a rate, and allows short bursts."""

import time
from collections.abc import Callable


class TokenBucket:
    """Fills with tokens at a constant rate; each event takes some out.

    Args:
        rate: tokens added each second.
        capacity: most tokens that it holds: the largest burst.
        clock: monotonic wall clock [s].
    """

    def __init__(
        self,
        rate: float,
        capacity: float,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._rate = rate
        self._capacity = capacity
        self._clock = clock
        self._tokens = capacity
        self._last = clock()

    def take(self, amount: float = 1.0) -> bool:
        """Takes tokens if there are enough, else none; returns whether it did."""
        now = self._clock()
        filled = self._tokens + self._rate * (now - self._last)
        self._tokens = min(self._capacity, filled)
        self._last = now
        if amount > self._tokens:
            return False
        self._tokens -= amount
        return True
