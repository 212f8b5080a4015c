"""Rotations of the end effector, as matrices for float and AutoDiffXd."""

import numpy as np
from pydrake.math import cos, sin

from drake_mobman.scalars import Matrix, Scalar


def rotation_about_z(angle: Scalar) -> Matrix:
    """Returns the matrix (3, 3) of a rotation by `angle` [rad] about z."""
    c, s = cos(angle), sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def orientation_error(R: Matrix, R_desired: Matrix) -> Matrix:
    """Returns the rotation (3,) from `R` to `R_desired`: its axis times sin(angle).

    Both are (3, 3), in the same frame, and so is the axis.
    """
    M = R_desired @ R.T
    return 0.5 * np.array([M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1]])
