"""How far the arm reaches, as a base controller sees it (Petric & Zlajpah, fig. 1)."""

import dataclasses as dc

from drake_mobman.parameters import LENGTH, OFFSET, REACH, Range, within


@dc.dataclass(frozen=True)
class Reach:
    """The arm's shoulder, and how far T gets from it.

    The paper's centre c = (0, 0, l_0) stands on B's z axis. Where the shoulder stands
    off it, so does c; phi stays the bearing of T from B, about which the base turns.
    Taken from c, it would have the base circle round an end effector between the two.
    """

    l_0: float  # Height of the shoulder above the floor [m].
    r_f: float  # Largest distance of T from the shoulder, l_1 + l_2 [m].
    ahead: float = 0.0  # Of the shoulder from B's z axis, forward [m].
    aside: float = 0.0  # The same to the left [m].

    def check(self) -> None:
        """Raises `ParameterError` unless the arm reaches anywhere."""
        within(self, OFFSET, "l_0", "ahead")
        within(self, Range(LENGTH.low, REACH.high, "m"), "r_f")
