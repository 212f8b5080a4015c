"""Simulates a scenario as fast as the computer can, without a window."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator

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
from drake_mobman.simulation.run import Run
from drake_mobman.simulation.size import check_room
from drake_mobman.ticks import at_tick, last_tick

__all__ = ["Run", "simulate"]

_CHUNK = 10
"""Control periods after which progress is shown and the state checked."""

_DRAIN = 50
"""Chunks after which the log goes to disk, and all signals are checked."""


def simulate(
    scenario: AnyScenario,
    *,
    decomposer: Callable[[], Any] | None = None,
    progress: Callable[[float], None] | None = None,
    stop: Callable[[], bool] = lambda: False,
    part: Path | None = None,
) -> Run:
    """Returns the run of a scenario from its start to its end, or to where it died.

    Args:
        scenario: checked, as `load_scenario` returns it.
        decomposer: makes a block to use instead of the scenario's decomposer.
        progress: called from time to time with the time simulated so far [s].
        stop: called from time to time; returns whether the user wants to end the run.
        part: a new file for the log, which is otherwise kept in memory.

    Raises:
        ParameterError: where a block cannot work with its parameters, or there is no
            room for the log.
    """
    check_room(scenario, part)
    start = time.perf_counter()
    died, interrupted, setup, logged = "", False, None, _Logged(part)
    try:
        whole = scenario.in_whole_steps()
        setup = whole.setup()
        block = decomposer and decomposer()
        diagram = make_diagram(scenario, setup, decomposer=block)
        logged.simulator = Simulator(diagram)
        start = time.perf_counter()  # Building does not count.
        _advance(whole, logged, progress, stop)
    except ParameterError:
        raise
    except KeyboardInterrupt:
        died, interrupted = f"interrupted at t = {logged.time():g} s", True
    except FAILURES as error:
        died = logged.death(error)
    wall_time = time.perf_counter() - start
    died = logged.completed(died)
    return Run(
        scenario,
        logged.log(),
        wall_time,
        died=died,
        interrupted=interrupted,
        built_with=setup,
    )


def _advance(
    scenario: AnyScenario,
    logged: "_Logged",
    progress: Callable[[float], None] | None,
    stop: Callable[[], bool],
) -> None:
    """Advances the simulator to the end, unless the user ends it."""
    simulator = logged.simulator
    simulator.Initialize()
    for i, end in enumerate(_chunk_ends(scenario), 1):
        if stop():
            raise KeyboardInterrupt
        simulator.AdvanceTo(end)
        check_state_finite(simulator.get_system(), simulator.get_context())
        if i % _DRAIN == 0:
            logged.drain()
        if progress:
            progress(end)


class _Logged:
    """What a simulator has logged, in memory or in a growing file."""

    def __init__(self, part: Path | None) -> None:
        self.simulator: Any = None
        self._part = part
        self._pieces: list[Log] = []
        self._complete = False  # Whether nothing more may be added.
        self.died = ""  # When and why: a signal was not finite.

    def time(self) -> float:
        """Returns how far the simulator has come [s]."""
        return self.simulator.get_context().get_time() if self.simulator else 0.0

    def death(self, error: BaseException) -> str:
        """Returns when and why an error ended it, in one line."""
        if not self.simulator:
            return died_at(0.0, reason(error))
        return death(self.simulator.get_system(), self.simulator.get_context(), error)

    def drain(self) -> None:
        """Moves what was logged since the last call out of the simulator.

        Raises:
            ArithmeticError: where it is not finite; the log before that is kept.
            OSError: where it cannot be written.
        """
        if self._complete or not self.simulator:
            return
        self._complete = True  # Unless all of it is moved.
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

    def completed(self, died: str) -> str:
        """Drains the rest of the log; returns when and why the run died, if it did."""
        try:
            self.drain()
        except Exception as error:
            died = died or died_at(self.time(), reason(error))
        return died if died.startswith(self.died) else self.died

    def log(self) -> Log:
        """Returns the whole log."""
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
