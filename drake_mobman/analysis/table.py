"""Metrics of one or several runs as a table: rows in groups, with units."""

import dataclasses as dc
from collections.abc import Iterator, Mapping
from typing import Any

from drake_mobman.analysis.metrics import METRICS

_UNITS = {name: unit for metric in METRICS for name, unit in metric.units.items()}
_GROUPS = {name: metric.group for metric in METRICS for name in metric.units}
_OTHER = "other"


@dc.dataclass(frozen=True)
class Row:
    """A metric of each run."""

    label: str  # The metric's flat name.
    unit: str  # Empty for a number without one.
    values: dict[str, Any]  # By column; None where a run has no value.


@dc.dataclass(frozen=True)
class Group:
    """Metrics of one part of the robot."""

    title: str
    rows: list[Row]


def table_of(results: Mapping[str, Mapping[str, Any]]) -> list[Group]:
    """Returns metrics in groups; a row without a value in any column is left out.

    Args:
        results: what `metrics` returns, by column: the name of a run or a decomposer.
    """
    groups: dict[str, list[Row]] = {title: [] for title in _GROUPS.values()}
    for label, values in flat_table(results).items():
        if any(value is not None for value in values.values()):
            title = "run" if label == "died" else _GROUPS.get(label, _OTHER)
            row = Row(label, _UNITS.get(label, ""), values)
            groups.setdefault(title, []).append(row)
    return [Group(title, rows) for title, rows in groups.items() if rows]


def flat_table(results: Mapping[str, Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Returns each metric's value in every column, by the metric's flat name.

    Metrics without a value in any column are left out, except `died`, and so are the
    versions.

    Args:
        results: as in `table_of`.
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


def shown(value: Any) -> str:
    """Returns a metric's value as text for a table."""
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _flat(numbers: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in numbers.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value
