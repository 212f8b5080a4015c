"""Runs a scenario headless, and times its control tick."""

import dataclasses as dc
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator

from drake_mobman import signals
from drake_mobman.diagrams import make_diagram
from drake_mobman.parameters import ParameterError
from drake_mobman.scenario import AnyScenario
from drake_mobman.simulation.finite import (
    FAILURES,
    check_state_finite,
    death,
    died_at,
    not_finite,
    reason,
)
from drake_mobman.simulation.log import (
    Log,
    StoredLog,
    append_log,
    drained_log,
    first_not_finite,
    head,
)
from drake_mobman.simulation.size import check_room
from drake_mobman.ticks import at_tick, last_tick

_CHUNK = 10
"""Control periods between two looks at progress and at the state's finiteness."""

_DRAIN = 50
"""Chunks between two times that the log goes to disk, and all signals are looked at."""


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

    Raises:
        ParameterError: where a block cannot work with its parameters, or the log would
            not fit into memory.
    """
    check_room(scenario)
    run = simulated(scenario, decomposer=decomposer, progress=progress)
    if not run.died:
        run.tick_times = tick_times(scenario, decomposer)
    return run


def simulated(
    scenario: AnyScenario,
    *,
    decomposer: Callable[[], Any] | None = None,
    progress: Callable[[float], None] | None = None,
    stop: Callable[[], bool] = lambda: False,
    part: Path | None = None,
) -> Run:
    """Returns the same without times of control ticks, which cost a while of their own.

    Args:
        scenario: as in `simulate`.
        decomposer: the same.
        progress: the same.
        stop: asked now and then whether the user wants it to end.
        part: a new file for the log, which else is held in memory.

    Raises:
        ParameterError: where a block cannot work with its parameters.
    """
    start = time.perf_counter()
    died, interrupted, logged = "", False, _Logged(part)
    try:
        diagram = make_diagram(scenario, decomposer=decomposer and decomposer())
        simulator = logged.simulator = Simulator(diagram)
        start = time.perf_counter()  # To build is not to simulate.
        simulator.Initialize()
        for i, end in enumerate(_chunk_ends(scenario.in_whole_steps()), 1):
            if stop():
                raise KeyboardInterrupt
            simulator.AdvanceTo(end)
            check_state_finite(diagram, simulator.get_context())
            if i % _DRAIN == 0:
                logged.drain()
            if progress:
                progress(end)
    except ParameterError:
        raise
    except KeyboardInterrupt:
        died, interrupted = f"interrupted at t = {logged.time():g} s", True
    except FAILURES as error:
        died = logged.death(error)
    wall_time = time.perf_counter() - start
    try:
        logged.drain()
    except Exception as error:
        died = died or died_at(logged.time(), reason(error))
    if not died.startswith(logged.died):
        died = logged.died
    return Run(scenario, logged.log(), wall_time, np.zeros(0), died, interrupted)


class _Logged:
    """What a simulator has logged: in memory, or in a file that grows with it."""

    def __init__(self, part: Path | None) -> None:
        self.simulator: Any = None
        self._part = part
        self._pieces: list[Log] = []
        self._complete = False  # Whether nothing may come after what there is.
        self.died = ""  # When and why that is so: a signal was not finite.

    def time(self) -> float:
        """Returns how far the simulator has come [s]."""
        return self.simulator.get_context().get_time() if self.simulator else 0.0

    def death(self, error: BaseException) -> str:
        """Returns when and why an error ended it, in one line."""
        if not self.simulator:
            return died_at(0.0, reason(error))
        return death(self.simulator.get_system(), self.simulator.get_context(), error)

    def drain(self) -> None:
        """Takes what has been logged since the last call from the simulator.

        Raises:
            ArithmeticError: where that is not finite; what came before is kept.
            OSError: where it cannot be written.
        """
        if self._complete or not self.simulator:
            return
        self._complete = True  # Unless all of it gets there.
        log = drained_log(self.simulator.get_system(), self.simulator.get_context())
        found = first_not_finite(log)
        finite = head(log, found[0] if found else len(log["time"]))
        if self._part:
            with self._part.open("ab") as file:
                append_log(file, finite)
        else:
            self._pieces.append(finite)
        if found:
            why = not_finite(found[1])
            self.died = died_at(log["time"][found[0]], why)
            raise ArithmeticError(why)
        self._complete = False

    def log(self) -> Log:
        """Returns all of it."""
        if self._part and self._part.exists():
            return StoredLog(self._part)
        if not self._pieces:
            return {"time": np.zeros(0)}
        names = self._pieces[0]
        return {name: np.concatenate([x[name] for x in self._pieces]) for name in names}


def _chunk_ends(scenario: AnyScenario) -> Iterator[float]:
    """Yields times to advance to: whole periods, then the end [s]."""
    duration, period = scenario.duration, scenario.period
    for k in range(_CHUNK, last_tick(duration, period), _CHUNK):
        yield k * period
    yield at_tick(duration, period)


def tick_times(
    scenario: AnyScenario,
    decomposer: Callable[[], Any] | None = None,
    *,
    most: int = 1000,
) -> np.ndarray:
    """Returns how long each of the first control ticks takes [s].

    A tick goes from reading the command, or where the hand is, to the joint and base
    commands. It is timed in a run of its own, without loggers, which would have had all
    signals evaluated before the clock starts.

    Args:
        scenario: as in `simulate`.
        decomposer: the same.
        most: how many ticks to time.
    """
    scenario = scenario.in_whole_steps()
    block = decomposer and decomposer()
    diagram = make_diagram(scenario, decomposer=block, logged=False)
    simulator = Simulator(diagram)
    simulator.Initialize()
    context = simulator.get_context()
    given, wanted = (
        [diagram.GetOutputPort(name) for name in names if diagram.HasOutputPort(name)]
        for names in (
            (f"source.{signals.EE_COMMAND}", signals.EE_CYLINDRICAL, signals.P_BT),
            (signals.BASE_COMMAND_SMOOTHED, signals.ARM_VELOCITY_COMMAND),
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
