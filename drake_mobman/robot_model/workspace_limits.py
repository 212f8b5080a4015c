"""Limits of the arm's workspace: a ring sector about the shoulder (Kwon, table 1)."""

import dataclasses as dc

from drake_mobman.parameters import REACH, Range, in_order, within


@dc.dataclass
class WorkspaceLimits:
    """Limits of l and psi of the end effector (`ee_cylindrical`)."""

    l_min: float = 0.4  # Smallest reach L_min [m].
    l_max: float = 1.6  # Largest reach L_max [m].
    psi_min: float = -0.7  # Smallest angle Psi_min [rad].
    psi_max: float = 0.7  # Largest angle Psi_max [rad].

    def check(self) -> None:
        """Raises `ParameterError` unless both ranges are valid."""
        within(self, REACH, "l_min", "l_max")
        within(self, Range(-10.0, 10.0, "rad"), "psi_min", "psi_max")
        in_order(self, "l_min", "l_max")
        in_order(self, "psi_min", "psi_max")
