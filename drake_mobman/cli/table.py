"""The metrics of runs as tables that fit into the terminal."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from drake_mobman.cli.messages import console
from drake_mobman.terminal import visible

if TYPE_CHECKING:
    from rich.table import Table

_VALUE = 9
"""Width of a number such as 1.234e-05 [characters]."""

_GAP = 3
"""Between two columns [characters]."""

_INDENT = "  "

Results = Mapping[str, dict[str, Any]]
"""Metrics as `metrics` returns them, by scenario or decomposer: a column each."""


def print_metrics(results: Results, title: str | None = None) -> None:
    """Prints metrics with their units, in groups.

    In as many tables as it takes, so that none is wider than the terminal.
    """
    from drake_mobman.analysis.table import table_of

    rows = [row for group in table_of(results) for row in group.rows]
    label = max((len(_INDENT + row.label) for row in rows), default=0)
    unit = max((len(row.unit) for row in rows), default=0)
    room = console.width - label - unit - 2 * _GAP
    for i, names in enumerate(_fitting(list(results), room)):
        if i:
            console.print()
        console.print(_table({name: results[name] for name in names}, title))


def _fitting(names: Sequence[str], room: int) -> Iterator[list[str]]:
    """Yields the names of columns, as many at a time as there is room for."""
    chosen: list[str] = []
    used = 0
    for name in names:
        column = max(len(visible(name)), _VALUE) + _GAP
        if chosen and used + column - _GAP > room:
            yield chosen
            chosen, used = [], 0
        chosen.append(name)
        used += column
    yield chosen


def _table(results: Results, title: str | None) -> "Table":
    from rich import box
    from rich.table import Table
    from rich.text import Text

    from drake_mobman.analysis.table import shown, table_of

    table = Table(
        title=title and visible(title),
        title_justify="left",
        box=box.SIMPLE_HEAD,
        show_edge=False,
        pad_edge=False,
    )
    table.add_column("metric")
    for name in results:
        table.add_column(visible(name), justify="right")
    table.add_column("unit", style="dim")
    for group in table_of(results):
        table.add_section()
        table.add_row(Text(group.title, style="bold"))
        for row in group.rows:
            values = (visible(shown(row.values.get(name))) for name in results)
            table.add_row(_INDENT + row.label, *values, row.unit)
    return table
