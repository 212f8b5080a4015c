"""The base's speed from its projection on the reach (Kwon et al., eqs. 10-11)."""

import dataclasses as dc
import math

from pydrake.math import atan2, cos, exp, sin

from drake_mobman.parameters import Range, within
from drake_mobman.scalars import Scalar


@dc.dataclass
class Projection:
    """How the base's speed follows from its projection on the reach (eqs. 10, 11)."""

    sigma: float = 0.5  # Width of the stop at |psi| = pi/2 [rad]; |v_b| < 1.352 |v_bm|.

    def check(self) -> None:
        """Raises `ParameterError` unless `sigma` is in range."""
        within(self, Range(1e-3, 10.0, "rad"), "sigma")


def radial_weight(psi: Scalar, sigma: float) -> Scalar:
    """Returns kappa of eq. 11: 1 ahead of the base, 0 at psi = +-pi/2 [rad].

    Only the direction of psi counts: joints may turn past half a turn.
    """
    beside = abs(atan2(sin(psi), cos(psi))) - math.pi / 2
    return 1.0 - exp(-(beside * beside) / (sigma * sigma))


def base_speed(v_bm: Scalar, psi: Scalar, projection: Projection) -> Scalar:
    """Returns the base's speed v_b [m/s] whose projection on the reach is `v_bm`.

    Eq. 10. The factor kappa keeps it finite where the arm is at a right angle to the
    base, and no speed of the base has this projection.
    """
    return radial_weight(psi, projection.sigma) * v_bm / cos(psi)
