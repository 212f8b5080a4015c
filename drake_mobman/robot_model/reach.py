"""Shoulder and reach of the arm, for base controllers (Petric & Zlajpah, fig. 1)."""

import dataclasses as dc

from drake_mobman.parameters import LENGTH, OFFSET, REACH, Range, within


@dc.dataclass(frozen=True)
class Reach:
    """The arm's shoulder, and the largest distance of T from it.

    The paper's centre c = (0, 0, l_0) is on B's z axis. Here, c is the shoulder,
    wherever it is. phi is still the bearing of T from B, about which the base turns:
    with the bearing from c, the base would circle about a T between B and c.
    """

    l_0: float  # Height of the shoulder above the floor [m].
    r_f: float  # Largest distance of T from the shoulder, l_1 + l_2 [m].
    ahead: float = 0.0  # Of the shoulder from B's z axis, forward [m].
    aside: float = 0.0  # The same to the left [m].

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, OFFSET, "l_0", "ahead")
        within(self, Range(LENGTH.low, REACH.high, "m"), "r_f")
