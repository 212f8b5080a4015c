"""How far the arm reaches: by sampling the ranges of its joints, and by climbing."""

from collections.abc import Callable

import numpy as np

from drake_mobman.arm.chain import Chain
from drake_mobman.arm.shoulder import shoulder_of
from drake_mobman.robots.derive.derived import Derived
from drake_mobman.robots.derive.ranges import Ranges
from drake_mobman.scalars import Matrix

_SAMPLES = 500
"""Joint positions to climb from the best of, the same each time."""

_CLIMBED = 3
"""How many of them are climbed from."""

_FIRST, _LAST = 0.3, 1e-5
"""First and last step of a climb, as shares of a joint's range."""


def farthest(chain: Chain, ranges: Ranges) -> Derived[float]:
    """Returns the largest distance of T from the shoulder, r_f [m].

    A lift stays in the middle of its range, so that the shoulder rests.

    Args:
        chain: of the arm.
        ranges: of its joints.
    """
    at_rest = shoulder_of(chain, ranges.middle)
    still = {at_rest.turn.joint} if at_rest.turn else set[int]()
    if at_rest.lift:
        still.add(at_rest.lift.joint)
    moving = [i for i in range(chain.num_joints) if i not in still]

    def distance(q: Matrix) -> float:
        p_BT = chain.at(q.tolist()).p_BT
        return float(np.linalg.norm(np.subtract(p_BT, at_rest.p_BS)))

    rng = np.random.default_rng(0)
    samples = rng.uniform(ranges.low, ranges.high, (_SAMPLES, chain.num_joints))
    samples[:, list(still)] = ranges.middle[list(still)]
    best = sorted(samples, key=distance)[-_CLIMBED:]
    far = max(_climbed(distance, q, ranges, moving) for q in best)
    return Derived(far, f"farthest of {_SAMPLES} random postures, climbed from")


def _climbed(
    distance: Callable[[Matrix], float], q: Matrix, ranges: Ranges, moving: list[int]
) -> float:
    """Returns the largest distance on a climb by one joint after the other."""
    best, share = distance(q), _FIRST
    while share > _LAST:
        found = best
        for i in moving:
            for step in (-share, share):
                to = q.copy()
                to[i] += step * (ranges.high[i] - ranges.low[i])
                to[i] = min(max(to[i], ranges.low[i]), ranges.high[i])
                if (value := distance(to)) > best:
                    q, best = to, value
        if not best > found + 1e-9:
            share /= 2
    return best
