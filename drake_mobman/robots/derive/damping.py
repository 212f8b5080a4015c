"""How an arm's rates are damped, scaled by the arm's size."""

from drake_mobman.arm.pseudo_inverse import Damping
from drake_mobman.parameters import LENGTH
from drake_mobman.robots.derive.derived import Derived

_HAND = 0.2
"""Least weight of a rotation [1]: a share of the arm's reach."""

_THRESHOLD = 0.02 / 0.72
"""Of the reach: as for the Franka arm, whose r_f is 0.72 m."""


def damping(r_f: float, hand: float) -> Derived[Damping]:
    """Returns the damping of an arm.

    Args:
        r_f: largest distance of T from the shoulder [m].
        hand: distance of E from T [m], which a radian of the wrist moves it by.
    """
    length = max(hand, _HAND * r_f, LENGTH.low)
    found = Damping(length=length, threshold=max(_THRESHOLD * r_f, 1e-6))
    return Derived(found, f"scaled by r_f = {r_f:.3f} m and the hand, {hand:.3f} m")
