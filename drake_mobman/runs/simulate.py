"""Runs a scenario headless, and times its control tick."""

import dataclasses as dc
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator

from drake_mobman import signals
from drake_mobman.diagrams import make_diagram
from drake_mobman.runs.finite import FAILURES, check_finite, death, death_by_log
from drake_mobman.runs.log import Log, read_log, until_not_finite
from drake_mobman.runs.scenario import AnyScenario
from drake_mobman.ticks import at_tick, last_tick

_CHUNK = 10
"""Control periods between two looks at progress and at the state's finiteness."""


@dc.dataclass
class Run:
    """What came of a scenario."""

    scenario: AnyScenario
    log: Log  # All of it, or up to where the run died.
    wall_time: float  # Of the simulation, logging included [s].
    tick_times: np.ndarray  # Of control ticks, in order [s].
    died: str = ""  # When and why, in one line; empty for a run that went through.
    interrupted: bool = False  # Whether the user ended it.


def simulate(
    scenario: AnyScenario,
    *,
    decomposer: Callable[[], Any] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Run:
    """Returns the run of a scenario from its start to its end, or to where it died.

    Args:
        scenario: checked, as `load_scenario` returns it.
        decomposer: makes a block to use instead of the scenario's decomposer.
        progress: told the time simulated so far [s], now and then.
    """
    make = decomposer or (lambda: None)
    diagram = make_diagram(scenario, decomposer=make())
    simulator = Simulator(diagram)
    context = simulator.get_context()
    died, interrupted = "", False
    start = time.perf_counter()
    try:
        simulator.Initialize()
        for end in _chunk_ends(scenario.in_whole_steps()):
            simulator.AdvanceTo(end)
            check_finite(diagram, context)
            if progress:
                progress(end)
    except KeyboardInterrupt:
        died, interrupted = f"interrupted at t = {context.get_time():g} s", True
    except FAILURES as error:
        died = death(diagram, context, error)
    wall_time = time.perf_counter() - start
    log = read_log(diagram, context)
    died = death_by_log(log, died)
    log = until_not_finite(log)
    ticks = np.zeros(0) if died else _tick_times(scenario, make())
    return Run(scenario, log, wall_time, ticks, died, interrupted)


def _chunk_ends(scenario: AnyScenario) -> list[float]:
    """Returns times to advance to: whole periods, then the end [s]."""
    duration, period = scenario.duration, scenario.period
    ticks = range(_CHUNK, last_tick(duration, period), _CHUNK)
    return [*(k * period for k in ticks), at_tick(duration, period)]


def _tick_times(scenario: AnyScenario, decomposer: Any, most: int = 1000) -> np.ndarray:
    """Returns how long each of the first control ticks takes [s].

    A tick goes from reading the command, or where the hand is, to the joint and base
    commands. It is timed in a run of its own, without loggers, which would have had all
    signals evaluated before the clock starts.
    """
    scenario = scenario.in_whole_steps()
    diagram = make_diagram(scenario, decomposer=decomposer, logged=False)
    simulator = Simulator(diagram)
    simulator.Initialize()
    context = simulator.get_context()
    given, wanted = (
        [diagram.GetOutputPort(name) for name in names if diagram.HasOutputPort(name)]
        for names in (
            (f"source.{signals.EE_COMMAND}", signals.WORKSPACE, signals.P_BT),
            (signals.BASE_SENT, signals.ARM_VELOCITY_COMMAND),
        )
    )
    times = []
    for k in range(min(most, last_tick(scenario.duration, scenario.period))):
        simulator.AdvanceTo(k * scenario.period)
        for port in given:
            port.Eval(context)
        start = time.perf_counter()
        for port in wanted:
            port.Eval(context)
        times.append(time.perf_counter() - start)
    return np.array(times)
