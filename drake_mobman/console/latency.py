"""How old a page's messages are, without trust in the page's clock.

The link may be slow from the first message on, and the page's clock may stop while its
device sleeps. So neither the fastest message nor the page's clock can be trusted.
"""

import math
import time
from collections.abc import Callable

_DRIFT = 1e-3
"""Fastest drift between two clocks [s/s]; quartz stays below 1e-4."""

_ROUNDING = 5e-3
"""How much earlier than its sending a message may seem to arrive [s]: browsers round
their times."""


class LatencyBound:
    """Bounds the latency of one page's messages from above.

    The server sends its time again and again. The page returns the clock offset that it
    sees: the time last received, less its own time at that moment. As sending takes
    time, the true offset is at least that; the largest one gives the tightest bound,

        latency = now - sent - true offset <= now - sent - largest offset.

    Args:
        clock: monotonic wall clock [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._offset = -math.inf  # Server's clock less the page's, at least [s].
        self._updated_at = clock()

    def of(self, sent: float, offset: float | None) -> float:
        """Returns the largest latency of a message [s]; infinite if it is not known.

        Args:
            sent: when the page sent it, by its own monotonic clock [s].
            offset: the clock offset that the page sees [s]; None before it has received
                any time.
        """
        now = self._clock()
        self._offset -= _DRIFT * (now - self._updated_at)
        self._updated_at = now
        if offset is not None:
            self._offset = max(self._offset, offset)
        latency = now - sent - self._offset
        if not latency >= -_ROUNDING:  # The page's clock was set: start again.
            self._offset = -math.inf
            return math.inf
        return max(latency, 0.0)
