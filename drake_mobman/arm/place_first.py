"""Position before orientation: a wrist joint at its limit does not stop E.

Ours. The joints that do not move the wrist's centre T serve the orientation only. Where
the limit of one of them would slow the end effector down, it turns about E instead, so
that this joint is relieved: about the vertical if that is enough, else about any axis.

Which joints are relieved are numbers, 1 or 0, so that the law has no branch that an
Expression could not take.
"""

from collections.abc import Sequence
from typing import NamedTuple

from drake_mobman.arm.limits import ArmStatus, JointLimits, end_rates
from drake_mobman.arm.pseudo_inverse import dot, gram, symmetric_inverse
from drake_mobman.scalars import Rows, Scalar, Vector, known, largest, where
from drake_mobman.tracing import all_named, named

_MUCH = 0.5
"""Share of the largest joint rate that a rotation of E takes. A joint with more can be
relieved by such a rotation, without making the others much faster."""

_TINY = 1e-12
"""Square of a joint's rate by 1 rad/s of E, added so that an inverse stays finite."""

_BETTER = 1.0 + 1e-9
"""How many times more of E's velocity another solution must make, to be taken."""


class Wrist(NamedTuple):
    """The joints that serve the orientation only, and what limits them."""

    joints: Sequence[int]  # Their indices (k,).
    turns: (
        Rows  # Joint rates that turn E in its place by 1 rad/s about B's axes (n, 3).
    )
    q: Vector  # Joint angles (n,) [rad].
    limits: JointLimits  # Of all joints.
    period: float  # For which rates are held [s].


class Placed(NamedTuple):
    """Joint rates that move E as commanded, or slower in the same direction."""

    rates: list[Scalar]  # (n,) [rad/s].
    share: Scalar  # Of E's velocity that they make, in [0, 1].
    held: list[Scalar]  # 1 for each joint of the wrist that was relieved, else 0 (k,).
    gives_way: Scalar  # 1 where the orientation is not as first wanted, else 0.


def relieved(
    rates: Vector, joints: Sequence[int], held: Vector, to: Vector, turns: Rows
) -> list[Scalar]:
    """Returns joint rates that move E as `rates` do, with given rates of some joints.

    Args:
        rates: joint rates (n,) [rad/s].
        joints: indices of joints of the wrist (k,).
        held: 1 for each that gets a given rate, else 0 (k,).
        to: the given rates (k,) [rad/s].
        turns: joint rates that turn E in its place by 1 rad/s about B's axes (n, 3).
    """
    count = named(sum(held))
    if known(count == 0):
        return list(rates)
    missing = all_named(
        [h * (x - rates[i]) for i, h, x in zip(joints, held, to, strict=True)]
    )
    rows = [
        all_named([h * x for x in turns[i]]) for i, h in zip(joints, held, strict=True)
    ]
    pushes = [dot(row, missing) for row in symmetric_inverse(gram(rows), _TINY)]
    turn = all_named([dot(column, pushes) for column in zip(*rows, strict=True)])
    for i, h, x in zip(joints, held, missing, strict=True):
        alone = named(where(count < 1.5, h * yaws(i, turns), 0.0))
        about_z = x / where(alone > 0.5, turns[i][2], 1.0)
        yaw_only = [0.0, 0.0, about_z]
        turn = _chosen(alone, yaw_only, turn)
    found = all_named(
        [rate + dot(row, turn) for rate, row in zip(rates, turns, strict=True)]
    )
    # To a joint at its limit, rounding matters.
    for i, h, x in zip(joints, held, to, strict=True):
        found[i] = named(where(h > 0.5, x, found[i]))
    return found


def yaws(joint: int, turns: Rows) -> Scalar:
    """Returns 1 where turning E about the vertical relieves a joint, else 0."""
    by_yaw = [abs(row[2]) for row in turns]
    return named(where(by_yaw[joint] > _MUCH * largest(*by_yaw), 1.0, 0.0))


def place_first(wanted: Vector, wrist: Wrist) -> Placed:
    """Returns joint rates within the limits that make the most of E's velocity.

    They are the wanted ones, scaled by one factor. Or wrist joints are slowed down to
    their limits: one that nears the end of its range, or one that is too fast and that
    yaw relieves.

    Args:
        wanted: joint rates (n,) [rad/s].
        wrist: the joints that may give way.
    """
    joints, turns, q, limits, period = wrist
    rates = list(wanted)
    held, to = [0.0] * len(joints), [0.0] * len(joints)
    best: Placed | None = None
    for _ in range(len(joints) + 1):
        ends = end_rates(rates, q, limits, period)
        past = all_named([abs(x) / end for x, end in zip(rates, ends, strict=True)])
        fast = [abs(x) / most for x, most in zip(rates, limits.velocity, strict=True)]
        share = named(1.0 / largest(1.0, *past, *fast))
        slowed = all_named([share * rate for rate in rates])
        if best is None:
            best = Placed(slowed, share, held, 0.0)
        else:
            better = named(where(share > _BETTER * best.share, 1.0, 0.0))
            best = _better(better, Placed(slowed, share, held, 1.0), best)
        more = [
            where(h > 0.5, 0.0, _over(past[i], where(fast[i] > 1, yaws(i, turns), 0.0)))
            for i, h in zip(joints, held, strict=True)
        ]
        if known(sum(more) == 0):
            break
        slower = [rates[i] / largest(1.0, past[i], fast[i]) for i in joints]
        to = [
            named(where(m > 0.5, x, y))
            for m, x, y in zip(more, slower, to, strict=True)
        ]
        held = all_named([h + m for h, m in zip(held, more, strict=True)])
        rates = relieved(wanted, joints, held, to, turns)
    assert best
    return best


def give_way(
    rates: Vector,
    bound: Scalar,
    ways: Sequence[Vector],
    posture: Vector,
    wrist: Wrist,
) -> tuple[list[Scalar], list[Scalar], Scalar]:
    """Returns joint and posture rates, and the status: the orientation gives way.

    Args:
        rates: joint rates (n,) within the limits, as they are where nothing gives way.
        bound: the `ArmStatus` flags of what bounds them; 0 where nothing gives way.
        ways: joint rates (n,) [rad/s] that move E alike, by preference; the first are
            those wanted. Later ones count only while all before fall short of E's
            velocity.
        posture: joint rates (n,) [rad/s] towards the posture.
        wrist: the joints that may give way.
    """
    if known(bound <= 0):
        return list(rates), list(posture), bound
    best = place_first(ways[0], wrist)
    for other in ways[1:]:
        if known(best.share >= 1):
            break
        placed = place_first(other, wrist)._replace(gives_way=1.0)
        more = where(placed.share > _BETTER * best.share, 1.0, 0.0)
        better = named(where(best.share < 1, more, 0.0))
        best = _better(better, placed, best)
    still = [0.0] * len(wrist.joints)
    eased = relieved(posture, wrist.joints, best.held, still, wrist.turns)
    gives_way = named(where(bound > 0, best.gives_way, 0.0))
    return (
        _chosen(gives_way, best.rates, rates),
        _chosen(gives_way, eased, posture),
        bound + gives_way * float(ArmStatus.ORIENTATION),
    )


def _over(excess: Scalar, otherwise: Scalar) -> Scalar:
    """Returns 1 where an excess is above 1."""
    return where(excess > 1, 1.0, otherwise)


def _better(better: Scalar, new: Placed, old: Placed) -> Placed:
    """Returns the new one where `better` is 1, else the old one."""
    if known(better < 0.5):
        return old
    (share, gives_way) = _chosen(
        better, [new.share, new.gives_way], [old.share, old.gives_way]
    )
    return Placed(
        _chosen(better, new.rates, old.rates),
        share,
        _chosen(better, new.held, old.held),
        gives_way,
    )


def _chosen(first: Scalar, a: Vector, b: Vector) -> list[Scalar]:
    """Returns a vector where `first` is 1, else another."""
    return [named(where(first > 0.5, x, y)) for x, y in zip(a, b, strict=True)]
