"""A robot file as text: what it holds, and beside each key where that is from."""

import dataclasses as dc
import textwrap
from collections.abc import Iterator, Mapping
from typing import Any

from drake_mobman.robots.file.contents import RobotFile
from drake_mobman.schema import dump_yaml, plain

_WIDTH = 88
"""Of lines [characters]; a comment that does not fit goes above its line."""

_NESTED = {"base", "arm", "parts"}
"""Keys whose own keys have a line each."""


def written(contents: RobotFile, why: Mapping[str, str], title: str) -> str:
    """Returns a robot file as YAML, without what is as in any robot file.

    Args:
        contents: of the file.
        why: where a value is from, by its key.
        title: text for the top.
    """
    top = [f"# {line}" for line in textwrap.wrap(title, _WIDTH - 2)]
    return "\n".join([*top, *_lines(contents, RobotFile(), why, "", "")]) + "\n"


def _lines(
    obj: Any, usual: Any, why: Mapping[str, str], path: str, indent: str
) -> Iterator[str]:
    """Yields the lines of a dataclass."""
    for field in dc.fields(obj):
        key, value = f"{path}{field.name}", getattr(obj, field.name)
        if value == getattr(usual, field.name) and key not in why:
            continue
        if field.name in _NESTED and not isinstance(value, list):
            yield from _commented(f"{indent}{field.name}:", why.get(key), indent)
            yield from _lines(value, type(value)(), why, f"{key}.", f"{indent}  ")
        elif field.name in _NESTED:
            yield f"{indent}{field.name}:"
            for item in value:
                first, *rest = _lines(item, type(item)(), {}, "", "")
                yield f"{indent}  - {first}"
                yield from (f"{indent}    {line}" for line in rest)
        else:
            text = f"{indent}{field.name}: {_flow(plain(value, field.type))}"
            yield from _commented(text, why.get(key), indent)


def _commented(line: str, comment: str | None, indent: str) -> Iterator[str]:
    """Yields a line with its comment, if any, behind or above."""
    if not comment:
        yield line
    elif len(f"{line}  # {comment}") <= _WIDTH:
        yield f"{line}  # {comment}"
    else:
        yield from (f"{indent}# {part}" for part in textwrap.wrap(comment, _WIDTH - 6))
        yield line


def _flow(data: Any) -> str:
    """Returns data as YAML on one line."""
    if isinstance(data, dict):
        pairs = (f"{key}: {_flow(x)}" for key, x in data.items() if x is not None)
        return f"{{{', '.join(pairs)}}}"
    if isinstance(data, list):
        return f"[{', '.join(map(_flow, data))}]"
    return dump_yaml(data).removesuffix("...\n").strip()
