"""What a tick of each decomposer costs, as in Kwon's table 3, and a whole run.

All decomposers get the same recorded inputs, in one process and by turns, so that other
work on the machine slows all of them alike. Then whole scenarios are timed; and of one
with a spatial arm, the control tick, and its robot on wheels.
"""

import dataclasses as dc
import time
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from drake_mobman.benchmarking.cases import benchmark_cases
from drake_mobman.benchmarking.control_tick import DIFF_IK, control_tick_cases
from drake_mobman.benchmarking.costs import spread, tick_costs
from drake_mobman.benchmarking.machine import ran_on
from drake_mobman.benchmarking.real_time import (
    Factors,
    real_time_factors,
    threading_ratios,
)
from drake_mobman.benchmarking.ticks import recorded_ticks
from drake_mobman.robots.wheels import Wheels
from drake_mobman.scenario import AnyScenario, load_scenario, scenario_paths
from drake_mobman.simulation.run import Run
from drake_mobman.simulation.simulate import simulate

STRETCH = 2.0
"""Simulated in one turn [s]."""

FRANKA = "kwon_franka"
"""Scenario with a spatial arm and masses, whose control tick and wheels are timed."""

TICK = "control tick"
"""Level of its costs."""

_LONG = 30.0
"""Simulated at a time in two threads [s]: starting them takes some time, too."""


def bench(
    scenario: AnyScenario,
    run: Run,
    turns: int,
    tell: Callable[[str], None] = lambda _: None,
    *,
    names: Iterable[str] | None = None,
    stretch: float = STRETCH,
) -> dict[str, Any]:
    """Returns all costs and factors, ready for JSON.

    Args:
        scenario: checked, as `load_scenario` returns it; its end effector is commanded.
        run: of this scenario; the inputs of the ticks are taken from it.
        turns: number of turns over which everything is timed.
        tell: called with what is timed next.
        names: of the scenarios that are run whole; all unless given.
        stretch: simulated of these in one turn [s].

    Raises:
        ScenarioError: where the end effector is not commanded.
    """
    tell("ticks")
    cases, left_out = benchmark_cases(scenario)
    ticks = recorded_ticks(run)
    began = time.process_time(), time.perf_counter()
    costs = tick_costs(cases, ticks, min(turns, len(ticks)))
    used, passed = time.process_time() - began[0], time.perf_counter() - began[1]
    factors = {}
    for name in names or scenario_paths():
        other = load_scenario(name)
        if not other.source.fed:
            tell(f"real-time factor of {name}")
            (taken,) = real_time_factors({name: other}, turns, stretch).values()
            factors[name] = _compared(taken)
    franka = _of_franka(turns, stretch, tell)
    tell("two threads")
    return {
        "ran_on": ran_on(),
        "core_share": used / passed,
        "ticks": len(ticks),
        "turns": turns,
        "costs": costs,
        "missing": left_out,
        **franka,
        "real_time_factors": factors,
        "two_threads": spread(np.array(threading_ratios(scenario, turns, _LONG))),
    }


def _of_franka(
    turns: int, stretch: float, tell: Callable[[str], None]
) -> dict[str, Any]:
    """Returns the costs of a control tick, and of wheels, of a robot with masses."""
    tell(f"a control tick of {FRANKA}")
    scenario = load_scenario(FRANKA)
    duration = min(scenario.duration, stretch * turns)
    cases, ticks = control_tick_cases(
        scenario, simulate(dc.replace(scenario, duration=duration))
    )
    few = min(turns, len(ticks))
    costs = tick_costs({TICK: cases}, ticks, few, reference=DIFF_IK)[TICK]
    tell(f"{FRANKA} on wheels")
    by_fidelity = {
        type(fidelity).__name__: dc.replace(scenario, fidelity=fidelity)
        for fidelity in (scenario.fidelity, Wheels())
    }
    taken = real_time_factors(by_fidelity, turns, stretch)
    servo, wheels = taken.values()
    return {
        "control_tick": {"scenario": FRANKA, "ticks": len(ticks), "costs": costs},
        "wheels": {
            "scenario": FRANKA,
            "step": Wheels().step,
            "factors": {name: _compared(each) for name, each in taken.items()},
            "wheels_to_servo": {
                kind: spread(np.array(servo[kind]) / np.array(wheels[kind]))
                for kind in servo
            },
        },
    }


def _compared(factors: Factors) -> dict[str, Any]:
    """Returns medians of real-time factors, and their ratios turn by turn."""
    taken = {name: np.array(values) for name, values in factors.items()}
    medians = {name: float(np.median(values)) for name, values in taken.items()}
    ratios = {"compiled_to_python": spread(taken["compiled"] / taken["python"])}
    if "bare" in taken:
        ratios["compiled_to_bare"] = spread(taken["compiled"] / taken["bare"])
    return medians | ratios
