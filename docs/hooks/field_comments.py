"""Fields of dataclasses on the API pages, with the comments of the source.

A Griffe extension. In the source a field's comment, with its unit, stands on its line,
and its reason above it.
"""

import re
from typing import Any

from griffe import Docstring, Extension

_COMMENT = re.compile(r"#\s*(?!noqa|type:)(.+)")


class FieldComments(Extension):
    """Lists the commented fields of each dataclass in its docstring."""

    def on_object(self, *, obj: Any, **_: Any) -> None:
        """Adds the list to one class."""
        if not obj.is_class or not any(
            "dataclass" in str(each.value) for each in obj.decorators
        ):
            return
        lines = obj.lines_collection[obj.filepath]
        fields = [
            f"    {name}: {comment}"
            for name, member in obj.members.items()
            if member.is_attribute
            and member.annotation is not None
            and "ClassVar" not in str(member.annotation)
            and (comment := _comment(lines, member.lineno - 1, member.endlineno - 1))
        ]
        if fields:
            docstring = obj.docstring or Docstring("", parent=obj, parser="google")
            lines = [docstring.value, "", "Args:", *fields]
            docstring.value = "\n".join(lines).strip()
            obj.docstring = docstring


def _comment(lines: list[str], first: int, last: int) -> str:
    """Returns the comment on a field's last line, then those right above it."""
    found = _COMMENT.search(lines[last])
    above: list[str] = []
    while lines[first - 1].strip().startswith("#"):
        first -= 1
        above.insert(0, lines[first].strip().lstrip("# "))
    text = " ".join(filter(None, [found[1].strip() if found else "", *above]))
    # Two brackets in a row, as of a range and its unit, would be a link.
    return text.replace("] [", "] &#91;")
