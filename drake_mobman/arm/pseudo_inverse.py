"""The inverse of a Jacobian, damped where that is nearly singular.

After Nakamura & Hanafusa (1986).
"""

import dataclasses as dc

import numpy as np
from pydrake.math import inv

from drake_mobman.parameters import GAIN, LENGTH, YAW_RATE, Range, within
from drake_mobman.scalars import Matrix, Scalar, larger

_TINY = 1e-14
"""Square of a singular value [m^2], added so that an inverse stays finite."""


@dc.dataclass
class Damping:
    """How joint rates are bounded, and how an arm returns to its posture.

    The defaults are for a Franka arm.
    """

    # From the wrist to the tool: one radian there moves it by about this much.
    length: float = 0.2  # Weight of turning E against moving it [m].
    # On the smallest singular value, with rotational rows times `length`.
    threshold: float = 0.02  # Below it the rates are damped [m].
    # Slow beside the end effector, which the elbow is not to disturb.
    posture_gain: float = 1.0  # Joint rates per distance from the posture [1/s].
    posture_speed: float = 0.5  # Largest norm of these [rad/s].
    # Corrects the lag of a servo, or what a person's hand on the arm has tilted.
    level_gain: float = 1.0  # Angular velocity of E per orientation error [1/s].

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, LENGTH, "length")
        within(self, Range(1e-6, 1.0, "m"), "threshold")
        within(self, GAIN, "posture_gain", "level_gain")
        within(self, Range(0.0, YAW_RATE.high, "rad/s"), "posture_speed")


def damped_pseudo_inverse(J: Matrix, damping: Damping) -> tuple[Matrix, Scalar]:
    """Returns J^T (J J^T + lambda^2 I)^-1 (n, m), and 1 where lambda > 0, else 0.

    w = trace((J J^T)^-1)^(-1/2) measures how near J is to singular: it is at most the
    smallest singular value, and at least 1/sqrt(m) of it. lambda is 0 for w above
    `threshold`. From there it grows smoothly to `threshold` itself at w = 0, so that
    the inverse multiplies nothing by more than about 1 / threshold.

    Args:
        J: Jacobian (6, n) of V_BE, rotational rows first, or (3, n) of v_BE.
        damping: its `length` weighs these rows, its `threshold` bounds w.
    """
    scaled, weights = _scaled(J, damping)
    gram, eye = scaled @ scaled.T, np.eye(len(J))
    inverse = inv(gram + _TINY * eye)
    w_squared = 1.0 / np.trace(inverse)
    near = larger(1.0 - w_squared / damping.threshold**2, 0.0)
    if near > 0:
        inverse = inv(gram + (near * damping.threshold) ** 2 * eye)
    return scaled.T @ inverse * weights, 1.0 if near > 0 else 0.0


def pseudo_inverse(J: Matrix, damping: Damping) -> Matrix:
    """Returns J^T (J J^T)^-1 (n, m), without damping, however large it is.

    Args:
        J: Jacobian (6, n) of V_BE, rotational rows first, or (3, n) of v_BE.
        damping: its `length` weighs these rows.
    """
    scaled, weights = _scaled(J, damping)
    return scaled.T @ inv(scaled @ scaled.T + _TINY * np.eye(len(J))) * weights


def _scaled(J: Matrix, damping: Damping) -> tuple[Matrix, Matrix]:
    """Returns J with rotational rows in metres, and the weights (m,) of its rows."""
    weights = np.array([damping.length] * (len(J) - 3) + [1.0] * 3)
    return weights[:, None] * J, weights
