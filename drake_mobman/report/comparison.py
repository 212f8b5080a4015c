"""The comparison folder: variants side by side, in a table and a figure."""

import dataclasses as dc
import json
from typing import Any

from drake_mobman.analysis.compare import Comparison
from drake_mobman.analysis.markdown import markdown_table
from drake_mobman.analysis.table import Group, shown, table_of
from drake_mobman.figures.comparison import draw_comparison
from drake_mobman.report.pictures import PICTURED, png
from drake_mobman.simulation.output_folder import OutputFolder
from drake_mobman.simulation.scenario_texts import SCENARIO_FILES, scenario_texts

PAGE, NUMBERS, PICTURE = "comparison.md", "comparison.json", "comparison.png"

COMPARISON = (*SCENARIO_FILES, PAGE, NUMBERS, PICTURE)
"""Files that a comparison may replace."""


def write_comparison(comparison: Comparison, title: str, folder: OutputFolder) -> None:
    """Writes the scenario, and the table as Markdown and JSON, to `folder`.

    Raises:
        OSError: where something could not be written; then the folder is unchanged.
    """
    content = {
        "scenario": title,
        "versions": _versions(comparison),
        "decomposers": _params(comparison, "decomposer"),
        "engines": _params(comparison, "engine"),
        "metrics": comparison.table(),
    }
    files = {
        **scenario_texts(comparison.scenario),
        PAGE: _page(comparison, title),
        NUMBERS: json.dumps(content, indent=2, allow_nan=False) + "\n",
    }
    for name, text in files.items():
        # The title may be a file's name, which need not be UTF-8.
        folder.file(name).write_bytes(text.encode("utf-8", "backslashreplace"))
    folder.publish([*files], anew=True)


def draw(comparison: Comparison) -> bytes:
    """Returns the figure as the content of a file."""
    runs = {name: run.first(PICTURED) for name, run in comparison.runs.items()}
    return png(draw_comparison(runs))


def _page(comparison: Comparison, title: str) -> str:
    """Returns the comparison as a page of Markdown."""
    parts = [f"# {title}", comparison.scenario.description]
    for group in table_of(comparison.metrics):
        parts += [f"## {group.title.capitalize()}", _table(group, [*comparison.runs])]
    versions = _versions(comparison)
    parts += [
        "![Velocities of base and arm, and time of a tick](comparison.png)",
        ", ".join(f"{name} {number}" for name, number in versions.items()),
    ]
    return "\n\n".join(parts) + "\n"


def _table(group: Group, columns: list[str]) -> str:
    rows = [
        [
            f"{row.label} [{row.unit}]" if row.unit else row.label,
            *(shown(row.values[column]) for column in columns),
        ]
        for row in group.rows
    ]
    return markdown_table(["metric", *columns], rows)


def _params(comparison: Comparison, key: str) -> dict[str, Any]:
    """Returns the kind and the parameters under a key of each run's scenario."""
    given = {
        name: getattr(run.scenario, key, None) for name, run in comparison.runs.items()
    }
    return {name: dc.asdict(params) for name, params in given.items() if params}


def _versions(comparison: Comparison) -> dict[str, str]:
    return next(iter(comparison.metrics.values()))["versions"]
