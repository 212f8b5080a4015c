"""Pacing of a simulation: its control ticks keep to the wall clock."""

import collections
import time

_MAX_LAG = 0.1
"""How far the simulation may fall behind and still catch up [s]. A longer lag is left
out: commands are never executed faster than they were given."""


class RealTimePacer:
    """Keeps control ticks to the wall clock, and measures how well that works.

    Args:
        period: control period [s].
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._ticks = 0
        self._start = self._anchor = time.monotonic()
        self._last_second = collections.deque([(self._start, 0.0)])  # Wall, simulated.

    def next_time(self) -> float:
        """Returns the simulated time of the next tick [s]."""
        self._ticks += 1
        return self._ticks * self._period

    def wait(self) -> None:
        """Waits until the next tick is due."""
        due = self._anchor + self._ticks * self._period
        ahead = due - time.monotonic()
        if ahead > 0:
            time.sleep(ahead)
        late = time.monotonic() - due
        if late > _MAX_LAG:
            self._anchor += late

    def wall_time(self) -> float:
        """Returns the wall time since the start [s]."""
        return time.monotonic() - self._start

    def factor(self, simulated: float) -> float:
        """Returns simulated over wall time of the last second; to be called often.

        Args:
            simulated: simulated time now [s].
        """
        now = time.monotonic()
        self._last_second.append((now, simulated))
        while self._last_second[1][0] < now - 1.0:
            self._last_second.popleft()
        then, simulated_then = self._last_second[0]
        return (simulated - simulated_then) / (now - then)
