"""Docstrings as the API pages show them: a block's ports as a list.

A Griffe extension. In the source they stand as Drake writes them, under
`.. pydrake_system::`.
"""

import re
from typing import Any

from griffe import Extension

_SYSTEM = re.compile(r"\.\. pydrake_system::\n\n((?:[ \t]+.*\n?|\n)+)")


class Ports(Extension):
    """Rewrites each docstring for Markdown."""

    def on_object(self, *, obj: Any, **_: Any) -> None:
        """Rewrites one docstring."""
        if obj.docstring:
            text = _SYSTEM.sub(_listed, obj.docstring.value)
            text = re.sub(r"(?<=\n)::\n", "", text)
            # Two brackets in a row, as of a range and its unit, would be a link.
            obj.docstring.value = re.sub(r"\] \[", "] &#91;", text)


def _listed(found: re.Match[str]) -> str:
    """Returns the ports of a system as Markdown."""
    parts: list[str] = []
    for line in map(str.strip, found[1].splitlines()):
        if line.endswith("_ports:"):
            parts += ["", f"**{line[:-7].capitalize()} ports**", ""]
        elif line.startswith("- "):
            name, _, note = line[2:].partition(" ")
            parts.append(f"- `{name}` {note}".rstrip())
        elif parts and line and not line.startswith("name:"):
            parts[-1] += f" {line}"
    return "\n".join(parts).strip("\n") + "\n\n"
