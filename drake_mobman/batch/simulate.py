"""Runs of many scenarios, each law made once and stepped as machine code."""

import dataclasses as dc
import os
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import islice
from typing import Any

import numpy as np

from drake_mobman import signals
from drake_mobman.batch.lanes import Lane
from drake_mobman.diagrams import make_diagram
from drake_mobman.robot_model import RobotSetup
from drake_mobman.scenario import AnyScenario, ScenarioError, Teleop
from drake_mobman.schema import dump_yaml, plain
from drake_mobman.simulation.finite import died_at, not_finite
from drake_mobman.simulation.log import Log, first_not_finite, head
from drake_mobman.simulation.run import Run
from drake_mobman.step_law import StepLaw, StepLawError, step_law
from drake_mobman.teleop.external import External
from drake_mobman.teleop.scripted import script_trajectory
from drake_mobman.ticks import last_tick

_ROBOT = "robot/kinematic"
"""Path of the block whose state is where the robot is."""

_AHEAD = 4
"""Runs for each thread that wait to be taken: more would only need memory."""


def simulated_batch(
    scenarios: Iterable[AnyScenario], threads: int | None = None
) -> Iterator[Run]:
    """Yields the run of each scenario, in their order.

    Scenarios that differ only in source, start and duration are one law. A run has the
    signals that Drake's simulator would log, to rounding.

    Args:
        scenarios: checked, as `load_scenario` returns them.
        threads: that step runs side by side; as many as there are cores unless given.

    Raises:
        ScenarioError: where a scenario is no such law; the message says why.
    """
    threads = threads or os.cpu_count() or 1
    loops: dict[str, _Loop] = {}
    pending: list[Future[Run]] = []
    rest = iter(scenarios)
    with ThreadPoolExecutor(threads) as pool:
        try:
            while True:
                for scenario in islice(rest, threads * _AHEAD - len(pending)):
                    loop = _loop_of(scenario, loops)
                    pending.append(pool.submit(loop.run, scenario))
                if not pending:
                    return
                yield pending.pop(0).result()
        finally:
            for future in pending:
                future.cancel()


def check_batch(scenario: AnyScenario) -> None:
    """Raises `ScenarioError` where a scenario cannot be run in a batch."""
    why = _why_not(scenario)
    if why:
        raise ScenarioError(f"cannot be run in a batch: {why}")


def _why_not(scenario: AnyScenario) -> str:
    if not isinstance(scenario, Teleop):
        return f"!{type(scenario).__name__} is pulled by hand; it takes !Teleop"
    source, fidelity = scenario.source, scenario.fidelity
    if not hasattr(source, "script"):
        return f"source !{type(source).__name__} has no script"
    if fidelity.has_masses:
        return f"fidelity !{type(fidelity).__name__} has masses; it takes !Kinematic"
    return ""


def _loop_of(scenario: AnyScenario, loops: dict[str, "_Loop"]) -> "_Loop":
    """Returns the loop of a scenario, made where none is like it."""
    check_batch(scenario)
    teleop: Any = scenario
    alike = dc.replace(
        teleop, source=External(), duration=1.0, description="", compiled=False
    )
    data = plain(alike, type(alike))
    key = dump_yaml({name: x for name, x in data.items() if name != "start"})
    if key not in loops:
        loops[key] = _Loop(alike)
    return loops[key]


class _Loop:
    """The law of a scenario's loop, for any commands and any start."""

    def __init__(self, scenario: Any) -> None:
        self._setup: RobotSetup = scenario.setup()
        diagram = make_diagram(scenario, self._setup, logged=False)
        try:
            self._law: StepLaw = step_law(diagram)
        except StepLawError as error:
            raise ScenarioError(f"cannot be run in a batch: {error}") from None
        self._lane = Lane(self._law)

    def run(self, scenario: Any) -> Run:
        """Returns the run of a scenario."""
        began = time.perf_counter()
        period = scenario.period
        times = period * np.arange(last_tick(scenario.duration, period) + 1)
        script = script_trajectory(scenario.source.script(), period)
        commands = script.vector_values(times).T
        numbers = self._lane.run(self._start(scenario), commands)
        died, log = self._finite(times, commands, numbers)
        wall_time = time.perf_counter() - began
        return Run(scenario, log, wall_time, died=died, built_with=self._setup)

    def _start(self, scenario: Any) -> np.ndarray:
        """Returns the state before the start, with the robot at the scenario's."""
        start, place = np.array(self._law.start), 0
        for part in self._law.state:
            if part.name == _ROBOT:
                at = scenario.start_position(self._setup)
                start[place : place + part.size] = at
            place += part.size
        return start

    def _finite(
        self, times: np.ndarray, commands: np.ndarray, numbers: np.ndarray
    ) -> tuple[str, Log]:
        """Returns why the run died, if it did, and its log up to there."""
        sizes = [x.size for x in self._law.outputs]
        parts = np.split(numbers, np.cumsum(sizes)[:-1], axis=1)
        named = {x.name: y for x, y in zip(self._law.outputs, parts, strict=True)}
        log = {
            "time": times,
            **named,
            f"source.{signals.EE_COMMAND}": np.ascontiguousarray(commands),
        }
        found = first_not_finite(log)
        if not found:
            return "", log
        row, name = found
        return died_at(float(times[row]), not_finite(name)), head(log, row)
