"""A study: rows of runs that differ in one thing, such as the robot or a fault."""

import dataclasses as dc
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from drake_mobman.analysis.metrics import metrics
from drake_mobman.scenario import AnyScenario
from drake_mobman.simulation.run import Run
from drake_mobman.simulation.run_folder import finite

Results = Mapping[str, Mapping[str, Any]]
"""Metrics, as `metrics` returns them, by the name of a run of one row."""


@dc.dataclass(frozen=True)
class Column:
    """A number of each row, worked out from the metrics of its runs."""

    name: str
    unit: str  # Empty for a number without one.
    of: Callable[[Results], float | None]  # None where a run has no such number.


class Study(Protocol):
    """What is compared, and in which numbers."""

    @property
    def name(self) -> str:
        """Returns its name on the command line, `--over NAME`."""

    @property
    def help(self) -> str:
        """Returns a line on what it shows."""

    @property
    def own(self) -> bool:
        """Returns whether it brings its scenarios; else it is over a given one."""

    @property
    def columns(self) -> tuple[Column, ...]:
        """Returns the columns of its table."""

    def rows(self, scenario: AnyScenario | None) -> dict[str, dict[str, AnyScenario]]:
        """Returns the scenarios of each row, by the names of row and run.

        Args:
            scenario: the given one; None for a study of its own.

        Raises:
            ScenarioError: where it cannot be studied.
        """


@dc.dataclass
class Studied:
    """A study's runs."""

    study: Study
    results: dict[str, dict[str, dict[str, Any]]]  # Metrics by row and run.

    def numbers(self) -> dict[str, dict[str, float | None]]:
        """Returns the number of each row and column."""
        return {
            row: {column.name: column.of(of_row) for column in self.study.columns}
            for row, of_row in self.results.items()
        }


def studied(
    study: Study,
    rows: Mapping[str, Mapping[str, AnyScenario]],
    simulated: Callable[[str, AnyScenario], Run],
    stop: Callable[[], bool] = lambda: False,
) -> Studied:
    """Returns the metrics of all runs of a study, or of those until the user stops.

    Args:
        study: what is compared.
        rows: as its `rows` returns them.
        simulated: runs a scenario, given a name for it.
        stop: called before each run; returns whether the user wants to stop.
    """
    done = Studied(study, {})
    for row, scenarios in rows.items():
        for name, scenario in scenarios.items():
            if stop():
                return done
            run = simulated(f"{row}, {name}", scenario)
            if run.interrupted:
                return done
            done.results.setdefault(row, {})[name] = finite(metrics(run))
    return done


def metric(run: str, name: str, scale: float = 1.0) -> Callable[[Results], Any]:
    """Returns what takes a metric of one of a row's runs.

    Args:
        run: its name.
        name: of the metric.
        scale: that it is multiplied by.
    """

    def taken(results: Results) -> float | None:
        value = results.get(run, {}).get(name)
        return None if value is None else scale * value

    return taken


def error(run: str) -> Callable[[Results], Any]:
    """Returns what takes the rms error of E's velocity in a row's run [mm/s]."""
    return metric(run, "ee_error_rms", 1e3)


def ratio(a: Callable[[Results], Any], b: Callable[[Results], Any]) -> Any:
    """Returns what divides one number of a row by another."""

    def divided(results: Results) -> float | None:
        top, bottom = a(results), b(results)
        return top / bottom if top is not None and bottom else None

    return divided
