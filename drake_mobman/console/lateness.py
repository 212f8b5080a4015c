"""How late a page's messages are, by a clock that is not the page's: a watchdog's edge.

A link may be slow from the first message on, and a page's clock may stand still while
its device sleeps; so neither the quickest message nor the page's clock can be trusted.
"""

import math
import time
from collections.abc import Callable

_DRIFT = 1e-3
"""How fast two clocks may go apart, at most [s/s]; quartz stays below 1e-4."""

_BACKWARDS = 5e-3
"""By how much a message may seem to come before it was sent [s]: browsers round."""


class Lateness:
    """Bounds how late the messages of one page are.

    We tell the page our time, again and again. What it hears, it hears later: so our
    clock is ahead of its own by no less than what it was told, less its own time then.
    By the best of these, what it says cannot be later than it seems.

    Args:
        clock: the wall's [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._ahead = -math.inf  # By how much our clock is ahead, at least [s].
        self._heard = clock()

    def of(self, sent: float, ahead: float | None) -> float:
        """Returns how late a message may be, at most [s]; infinite if nobody can say.

        Args:
            sent: when, by the page's own monotonic clock [s].
            ahead: the time last told to the page, less its own when it heard that [s];
                None before it has heard any.
        """
        now = self._clock()
        self._ahead -= _DRIFT * (now - self._heard)
        self._heard = now
        if ahead is not None:
            self._ahead = max(self._ahead, ahead)
        late = now - sent - self._ahead
        if not late >= -_BACKWARDS:  # Its clock has been set: what we know is void.
            self._ahead = -math.inf
            return math.inf
        return max(late, 0.0)
