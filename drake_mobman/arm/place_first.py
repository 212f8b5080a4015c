"""Place before orientation: a wrist at its end turns the hand, and the hand goes on.

Ours. The joints that do not move the wrist's centre T are there for the orientation
alone. Where one of them is in the way, the hand is turned otherwise, about E, so that
it is not: about the vertical if that does, and else about any axis.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from pydrake.math import inv

from drake_mobman.arm.limits import JointLimits, end_rates
from drake_mobman.scalars import Scalar, largest

_MUCH = 0.5
"""Of the largest rate that turning the hand takes of a joint: a joint with more can be
relieved by turning the hand otherwise, without making the others much faster."""

_TINY = 1e-12
"""Square of a joint's rate by 1 rad/s of the hand that an inverse is given to stay
finite."""

_BETTER = 1.0 + 1e-9
"""How much more of the hand's velocity another way is to make."""


class Placed(NamedTuple):
    """Joint rates that move the hand as told, or slower in its direction."""

    rates: list[Scalar]  # (n,) [rad/s].
    share: Scalar  # Of the hand's velocity that they make, in [0, 1].
    held: tuple[int, ...]  # Joints that had to be relieved.
    gives_way: bool  # Whether the hand is not turned as it was first wanted.


def relieved(
    rates: Sequence[Scalar], held: Mapping[int, Scalar], turns: Any
) -> list[Scalar]:
    """Returns joint rates that move E as `rates` do, with some joints told theirs.

    Args:
        rates: of all joints (n,) [rad/s].
        held: rate by joint [rad/s].
        turns: by 1 rad/s of the hand about B's axes, E in its place (n, 3).
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
    # Rounding is much to a joint at its end.
    return [held.get(i, rate) for i, rate in enumerate(found)]


def yaws(joint: int, turns: Any) -> bool:
    """Returns whether turning the hand about the vertical relieves a joint."""
    by_yaw = [abs(rate) for rate in turns[:, 2].tolist()]
    return bool(by_yaw[joint] > _MUCH * largest(*by_yaw))


def place_first(
    wanted: Sequence[Scalar],
    turns: Any,
    wrist: Sequence[int],
    q: Any,
    limits: JointLimits,
    period: float,
) -> Placed:
    """Returns joint rates within the limits that make most of the hand's velocity.

    They are the wanted ones, scaled by one factor, or with wrist joints slowed down to
    what they may: one that nears its end, or is too fast, where yaw relieves it.

    Args:
        wanted: joint rates (n,) [rad/s].
        turns: as `relieved` takes it.
        wrist: joints that only the orientation needs.
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


def best_placed(ways: Sequence[Sequence[Scalar]], *rest: Any) -> Placed:
    """Returns `place_first` of the first of several ways to move the hand that does.

    Args:
        ways: joint rates (n,) [rad/s] that move E alike; the first is the one wanted.
        rest: as `place_first` takes it.
    """
    best = place_first(ways[0], *rest)
    for other in ways[1:]:
        if not best.share < 1:
            break
        placed = place_first(other, *rest)
        if placed.share > _BETTER * best.share:
            best = placed._replace(gives_way=True)
    return best
