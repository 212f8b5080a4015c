"""The operator's last input, and its age by the wall clock.

It connects the threads of pages to the simulation's. The watchdog in the gate looks at
the age that is measured here.
"""

import dataclasses as dc
import math
import threading
import time
from collections.abc import Callable

from drake_mobman.teleop.drag import NOTHING, Dragged
from drake_mobman.teleop.live import NOBODY, OperatorSample


@dc.dataclass(frozen=True)
class OperatorInput:
    """An operator's input; sent many times a second, changed or not.

    Numbers may be anything: the gate stops those that are not finite or out of range.
    """

    sequence: int  # Counts up with each message of an operator.
    v_c: float = 0.0  # [m/s].
    omega_c: float = 0.0  # [rad/s].
    v_z: float = 0.0  # [m/s].
    dead_man: bool = False  # Whether it is held.
    dragged: Dragged = NOTHING  # Which point of the arm is dragged, and where to.


class Mailbox:
    """Keeps the latest input of the one operator; any thread may call.

    There is no queue, so no input is used late. An input that arrives out of order or
    too late is dropped.

    Args:
        max_latency: largest latency of an input [s].
        clock: monotonic wall clock [s].
    """

    def __init__(
        self, max_latency: float = 0.25, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._max_latency = max_latency
        self._clock = clock
        self._lock = threading.Lock()
        self._choice = 0
        self._stop = False
        self.clear()
        self._cleared = False  # Whether the next sample is still of nobody.

    def clear(self) -> None:
        """Forgets the operator, as when another takes over.

        The next sample is of nobody, even if another's input arrives before it.
        """
        with self._lock:
            self._cleared = True
            self._input: OperatorInput | None = None
            self._sent_at = -math.inf  # By our clock.

    def put(self, operator_input: OperatorInput, latency: float = 0.0) -> bool:
        """Takes an input; returns whether it counts, or was dropped.

        Args:
            operator_input: the operator's.
            latency: its largest possible latency [s]; see `LatencyBound`.
        """
        with self._lock:
            last = self._input
            in_order = last is None or operator_input.sequence > last.sequence
            if not (in_order and latency <= self._max_latency):
                return False
            self._input, self._sent_at = operator_input, self._clock() - latency
            return True

    def stop(self) -> None:
        """Requests a stop, which is in the next sample."""
        with self._lock:
            self._stop = True

    def choose(self, choice: int) -> None:
        """Requests the controller of this index."""
        with self._lock:
            self._choice = choice

    def sample(self) -> OperatorSample:
        """Returns the operator's input now; a stop is in one sample only."""
        with self._lock:
            stop, self._stop = float(self._stop), False
            cleared, self._cleared = self._cleared, False
            last, choice = self._input, float(self._choice)
            if last is None or cleared:
                return NOBODY._replace(stop=stop, choice=choice)
            return OperatorSample(
                v_c=last.v_c,
                omega_c=last.omega_c,
                v_z=last.v_z,
                dead_man=float(last.dead_man),
                age=max(0.0, self._clock() - self._sent_at),
                stop=stop,
                choice=choice,
                **last.dragged._asdict(),
            )
