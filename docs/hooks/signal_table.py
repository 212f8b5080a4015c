"""The table of signals, made from `drake_mobman/signals.py`."""

import ast
import itertools
from pathlib import Path
from typing import Any

MARK = "<!-- signals -->"
"""In the page, where the table goes."""

SOURCE = Path(__file__).parent.parent.parent / "drake_mobman" / "signals.py"


def on_page_markdown(text: str, **_: Any) -> str:
    """Returns a page's text with the table in its place."""
    return text.replace(MARK, table()) if MARK in text else text


def table() -> str:
    """Returns a row for each signal: its name, size, and what it holds."""
    lines = ["| signal | size | what it holds |", "|---|---|---|"]
    body = ast.parse(SOURCE.read_text()).body
    for name, said in itertools.pairwise(body):
        if isinstance(name, ast.Assign) and isinstance(said, ast.Expr):
            text = " ".join(ast.literal_eval(said.value).split())
            size, colon, content = text.partition(":")
            if not colon or len(size) > 9:
                size, content = "", text
            signal = ast.literal_eval(name.value)
            lines.append(f"| `{signal}` | {size} | {content.strip()} |")
    return "\n".join(lines)
