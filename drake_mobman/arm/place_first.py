"""Position before orientation: a wrist joint at its limit does not stop E.

Ours. The joints that do not move the wrist's centre T serve the orientation only. Where
the limit of one of them would slow the end effector down, it turns about E instead, so
that this joint is relieved: about the vertical if that is enough, else about any axis.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from pydrake.math import inv

from drake_mobman.arm.limits import JointLimits, end_rates
from drake_mobman.scalars import Matrix, Scalar, Vector, largest

_MUCH = 0.5
"""Share of the largest joint rate that a rotation of E takes. A joint with more can be
relieved by such a rotation, without making the others much faster."""

_TINY = 1e-12
"""Square of a joint's rate by 1 rad/s of E, added so that an inverse stays finite."""

_BETTER = 1.0 + 1e-9
"""How many times more of E's velocity another solution must make, to be taken."""


class Placed(NamedTuple):
    """Joint rates that move E as commanded, or slower in the same direction."""

    rates: list[Scalar]  # (n,) [rad/s].
    share: Scalar  # Of E's velocity that they make, in [0, 1].
    held: tuple[int, ...]  # Indices of the joints that were relieved.
    gives_way: bool  # Whether the orientation is not as first wanted.


def relieved(rates: Vector, held: Mapping[int, Scalar], turns: Matrix) -> list[Scalar]:
    """Returns joint rates that move E as `rates` do, with given rates of some joints.

    Args:
        rates: joint rates (n,) [rad/s].
        held: the given rates, by index of the joint [rad/s].
        turns: joint rates that turn E in its place by 1 rad/s about B's axes (n, 3).
    """
    if not held:
        return list(rates)
    joints = list(held)
    missing = np.array([held[i] - rates[i] for i in joints])
    if len(joints) == 1 and yaws(joints[0], turns):
        turn = np.array([0.0, 0.0, missing[0] / turns[joints[0], 2]])
    else:
        rows = turns[joints]
        turn = rows.T @ (inv(rows @ rows.T + _TINY * np.eye(len(rows))) @ missing)
    found = (np.asarray(rates) + turns @ turn).tolist()
    # To a joint at its limit, rounding matters.
    return [held.get(i, rate) for i, rate in enumerate(found)]


def yaws(joint: int, turns: Matrix) -> bool:
    """Returns whether turning E about the vertical relieves a joint."""
    by_yaw = [abs(rate) for rate in turns[:, 2].tolist()]
    return bool(by_yaw[joint] > _MUCH * largest(*by_yaw))


def place_first(
    wanted: Vector,
    turns: Matrix,
    wrist: Sequence[int],
    q: Vector,
    limits: JointLimits,
    period: float,
) -> Placed:
    """Returns joint rates within the limits that make the most of E's velocity.

    They are the wanted ones, scaled by one factor. Or wrist joints are slowed down to
    their limits: one that nears the end of its range, or one that is too fast and that
    yaw relieves.

    Args:
        wanted: joint rates (n,) [rad/s].
        turns: as for `relieved`.
        wrist: indices of the joints that serve the orientation only.
        q: joint angles (n,) [rad].
        limits: of the joints.
        period: for which the rates are held [s].
    """
    rates = list(wanted)
    held: dict[int, Scalar] = {}
    best: Placed | None = None
    while True:
        ends = end_rates(rates, q, limits, period)
        past = [abs(rate) / end for rate, end in zip(rates, ends, strict=True)]
        fast = [abs(x) / most for x, most in zip(rates, limits.velocity, strict=True)]
        share = 1.0 / largest(1.0, *past, *fast)
        if best is None or share > _BETTER * best.share:
            slowed = [share * rate for rate in rates]
            best = Placed(slowed, share, tuple(held), gives_way=bool(held))
        more = [
            i
            for i in wrist
            if i not in held and (past[i] > 1 or (fast[i] > 1 and yaws(i, turns)))
        ]
        if not more:
            return best
        for i in more:
            held[i] = rates[i] / largest(past[i], fast[i])
        rates = relieved(wanted, held, turns)


def give_way(
    ways: Sequence[Vector],
    posture: Vector,
    turns: Matrix,
    wrist: Sequence[int],
    q: Vector,
    limits: JointLimits,
    period: float,
) -> tuple[list[Scalar], list[Scalar]] | None:
    """Returns joint and posture rates where the orientation gives way, else None.

    Args:
        ways: joint rates (n,) [rad/s] that move E alike, by preference; the first are
            those wanted. Later ones count only while all before fall short of E's
            velocity.
        posture: joint rates (n,) [rad/s] towards the posture.
        turns: joint rates (n, 3) that turn E in its place.
        wrist: indices of the joints that serve the orientation only.
        q: joint angles (n,) [rad].
        limits: of the joints.
        period: for which the rates are held [s].
    """
    best = place_first(ways[0], turns, wrist, q, limits, period)
    for other in ways[1:]:
        if not best.share < 1:
            break
        placed = place_first(other, turns, wrist, q, limits, period)
        if placed.share > _BETTER * best.share:
            best = placed._replace(gives_way=True)
    if not best.gives_way:
        return None
    return best.rates, relieved(posture, dict.fromkeys(best.held, 0.0), turns)
