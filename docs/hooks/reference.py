"""References of scenarios and robot files, made from dataclasses and their comments.

A field's comment is the one on its line, with its unit; the lines above it give the
reason. Nothing is written down twice.
"""

import ast
import dataclasses as dc
import inspect
import re
import typing
from collections.abc import Iterator
from types import NoneType, UnionType
from typing import Any

from drake_mobman.robots.file.contents import RobotFile
from drake_mobman.scenario import AnyScenario
from drake_mobman.schema import NOT_IN_YAML

MARKS = {
    "<!-- scenarios reference -->": AnyScenario,
    "<!-- robot file reference -->": RobotFile,
}
"""In a page, where the reference of something goes."""


@dc.dataclass
class Field:
    """A field of a parameters dataclass, as the page shows it."""

    name: str
    type: str  # In Markdown, with links to what it is made of.
    default: str
    comment: str  # What it is, with its unit.
    reason: str  # Why it is so; may be empty.


def on_page_markdown(text: str, **_: Any) -> str:
    """Returns a page's text with the reference in its place."""
    for mark, root in MARKS.items():
        if mark in text:
            text = text.replace(mark, reference(root))
    return text


def reference(root: Any = AnyScenario) -> str:
    """Returns a section for each dataclass that something is made of."""
    tagged = root is AnyScenario
    return "\n\n".join(_section(owner, tagged) for owner in classes(root))


def classes(root: Any = AnyScenario) -> list[type]:
    """Returns every dataclass that something may hold, its own first."""
    found: list[type] = []
    waiting = list(_dataclasses(root))
    while waiting:
        each = waiting.pop(0)
        if each not in found:
            found.append(each)
            hints = typing.get_type_hints(each)
            waiting += [x for f in dc.fields(each) for x in _dataclasses(hints[f.name])]
    return found


def fields_of(owner: Any) -> list[Field]:
    """Returns the fields of a dataclass, with the comments of its source."""
    comments = {}
    for each in reversed(owner.__mro__):
        if dc.is_dataclass(each):
            comments |= _comments(each)
    hints = typing.get_type_hints(owner)
    return [
        Field(f.name, _type(hints[f.name]), _default(f), *comments[f.name])
        for f in dc.fields(owner)
        if f.metadata != NOT_IN_YAML
    ]


def _section(owner: type, tagged: bool) -> str:
    summary = (inspect.getdoc(owner) or "").strip()
    name = f"`!{owner.__name__}`" if tagged else f"`{owner.__name__}`"
    lines = [f"### {name} {{ #{_anchor(owner)} }}", "", summary, ""]
    fields = fields_of(owner)
    if fields:
        lines += ["| key | type | default | what it is |", "|---|---|---|---|"]
    for field in fields:
        what = " ".join(filter(None, (field.comment, field.reason)))
        row = f"`{field.name}`", field.type, field.default, what
        lines.append("| " + " | ".join(x.replace("|", "\\|") for x in row) + " |")
    return "\n".join(lines)


def _dataclasses(hint: Any) -> Iterator[type]:
    """Yields the dataclasses that a type is made of."""
    if dc.is_dataclass(hint):
        yield typing.cast(type, hint)
    for argument in typing.get_args(hint):
        yield from _dataclasses(argument)


def _type(hint: Any) -> str:
    if isinstance(hint, UnionType) or typing.get_origin(hint) is typing.Union:
        some = [each for each in typing.get_args(hint) if each is not NoneType]
        return " or ".join(map(_type, some))
    if typing.get_origin(hint) is dict:
        return f"{_type(typing.get_args(hint)[1])} by name"
    if typing.get_origin(hint) is list:
        return f"list of {_type(typing.get_args(hint)[0])}"
    if dc.is_dataclass(hint):
        owner = typing.cast(type, hint)
        tag = "!" if owner in classes() else ""
        return f"[`{tag}{owner.__name__}`](#{_anchor(owner)})"
    words = {float: "number", int: "whole number", str: "text", bool: "true or false"}
    return words.get(hint, str(hint))


def _default(field: Any) -> str:
    """Returns a field's default, or where it comes from."""
    if field.default_factory is not dc.MISSING:
        made = field.default_factory()
        if dc.is_dataclass(made):
            tag = "!" if type(made) in classes() else ""
            return f"`{tag}{type(made).__name__}`"
        return f"`{made!r}`" if not made else f"{len(made)} of them"
    if field.default is None:
        return "none" if "None" in str(field.type) else "the robot's own"
    if isinstance(field.default, bool):
        return f"`{str(field.default).lower()}`"
    return f"`{field.default}`" if field.default != "" else "empty"


def _anchor(owner: type) -> str:
    return owner.__name__.lower()


def _comments(owner: type) -> dict[str, tuple[str, str]]:
    """Returns the comment and the reason of each field that a class declares."""
    try:
        lines = inspect.getsource(owner).splitlines()
    except OSError:
        return {}
    tree = ast.parse(inspect.cleandoc("\n".join(lines))).body[0]
    found = {}
    for node in typing.cast(ast.ClassDef, tree).body:
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            last = lines[(node.end_lineno or node.lineno) - 1]
            found[node.target.id] = (
                _after(last[node.end_col_offset or 0 :]),
                _above(lines, node.lineno - 1),
            )
    return found


def _after(rest: str) -> str:
    match = re.search(r"#\s*(?!noqa)(.*)", rest)
    return match[1].strip() if match else ""


def _above(lines: list[str], at: int) -> str:
    """Returns the comment lines right above line `at`, as one line."""
    found: list[str] = []
    while at and lines[at - 1].strip().startswith("#"):
        at -= 1
        found.insert(0, lines[at].strip().lstrip("# "))
    return " ".join(found)
