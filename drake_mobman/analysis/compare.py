"""Decomposers side by side: a scenario run with each, in one table and one figure."""

import dataclasses as dc
import json
import typing
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from drake_mobman.analysis.metrics import metrics
from drake_mobman.figures.comparison import draw_comparison
from drake_mobman.parameters import ParameterError, checked
from drake_mobman.robots.defaults import default_of
from drake_mobman.scenario import AnyScenario, ScenarioError, Teleop
from drake_mobman.scenario.schema import dump_typed
from drake_mobman.simulation.log import head
from drake_mobman.simulation.output_folder import OutputFolder
from drake_mobman.simulation.run_folder import PICTURED, finite, png
from drake_mobman.simulation.simulate import Run, simulate

UNITS = {
    "ee_error_rms": "m/s",
    "ee_error_max": "m/s",
    "ee_drift_max": "m",
    "workspace_excess_max.l": "m",
    "workspace_excess_max.psi": "rad",
    "base_speed_max": "m/s",
    "base_yaw_rate_max": "rad/s",
    "joint_speed_max": "rad/s",
    "base_jerk_rms": "m/s^3",
    "lateral_slip_max": "m/s",
    "joint_margin_min": "rad",
    "hand_force_max": "N",
    "hand_error_max": "m",
}
"""Of metrics whose name does not tell; the others are numbers without one."""


def decomposers_by_name() -> dict[str, type]:
    """Returns the parameters' class of each decomposer, by its bare name."""
    union = typing.get_type_hints(Teleop)["decomposer"]
    return {member.__name__.lower(): member for member in typing.get_args(union)}


def chosen_decomposers(names: Sequence[str]) -> dict[str, type]:
    """Returns those of `decomposers_by_name` that are asked for, in that order.

    Args:
        names: bare ones in any case, as a scenario takes them.

    Raises:
        ParameterError: where a name is none, or comes twice.
    """
    known = decomposers_by_name()
    chosen: dict[str, type] = {}
    for given in names:
        name = given.strip().lstrip("!").lower()
        if name not in known:
            valid = f"must be one of {', '.join(known)}"
            raise ParameterError("--decomposers", given, valid)
        if name in chosen:
            raise ParameterError("--decomposers", given, "must be given once")
        chosen[name] = known[name]
    return chosen


def with_each(
    scenario: AnyScenario, decomposers: Mapping[str, type]
) -> dict[str, Teleop]:
    """Returns the scenario with each of the decomposers, by name.

    The one that it names itself keeps its parameters; the others fit the robot, but for
    how sharply authority passes, which goes by the size of the workspace.

    Raises:
        ScenarioError: where nobody commands the hand, or where a decomposer does not
            work with the rest of the scenario.
    """
    if not isinstance(scenario, Teleop):
        tag = type(scenario).__name__
        raise ScenarioError(f"!{tag} has no command to decompose; must be !Teleop")
    variants = {}
    for name, kind in decomposers.items():
        try:
            params = _like(scenario.decomposer, default_of(scenario.robot, kind))
            # A recorded operator has no other to choose.
            variant = dc.replace(scenario, decomposer=params, alternatives=[])
            checked(variant)
        except ParameterError as error:
            raise ScenarioError(f"with decomposer={name}: {error}") from None
        variants[name] = variant
    return variants


def _like(own: Any, other: Any) -> Any:
    """Returns `own` if it is of the other's kind, else the other, as sharp as it."""
    if isinstance(own, type(other)):
        return own
    sharpness = {"alpha", "beta"} & {f.name for f in dc.fields(other)}
    same = {key: getattr(own, key) for key in sharpness if hasattr(own, key)}
    return dc.replace(other, **same)


@dc.dataclass
class Comparison:
    """A scenario's runs with several decomposers."""

    scenario: Teleop  # As it was given, with its own decomposer.
    runs: dict[str, Run]  # By the decomposer's name.
    metrics: dict[str, dict[str, Any]]  # The same; None for what is not finite.

    def table(self) -> dict[str, dict[str, Any]]:
        """Returns the metrics' values by decomposer, by the metric's flat name."""
        return table_of(self.metrics)


def compared(
    scenario: AnyScenario,
    decomposers: Mapping[str, type],
    simulated: Callable[[str, Teleop], Run] = lambda _, variant: simulate(variant),
    stop: Callable[[], bool] = lambda: False,
) -> Comparison:
    """Returns the runs of a scenario with each of the decomposers.

    Args:
        scenario: checked, as `load_scenario` returns it.
        decomposers: some of `decomposers_by_name`.
        simulated: runs a variant of the scenario, given its decomposer's name.
        stop: asked before each run whether those so far are enough.

    Raises:
        ScenarioError: as `with_each`.
        KeyboardInterrupt: where the user ended it before there was anything.
    """
    runs: dict[str, Run] = {}
    for name, variant in with_each(scenario, decomposers).items():
        if stop():
            break
        runs[name] = simulated(name, variant)
        if runs[name].interrupted:
            break
    logged = any(len(run.log["time"]) for run in runs.values())
    if not logged and (stop() or any(run.interrupted for run in runs.values())):
        raise KeyboardInterrupt
    numbers = {name: finite(metrics(run)) for name, run in runs.items()}
    return Comparison(typing.cast(Teleop, scenario), runs, numbers)


def write_comparison(comparison: Comparison, title: str, folder: OutputFolder) -> None:
    """Writes the scenario, and the table as Markdown and JSON, to `folder`.

    Raises:
        OSError: where something could not be written; then all is as it was.
    """
    params = {
        name: dc.asdict(run.scenario.decomposer)  # type: ignore[union-attr]
        for name, run in comparison.runs.items()
    }
    content = {
        "scenario": title,
        "versions": _versions(comparison),
        "decomposers": params,
        "metrics": comparison.table(),
    }
    files = {
        "scenario.yaml": dump_typed(comparison.scenario),
        "comparison.md": _page(comparison, title),
        "comparison.json": json.dumps(content, indent=2, allow_nan=False) + "\n",
    }
    for name, text in files.items():
        # A file's name need not be UTF-8, and a title may be one.
        folder.file(name).write_bytes(text.encode("utf-8", "backslashreplace"))
    folder.publish([*files], anew=True)


def draw(comparison: Comparison) -> bytes:
    """Returns the figure, as a file's content."""
    shown = {
        name: dc.replace(run, log=head(run.log, PICTURED))
        for name, run in comparison.runs.items()
    }
    return png(draw_comparison(shown))


def _page(comparison: Comparison, title: str) -> str:
    """Returns what the comparison says, as a page of Markdown."""
    table = comparison.table()
    rows = [
        [f"{key} [{UNITS[key]}]" if key in UNITS else key, *map(shown, row.values())]
        for key, row in table.items()
    ]
    heading = ["metric", *comparison.runs]
    versions = _versions(comparison)
    ran_on = ", ".join(f"{name} {number}" for name, number in versions.items())
    return (
        f"# {title}\n\n{comparison.scenario.description}\n\n"
        f"{markdown_table(heading, rows)}\n\n{ran_on}\n\n"
        "![Velocities of base and arm, and time of a tick](comparison.png)\n"
    )


def _versions(comparison: Comparison) -> dict[str, str]:
    return next(iter(comparison.metrics.values()))["versions"]


def table_of(results: Mapping[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """Returns metrics as rows: a metric's value in each column, by its flat name.

    What no column has is left out; but for `died`, for it is good to know.

    Args:
        results: what `metrics` returns, by column.
    """
    flat = {column: dict(_flat(numbers)) for column, numbers in results.items()}
    keys = dict.fromkeys(key for numbers in flat.values() for key in numbers)
    rows = {key: {name: flat[name].get(key) for name in flat} for key in keys}
    return {
        key: row
        for key, row in rows.items()
        if not key.startswith("versions")
        and (key == "died" or any(value is not None for value in row.values()))
    }


def _flat(numbers: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in numbers.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def shown(value: Any) -> str:
    """Returns a metric's value as a table shows it."""
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def markdown_table(heading: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Returns a table of Markdown, its first column to the left, numbers to the right.

    Columns are as wide as they need to be, so that it reads well as it is, too.
    """
    cells = [[text.replace("|", r"\|") for text in row] for row in (heading, *rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
    return "\n".join(
        "| "
        + " | ".join(
            text.rjust(width) if i else text.ljust(width)
            for i, (text, width) in enumerate(zip(row, widths, strict=True))
        )
        + " |"
        for row in (cells[0], rule, *cells[1:])
    )
