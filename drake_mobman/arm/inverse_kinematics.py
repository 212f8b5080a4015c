"""Joint angles for a pose of the end effector, by iteration on the Jacobian."""

from collections.abc import Callable

import numpy as np
from pydrake.math import RotationMatrix, inv

from drake_mobman.scalars import Matrix

Arm = Callable[[Matrix], tuple[Matrix, Matrix, Matrix]]

_STEPS = 200
"""Most steps; in reach, about ten are enough."""


def nearest_joint_angles(
    arm: Arm,
    R_BD: Matrix,
    p_BD: Matrix,
    start: Matrix,
    lower: Matrix,
    upper: Matrix,
    length: float | None,
) -> tuple[Matrix, float]:
    """Returns joint positions (n,) that put E at a pose, and how far E misses it.

    By the steps of Levenberg and Marquardt. Out of reach, they end near in position
    and, weighted, in rotation.

    Args:
        arm: returns R_BE (3, 3), p_BE (3,) and the Jacobian (6, n) of V_BE.
        R_BD: desired axes of E (3, 3).
        p_BD: desired place of E (3,) [m].
        start: joint positions (n,) to start from, within the limits [rad], [m].
        lower: smallest joint positions (n,) [rad], [m].
        upper: largest joint positions (n,) [rad], [m].
        length: weight of a rotation against a translation [m]; None where the
            rotation does not matter.
    """
    q = start
    error, J = _weighted_error(arm, q, R_BD, p_BD, length)
    mu, eye = 1e-3, np.eye(len(error))
    for _ in range(_STEPS):
        free = np.where(J.T @ error > 0, q < upper, q > lower)
        J_free = J * free
        step = J_free.T @ inv(J_free @ J_free.T + mu * eye) @ error
        next_q = np.clip(q + step, lower, upper)
        next_error, next_J = _weighted_error(arm, next_q, R_BD, p_BD, length)
        if next_error @ next_error < error @ error:
            q, error, J = next_q, next_error, next_J
            mu = max(0.1 * mu, 1e-8)
        elif mu > 1e3:
            break
        else:
            mu *= 10
    return q, float(np.linalg.norm(error))


def _weighted_error(
    arm: Arm, q: Matrix, R_BD: Matrix, p_BD: Matrix, length: float | None
) -> tuple[Matrix, Matrix]:
    """Returns the error (6,) from E to D, and the Jacobian (6, n), both weighted.

    Without a weight, those of the place alone, (3,) and (3, n).
    """
    R_BE, p_BE, J = arm(q)
    if length is None:
        return p_BD - p_BE, J[3:]
    left = RotationMatrix.ProjectToRotationMatrix(R_BD @ R_BE.T).ToAngleAxis()
    error = np.append(length * left.angle() * left.axis(), p_BD - p_BE)
    J[:3] *= length
    return error, J
