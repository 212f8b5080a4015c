"""Joint angles for a pose of the end effector, by iteration on the Jacobian."""

from typing import Any

import numpy as np
from pydrake.math import inv

from drake_mobman.arm.plant_kinematics import PlantKinematics
from drake_mobman.scalars import Matrix

_STEPS = 200
"""Most steps; in reach, about ten are enough."""


def nearest_joint_angles(
    arm: PlantKinematics,
    X_BD: Any,
    start: Matrix,
    lower: Matrix,
    upper: Matrix,
    length: float | None,
) -> tuple[Matrix, float]:
    """Returns joint positions (n,) that put E at a pose, and how far E misses it.

    By the steps of Levenberg and Marquardt. Out of reach, they end near in position
    and, weighted, in rotation.

    Args:
        arm: for floats; its joint positions are changed.
        X_BD: desired pose of E, a `RigidTransform`.
        start: joint positions (n,) to start from, within the limits [rad], [m].
        lower: smallest joint positions (n,) [rad], [m].
        upper: largest joint positions (n,) [rad], [m].
        length: weight of a rotation against a translation [m]; None where the
            rotation does not matter.
    """
    q = start
    error, J = _weighted_error(arm, q, X_BD, length)
    mu, eye = 1e-3, np.eye(len(error))
    for _ in range(_STEPS):
        free = np.where(J.T @ error > 0, q < upper, q > lower)
        J_free = J * free
        step = J_free.T @ inv(J_free @ J_free.T + mu * eye) @ error
        next_q = np.clip(q + step, lower, upper)
        next_error, next_J = _weighted_error(arm, next_q, X_BD, length)
        if next_error @ next_error < error @ error:
            q, error, J = next_q, next_error, next_J
            mu = max(0.1 * mu, 1e-8)
        elif mu > 1e3:
            break
        else:
            mu *= 10
    return q, float(np.linalg.norm(error))


def _weighted_error(
    arm: PlantKinematics, q: Matrix, X_BD: Any, length: float | None
) -> tuple[Matrix, Matrix]:
    """Returns the error (6,) from E to D, and the Jacobian (6, n), both weighted.

    Without a weight, those of the place alone, (3,) and (3, n).
    """
    arm.set(q)
    X_BE = arm.X_BE()
    if length is None:
        return X_BD.translation() - X_BE.translation(), arm.J_V_BE()[3:]
    rotation = (X_BD.rotation() @ X_BE.rotation().inverse()).ToAngleAxis()
    error = np.append(
        length * rotation.angle() * rotation.axis(),
        X_BD.translation() - X_BE.translation(),
    )
    J = arm.J_V_BE()
    J[:3] *= length
    return error, J
