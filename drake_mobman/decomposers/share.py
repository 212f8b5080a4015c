"""What all decomposers hold in common: the workspace, and the base from its share.

Kwon et al., eqs. 10-11 and fig. 4.
"""

import dataclasses as dc
import math

from pydrake.math import atan2, cos, exp, sin

from drake_mobman.parameters import REACH, Range, in_order, within
from drake_mobman.scalars import Scalar


@dc.dataclass
class WorkspaceLimits:
    """Where the arm is to work: a ring sector about the shoulder (Kwon, table 1)."""

    l_min: float = 0.4  # Smallest reach L_min [m].
    l_max: float = 1.6  # Largest reach L_max [m].
    psi_min: float = -0.7  # Smallest angle Psi_min [rad].
    psi_max: float = 0.7  # Largest angle Psi_max [rad].

    def check(self) -> None:
        """Raises `ParameterError` unless both ranges are in order and make sense."""
        within(self, REACH, "l_min", "l_max")
        within(self, Range(-10.0, 10.0, "rad"), "psi_min", "psi_max")
        in_order(self, "l_min", "l_max")
        in_order(self, "psi_min", "psi_max")


@dc.dataclass
class Projection:
    """How the base's speed follows from its projection on the reach (eqs. 10, 11)."""

    sigma: float = 0.5  # Width of the stop at |psi| = pi/2 [rad]; |v_b| < 1.352 |v_bm|.

    def check(self) -> None:
        """Raises `ParameterError` unless `sigma` is in range."""
        within(self, Range(1e-3, 10.0, "rad"), "sigma")


def radial_weight(psi: Scalar, sigma: float) -> Scalar:
    """Returns kappa of eq. 11: 1 ahead of the base, 0 at psi = +-pi/2 [rad].

    Joints may tell a psi past half a turn; the angle counts as a direction.
    """
    beside = abs(atan2(sin(psi), cos(psi))) - math.pi / 2
    return 1.0 - exp(-(beside * beside) / (sigma * sigma))


def base_speed(v_bm: Scalar, psi: Scalar, projection: Projection) -> Scalar:
    """Returns the base's speed v_b [m/s] whose projection on the reach is `v_bm`.

    Eq. 10. It is short of the full projection by kappa, and so stays finite where the
    arm stands square to the base and no speed of the base would do.
    """
    return radial_weight(psi, projection.sigma) * v_bm / cos(psi)
