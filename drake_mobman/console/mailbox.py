"""The edge: what the operator last said, and how old it is by the wall clock.

The age that the gate's watchdog looks at is measured here.
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
    """A message of the operator; sent many times a second, changed or not.

    Numbers may be anything: what is not finite or out of range is for the gate to stop.
    """

    sequence: int  # Counts up with each message of an operator.
    v_c: float = 0.0  # [m/s].
    omega_c: float = 0.0  # [rad/s].
    v_z: float = 0.0  # [m/s].
    dead_man: bool = False  # Whether it is held.
    dragged: Dragged = NOTHING  # Which point of the arm is dragged, and whereto.


class Mailbox:
    """Keeps the last word of the one operator; any thread may call.

    The latest message wins; there is no queue, so that nothing is ever executed late.
    One that comes out of order or late is dropped.

    Args:
        late: latest that a message may be [s].
        clock: the wall's [s].
    """

    def __init__(
        self, late: float = 0.25, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._late = late
        self._clock = clock
        self._lock = threading.Lock()
        self._choice = 0
        self._stop = False
        self.forget()
        self._gone = False  # Whether it is still to be told that nobody is there.

    def forget(self) -> None:
        """Forgets the operator, as when another takes over.

        The next sample tells of nobody, however soon another speaks.
        """
        with self._lock:
            self._gone = True
            self._said: OperatorInput | None = None
            self._stamp = -math.inf  # When it was said, by our clock.

    def tell(self, said: OperatorInput, lateness: float = 0.0) -> bool:
        """Takes a message; returns whether it counts, or was dropped.

        Args:
            said: by the operator.
            lateness: how long ago that may have been, at most [s]; see `Lateness`.
        """
        with self._lock:
            in_order = self._said is None or said.sequence > self._said.sequence
            if not (in_order and lateness <= self._late):
                return False
            self._said, self._stamp = said, self._clock() - lateness
            return True

    def stop(self) -> None:
        """Asks for a stop; the next sample tells of it."""
        with self._lock:
            self._stop = True

    def choose(self, choice: int) -> None:
        """Asks for the decomposer, or field, of this index."""
        with self._lock:
            self._choice = choice

    def sample(self) -> OperatorSample:
        """Returns what the operator says now; a stop is told once."""
        with self._lock:
            stop, self._stop = float(self._stop), False
            gone, self._gone = self._gone, False
            said, choice = self._said, float(self._choice)
            if said is None or gone:
                return NOBODY._replace(stop=stop, choice=choice)
            return OperatorSample(
                v_c=said.v_c,
                omega_c=said.omega_c,
                v_z=said.v_z,
                dead_man=float(said.dead_man),
                age=max(0.0, self._clock() - self._stamp),
                stop=stop,
                choice=choice,
                **said.dragged._asdict(),
            )
