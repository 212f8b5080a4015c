"""The inverse of a Jacobian, damped where that is nearly singular.

After Nakamura & Hanafusa (1986). By sums and products without a branch, for any scalar.
"""

import dataclasses as dc
from collections.abc import Sequence

from drake_mobman.parameters import GAIN, LENGTH, YAW_RATE, Range, within
from drake_mobman.scalars import Rows, Scalar, Vector, larger, where
from drake_mobman.tracing import all_named, named

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


def damped_pseudo_inverse(
    J: Rows, damping: Damping
) -> tuple[list[list[Scalar]], Scalar]:
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
    squares = gram(scaled)
    inverse = symmetric_inverse(squares, _TINY)
    trace = named(sum(inverse[i][i] for i in range(len(squares))))
    near = named(larger(1.0 - 1.0 / (trace * damping.threshold**2), 0.0))
    damped = symmetric_inverse(squares, (near * damping.threshold) ** 2 + _TINY)
    return _unscaled(scaled, damped, weights), where(near > 0, 1.0, 0.0)


def pseudo_inverse(J: Rows, damping: Damping) -> list[list[Scalar]]:
    """Returns J^T (J J^T)^-1 (n, m), without damping, however large it is.

    Args:
        J: Jacobian (6, n) of V_BE, rotational rows first, or (3, n) of v_BE.
        damping: its `length` weighs these rows.
    """
    scaled, weights = _scaled(J, damping)
    return _unscaled(scaled, symmetric_inverse(gram(scaled), _TINY), weights)


def symmetric_inverse(A: Rows, added: Scalar = 0.0) -> list[list[Scalar]]:
    """Returns the inverse (m, m) of A + added I, by its factors L D L^T.

    Args:
        A: symmetric (m, m), of which the lower half counts.
        added: to the diagonal, which makes the matrix positive definite.
    """
    m = len(A)
    L = [[0.0] * m for _ in A]  # Below the diagonal of ones.
    LD = [[0.0] * m for _ in A]
    D: list[Scalar] = []
    for j in range(m):
        D.append(named(A[j][j] + added - dot(L[j][:j], LD[j][:j])))
        for i in range(j + 1, m):
            LD[i][j] = named(A[i][j] - dot(L[j][:j], LD[i][:j]))
            L[i][j] = named(LD[i][j] / D[j])
    M = [[0.0] * m for _ in A]  # The inverse of L.
    for j in range(m):
        M[j][j] = 1.0
        for i in range(j + 1, m):
            M[i][j] = named(-dot(L[i][j:i], [M[k][j] for k in range(j, i)]))
    inverse = [[0.0] * m for _ in A]
    for i in range(m):
        for j in range(i + 1):
            terms = (M[k][i] * M[k][j] / D[k] for k in range(i, m))
            inverse[i][j] = inverse[j][i] = named(sum(terms))
    return inverse


def dot(a: Vector, b: Vector) -> Scalar:
    """Returns the inner product of two vectors."""
    return sum((x * y for x, y in zip(a, b, strict=True)), 0.0)


def gram(J: Rows) -> list[list[Scalar]]:
    """Returns the lower half of J J^T (m, m)."""
    return [
        [named(dot(J[i], J[j])) for j in range(i + 1)] + [0.0] * (len(J) - i - 1)
        for i in range(len(J))
    ]


def _scaled(J: Rows, damping: Damping) -> tuple[list[list[Scalar]], list[float]]:
    """Returns J with rotational rows in metres, and the weights (m,) of its rows."""
    weights = [damping.length] * (len(J) - 3) + [1.0] * 3
    return [
        all_named([w * x for x in row]) for w, row in zip(weights, J, strict=True)
    ], weights


def _unscaled(
    scaled: Rows, inverse: Rows, weights: Sequence[float]
) -> list[list[Scalar]]:
    """Returns scaled^T inverse (n, m), with its columns weighted."""
    return [
        all_named(
            [w * dot(column, row) for w, row in zip(weights, inverse, strict=True)]
        )
        for column in zip(*scaled, strict=True)
    ]
