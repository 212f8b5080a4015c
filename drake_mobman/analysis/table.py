"""Metrics as a table: rows with units, in groups by what they are of."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from drake_mobman.analysis.compare import UNITS, shown
from drake_mobman.analysis.compare import table_of as flat_table_of

__all__ = ["Group", "Row", "shown", "table_of"]

_GROUPS = {
    "end effector": ("ee_", "workspace_", "authority_", "commands_"),
    "base": ("base_", "lateral_"),
    "arm": ("joint_", "manipulability_"),
    "hand": ("hand_",),
    "time": ("step_time_us", "real_time_factor"),
    "end": ("died",),
}


class Row(NamedTuple):
    """A metric's values."""

    label: str
    unit: str  # Empty for a plain number.
    values: dict[str, Any]  # By column; None where a column has none.


class Group(NamedTuple):
    """Rows of metrics that are of one thing."""

    title: str
    rows: list[Row]


def table_of(results: Mapping[str, dict[str, Any]]) -> list[Group]:
    """Returns metrics in groups; a metric that no column has is left out.

    Args:
        results: what `metrics` returns, by column.
    """
    flat = flat_table_of(results)
    groups = []
    for title, prefixes in _GROUPS.items():
        rows = [
            Row(key, "us" if "_us" in key else UNITS.get(key, ""), values)
            for key, values in flat.items()
            if key.startswith(prefixes)
            and any(value is not None for value in values.values())
        ]
        if rows:
            groups.append(Group(title, rows))
    return groups
