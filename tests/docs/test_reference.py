"""The scenarios reference holds every field, with a comment that gives its unit."""

import dataclasses as dc
import importlib.util
import typing
from pathlib import Path

import pytest

from drake_mobman.robots.file.contents import RobotFile
from drake_mobman.scenario import AnyScenario

HOOKS = Path(__file__).parent.parent.parent / "docs" / "hooks"


def hook(name):
    """Returns a module of the documentation's hooks."""
    spec = importlib.util.spec_from_file_location(name, HOOKS / f"{name}.py")
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def members(hint):
    """Returns the dataclasses below a type, however deep."""
    found = set()
    if dc.is_dataclass(hint):
        found.add(hint)
        for inside in typing.get_type_hints(hint).values():
            found |= members(inside)
    for inside in typing.get_args(hint):
        found |= members(inside)
    return found


REFERENCE = hook("reference")
PAGE = REFERENCE.reference()
EVERY = sorted(members(AnyScenario), key=lambda owner: owner.__name__)


def test_every_dataclass_has_its_section():
    assert len(EVERY) > 20
    for owner in EVERY:
        assert f"### `!{owner.__name__}`" in PAGE


@pytest.mark.parametrize("owner", EVERY, ids=lambda owner: owner.__name__)
def test_every_field_is_on_the_page_with_a_comment(owner):
    section = PAGE.partition(f"### `!{owner.__name__}`")[2].partition("\n### ")[0]
    rows = [row.split(" | ") for row in section.splitlines() if row.startswith("| `")]
    names = [row[0].strip("| `") for row in rows]
    keys = [f.name for f in dc.fields(owner) if f.metadata.get("yaml", True)]
    assert names == keys
    bare = [row[0] for row in rows if not row[3].strip(" |")]
    assert not bare, f"no comment at {owner.__name__}: {bare}"


def test_every_key_of_a_robot_file_is_on_its_page_with_a_comment():
    page = REFERENCE.reference(RobotFile)
    for owner in members(RobotFile):
        section = page.partition(f"### `{owner.__name__}`")[2].partition("\n### ")[0]
        rows = [x.split(" | ") for x in section.splitlines() if x.startswith("| `")]
        assert [x[0].strip("| `") for x in rows] == [f.name for f in dc.fields(owner)]
        assert all(row[3].strip(" |") for row in rows), owner.__name__


def test_comment_on_the_line_comes_before_the_reason_above(tmp_path, monkeypatch):
    (tmp_path / "made.py").write_text(
        "import dataclasses as dc\n\n\n"
        "@dc.dataclass\n"
        "class Made:\n"
        '    """What it is."""\n\n'
        "    # As fast as it may be,\n"
        "    # for a reason.\n"
        "    speed: float = 0.5  # Forward [m/s].\n"
        "    plain: int = 3  # Of them.\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    made = importlib.import_module("made")
    speed, plain = REFERENCE.fields_of(made.Made)
    assert speed.comment == "Forward [m/s]."
    assert speed.reason == "As fast as it may be, for a reason."
    assert (speed.type, speed.default) == ("number", "`0.5`")
    assert (plain.comment, plain.reason) == ("Of them.", "")


def test_every_signal_is_in_the_table():
    rows = hook("signal_table").table().splitlines()[2:]
    source = (HOOKS.parent.parent / "drake_mobman" / "signals.py").read_text()
    assert len(rows) == source.count(' = "')
    assert "| `ee_command` | 3 | `v_c` [m/s]" in "\n".join(rows)
