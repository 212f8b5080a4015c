"""A study in several engines: each of its columns, engine by engine."""

import dataclasses as dc
from collections.abc import Callable

from drake_mobman.analysis.compare import in_each
from drake_mobman.analysis.studies.study import Column, Results, Study
from drake_mobman.scenario import AnyScenario, ScenarioError


@dc.dataclass(frozen=True)
class InEngines:
    """A study whose runs are each made in each engine.

    Runs and columns have the engine's name behind their own, as in `exact, mujoco`.
    """

    study: Study
    engines: dict[str, type]  # As `chosen_engines` returns them.

    @property
    def name(self) -> str:
        """Returns the study's name."""
        return self.study.name

    @property
    def help(self) -> str:
        """Returns what the study shows, and in what."""
        return f"{self.study.help}; in {', '.join(self.engines)}"

    @property
    def own(self) -> bool:
        """Returns whether the study brings its scenarios."""
        return self.study.own

    @property
    def columns(self) -> tuple[Column, ...]:
        """Returns each of the study's columns in each engine, next to each other."""
        return tuple(
            Column(f"{column.name}, {engine}", column.unit, _seen_in(engine, column))
            for column in self.study.columns
            for engine in self.engines
        )

    def rows(self, scenario: AnyScenario | None) -> dict[str, dict[str, AnyScenario]]:
        """Returns the study's scenarios of each row in each engine.

        Raises:
            ScenarioError: where one cannot be studied in an engine.
        """
        rows = {}
        for row, scenarios in self.study.rows(scenario).items():
            try:
                rows[row] = in_each(scenarios, self.engines)
            except ScenarioError as error:
                raise ScenarioError(f"{row}: {error}") from None
        return rows


def _seen_in(engine: str, column: Column) -> Callable[[Results], float | None]:
    """Returns a column's number from the runs in one engine alone."""
    ending = f", {engine}"

    def seen(results: Results) -> float | None:
        return column.of(
            {
                run.removesuffix(ending): numbers
                for run, numbers in results.items()
                if run.endswith(ending)
            }
        )

    return seen
