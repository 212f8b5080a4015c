"""What a tick costs in each case, with all cases timed by turns."""

import gc
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from drake_mobman.benchmarking.case import BenchmarkCase
from drake_mobman.benchmarking.cases import REFERENCE, Cases

Clock = Callable[[], float]

Cost = dict[str, Any]
"""Mean, median, 99th percentile, largest and smallest time of a tick [us], under
`mean_us` and so on; `ratio` to the reference's time at the same level, of the medians
of each turn, as in `spread`; and `unsolved`, the ticks without a solution."""

Costs = dict[str, dict[str, Cost]]
"""By level and name."""

_WARM_UP = 50
"""Ticks before the clock counts."""


def tick_costs(
    cases: Cases,
    ticks: Sequence[Any],
    turns: int,
    clock: Clock = time.perf_counter,
    reference: str = REFERENCE,
) -> Costs:
    """Returns what the ticks cost in each case, by level and name.

    All cases go through a stretch of the ticks in turn, then through the next stretch,
    in which another case is the first.

    Args:
        cases: to time, by level and name.
        ticks: inputs, the same for all cases.
        turns: stretches into which the ticks are cut, at most one for each tick.
        clock: to time by [s].
        reference: name of the case that all of its level are compared to.
    """
    all_cases = {id(one): one for level in cases.values() for one in level.values()}
    size = len(ticks) // turns
    times: dict[int, list[np.ndarray]] = {key: [] for key in all_cases}
    unsolved = dict.fromkeys(all_cases, 0)
    for case in all_cases.values():
        _timed(case, ticks[:_WARM_UP], clock)
    order = deque(all_cases)
    with _no_garbage_collected():
        for turn in range(turns):
            for key in order:
                stretch = ticks[turn * size : (turn + 1) * size]
                taken, missed = _timed(all_cases[key], stretch, clock)
                times[key].append(taken)
                unsolved[key] += missed
            order.rotate(-1)
    return {
        level: {
            name: _summary(
                np.array(times[id(one)]),
                np.array(times[id(ones[reference])]),
                unsolved[id(one)],
            )
            for name, one in ones.items()
        }
        for level, ones in cases.items()
    }


def _timed(
    case: BenchmarkCase, ticks: Sequence[Any], clock: Clock
) -> tuple[np.ndarray, int]:
    """Returns how long each tick took [s], and for how many nothing was found."""
    times, missed = np.empty(len(ticks)), 0
    for i, tick in enumerate(ticks):
        case.prepare(tick)
        start = clock()
        found = case.act()
        times[i] = clock() - start
        missed += found is None
        case.settle()
    return times, missed


@contextmanager
def _no_garbage_collected() -> Iterator[None]:
    """Keeps Python from collecting in one case's time the garbage of others."""
    was_enabled = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def _summary(times: np.ndarray, reference: np.ndarray, unsolved: int) -> Cost:
    """Returns the numbers of one case.

    Args:
        times: of each tick in each turn (turns, size) [s].
        reference: the same of the reference.
        unsolved: ticks in which nothing was found.
    """
    ratios = np.median(times, axis=1) / np.median(reference, axis=1)
    return {
        "mean_us": 1e6 * float(np.mean(times)),
        "median_us": 1e6 * float(np.median(times)),
        "p99_us": 1e6 * float(np.percentile(times, 99)),
        "max_us": 1e6 * float(np.max(times)),
        "min_us": 1e6 * float(np.min(times)),
        "ratio": spread(ratios),
        "unsolved": unsolved,
    }


def spread(ratios: np.ndarray) -> dict[str, float]:
    """Returns the median of ratios over turns, and their quartiles."""
    low, median, high = np.percentile(ratios, [25, 50, 75])
    return {"median": float(median), "low": float(low), "high": float(high)}
