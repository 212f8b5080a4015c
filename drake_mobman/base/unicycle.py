"""The base as a unicycle: it rolls along its heading and turns (Kwon et al., eq. 1).

The paper prints `v_bm`, the projection on the reach, in place of `v_b`.
"""

from pydrake.math import cos, sin

from drake_mobman.scalars import Scalar


def unicycle_rates(
    theta: Scalar, v: Scalar, omega: Scalar
) -> tuple[Scalar, Scalar, Scalar]:
    """Returns the rates of x, y [m/s] and theta [rad/s] in W.

    Args:
        theta: heading [rad].
        v: forward speed [m/s].
        omega: yaw rate [rad/s].
    """
    return v * cos(theta), v * sin(theta), omega
