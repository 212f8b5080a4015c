"""What a tick of each decomposer costs, as in the paper's table 3, and a whole run.

All decomposers are told the same recorded states and commands, in one process and by
turns, so that a machine that is busy with something else is so for all. Then come the
real-time factors of whole scenarios.
"""

import gc
import os
import platform
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from drake_mobman.analysis.compare import markdown_table
from drake_mobman.benchmarking.cases import (
    BLOCK,
    COMPILED,
    LAW,
    REFERENCE,
    SOLVER,
    BenchmarkCase,
    Contenders,
    Tick,
    benchmark_cases,
    recorded_ticks,
)
from drake_mobman.benchmarking.real_time import (
    Factors,
    real_time_factors,
    threading_ratios,
)
from drake_mobman.scenario import AnyScenario, load_scenario, scenario_paths
from drake_mobman.simulation.simulate import Run
from drake_mobman.teleop.external import External
from drake_mobman.teleop.live import Operator

Cost = dict[str, Any]
"""Mean, median, 99th percentile, largest and smallest time of a tick [us], under
`mean_us` and so on; `ratio` to the reference's at the same level, of the medians of
each turn, as `spread` has it; and `unsolved`, the ticks in which nothing was found."""

Costs = dict[str, dict[str, Cost]]
"""By level and name."""

_SOLVERS = ("qpsolvers", "daqp", "proxsuite", "quadprog")
"""The dense solvers by the names under which they are installed."""

_WARM_UP = 50
"""Ticks before the clock counts."""

_STRETCH = 2.0
"""Simulated in one turn [s]."""

_LONG = 30.0
"""Simulated at a time in two threads [s]: to start them takes some time, too."""


def tick_costs(entered: Contenders, ticks: Sequence[Tick], turns: int) -> Costs:
    """Returns what the ticks cost each contender, by level and name.

    A stretch of the ticks is each contender's in turn, then the next stretch, begun by
    the next one.

    Args:
        entered: who competes.
        ticks: what they are told.
        turns: stretches into which the ticks are cut, at most one for each tick.
    """
    everyone = {id(one): one for level in entered.values() for one in level.values()}
    size = len(ticks) // turns
    times: dict[int, list[np.ndarray]] = {key: [] for key in everyone}
    unsolved = dict.fromkeys(everyone, 0)
    for contender in everyone.values():
        _timed(contender, ticks[:_WARM_UP])
    order = deque(everyone)
    with _no_garbage_collected():
        for turn in range(turns):
            for key in order:
                stretch = ticks[turn * size : (turn + 1) * size]
                taken, missed = _timed(everyone[key], stretch)
                times[key].append(taken)
                unsolved[key] += missed
            order.rotate(-1)
    return {
        level: {
            name: _summary(
                np.array(times[id(one)]),
                np.array(times[id(ones[REFERENCE])]),
                unsolved[id(one)],
            )
            for name, one in ones.items()
        }
        for level, ones in entered.items()
    }


def _timed(contender: BenchmarkCase, ticks: Sequence[Tick]) -> tuple[np.ndarray, int]:
    """Returns how long each tick took [s], and for how many nothing was found."""
    times, missed = np.empty(len(ticks)), 0
    for i, tick in enumerate(ticks):
        contender.prepare(tick)
        start = time.perf_counter()
        found = contender.act()
        times[i] = time.perf_counter() - start
        missed += found is None
        contender.settle()
    return times, missed


@contextmanager
def _no_garbage_collected() -> Iterator[None]:
    """Keeps Python from tidying up in one contender's time what others left."""
    was_enabled = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def _summary(times: np.ndarray, reference: np.ndarray, unsolved: int) -> Cost:
    """Returns the numbers of one contender.

    Args:
        times: of each tick in each turn (turns, size) [s].
        reference: the same of whom it is measured by.
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


# The whole of it.


def bench(
    scenario: AnyScenario,
    run: Run,
    turns: int,
    tell: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """Returns all costs and factors, in terms that JSON has.

    Args:
        scenario: as `load_scenario` returns it, of a robot that is commanded.
        run: of this scenario; the ticks are taken from there.
        turns: over which all is spread.
        tell: told what is being timed.

    Raises:
        ScenarioError: where nobody commands the hand.
    """
    tell("ticks")
    entered, missing = benchmark_cases(scenario)
    ticks = recorded_ticks(run)
    begun = time.process_time(), time.perf_counter()
    costs = tick_costs(entered, ticks, min(turns, len(ticks)))
    used, passed = time.process_time() - begun[0], time.perf_counter() - begun[1]
    factors = {}
    for name in scenario_paths():
        other = load_scenario(name)
        if not isinstance(getattr(other, "source", None), External | Operator):
            tell(f"real-time factor of {name}")
            taken = real_time_factors(other, turns, _STRETCH)
            factors[name] = _compared(taken)
    tell("two threads")
    return {
        "ran_on": ran_on(),
        "core_share": used / passed,
        "ticks": len(ticks),
        "turns": turns,
        "costs": costs,
        "missing": missing,
        "real_time_factors": factors,
        "two_threads": spread(np.array(threading_ratios(scenario, turns, _LONG))),
    }


def _compared(factors: Factors) -> dict[str, Any]:
    """Returns medians of real-time factors, and their ratios turn by turn."""
    taken = {name: np.array(values) for name, values in factors.items()}
    medians = {name: float(np.median(values)) for name, values in taken.items()}
    ratios = {"compiled_to_python": spread(taken["compiled"] / taken["python"])}
    if "bare" in taken:
        ratios["compiled_to_bare"] = spread(taken["compiled"] / taken["bare"])
    return medians | ratios


def ran_on() -> dict[str, Any]:
    """Returns the date, the machine, and the version of everything that counts."""
    numbers = {}
    for name in ("drake_mobman", "drake", "numpy", *_SOLVERS):
        with suppress(PackageNotFoundError):
            numbers[name] = version(name)
    return {
        "date": datetime.now(UTC).date().isoformat(),
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
        **numbers,
    }


def _processor() -> str:
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            name, _, value = line.partition(":")
            if name.strip() == "model name":
                return value.strip()
    return platform.processor() or platform.machine()


# As it is printed.

_TABLE_3 = (
    "Kwon's table 3, on a machine that it does not name, has a mean of 90 µs, largest"
    " 270, smallest 40, for the proposed law, and 2340, 5520 and 1480 for the program."
)

_HEADINGS = {
    LAW: "Bare law",
    BLOCK: "Block in a diagram",
    COMPILED: "Compiled block in a diagram",
    SOLVER: "The program's solution alone, its matrices given, beside the bare law",
}


def report(content: dict[str, Any], name: str) -> str:
    """Returns what `bench` does, as Markdown.

    Args:
        content: what `bench` returns.
        name: of the scenario.
    """
    told = dict(content["ran_on"])
    date, processor, cores = (told.pop(key) for key in ("date", "processor", "cores"))
    versions = ", ".join(f"{key} {value}" for key, value in told.items())
    parts = [
        f"{date}, {processor}, {cores} cores; {versions}.",
        f"Time of a tick [µs], over {content['ticks']} ticks of `{name}` in"
        f" {content['turns']} turns. The ratio is to {REFERENCE} at the same level,"
        " of the medians of each turn: their median, and quartiles. The process had"
        f" {100 * content['core_share']:.0f} % of a core meanwhile. {_TABLE_3}",
    ]
    for level, costs in content["costs"].items():
        if costs:
            parts += [f"### {_HEADINGS[level]}", _cost_table(costs)]
    parts += [
        f"As {level}, {name} found no solution in {cost['unsolved']} of the ticks."
        for level, costs in content["costs"].items()
        for name, cost in costs.items()
        if cost["unsolved"]
    ]
    parts += [f"Left out: {line}." for line in content["missing"]]
    parts += [
        "### Real-time factor",
        "Simulated over wall time, with all blocks and loggers; and of the plant alone,"
        " where there is one.",
        _factor_table(content["real_time_factors"]),
        f"Two compiled diagrams of `{name}` in two threads take"
        f" {_with_quartiles(content['two_threads'])} times the wall time of one.",
    ]
    return "\n\n".join(parts)


def _cost_table(costs: dict[str, Cost]) -> str:
    columns = ("mean", "median", "p99", "max", "min")
    rows = [
        [
            name,
            *(_digits(cost[f"{column}_us"]) for column in columns),
            _with_quartiles(cost["ratio"]),
        ]
        for name, cost in costs.items()
    ]
    return markdown_table(["decomposer", *columns, "ratio"], rows)


def _factor_table(factors: dict[str, Any]) -> str:
    keys = ("python", "compiled", "bare")
    rows = [
        [
            name,
            *(_digits(taken[key]) if key in taken else "-" for key in keys),
            *(
                _with_quartiles(taken[key]) if key in taken else "-"
                for key in ("compiled_to_python", "compiled_to_bare")
            ),
        ]
        for name, taken in factors.items()
    ]
    heading = ["scenario", "Python blocks", "compiled", "bare plant"]
    return markdown_table([*heading, "compiled / Python", "compiled / bare"], rows)


def _digits(number: float) -> str:
    """Returns three digits, or as many as stand before the point."""
    return f"{number:.0f}" if number >= 100 else f"{number:.3g}"


def _with_quartiles(ratio: dict[str, float]) -> str:
    return f"{ratio['median']:.3g} ({ratio['low']:.3g}..{ratio['high']:.3g})"
