"""The folder of a study: its table as Markdown, and all numbers as JSON."""

import json
from typing import Any

from drake_mobman.analysis.markdown import markdown_table
from drake_mobman.analysis.studies import Studied
from drake_mobman.analysis.table import shown
from drake_mobman.simulation.output_folder import OutputFolder

PAGE, NUMBERS = "study.md", "study.json"

STUDY = (PAGE, NUMBERS)
"""Files that a study may replace."""


def write_study(done: Studied, title: str, folder: OutputFolder) -> None:
    """Writes a study's table, and the metrics of all its runs, to `folder`.

    Raises:
        OSError: where something could not be written; then the folder is unchanged.
    """
    content: dict[str, Any] = {
        "study": done.study.name,
        "table": done.numbers(),
        "metrics": done.results,
    }
    page = f"# {title}\n\n{done.study.help.capitalize()}.\n\n{study_table(done)}\n"
    folder.file(PAGE).write_text(page, "utf-8")
    text = json.dumps(content, indent=2, allow_nan=False)
    folder.file(NUMBERS).write_text(text + "\n", "utf-8")
    folder.publish([PAGE, NUMBERS], anew=True)


def study_table(done: Studied) -> str:
    """Returns a study's table as Markdown."""
    columns = done.study.columns
    heading = [f"{c.name} [{c.unit}]" if c.unit else c.name for c in columns]
    rows = [
        [row, *map(shown, numbers.values())] for row, numbers in done.numbers().items()
    ]
    return markdown_table([done.study.name, *heading], rows)
