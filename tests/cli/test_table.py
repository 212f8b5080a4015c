"""The table of a run: groups, units, and columns that fit into the terminal."""

import io
import os
import pty
import re
import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from rich.console import Console

from drake_mobman.cli import messages, table

ODD = ["plain", "two words", "größer → 3", "[bold]", "a;b?c#d%41", "'\"$&"]
EVIL = "x\x1b[31m\x07\u202ey"


def printed(monkeypatch, results, width):
    """Returns the lines of a table in a terminal of a width."""
    output = io.StringIO()
    console = Console(file=output, width=width, emoji=False, markup=False)
    monkeypatch.setattr(table, "console", console)
    table.print_metrics(results)
    return [line.rstrip() for line in output.getvalue().splitlines()]


def numbers(**more):
    return {"ee_error_rms": 0.25, "base_speed_max": 0.5, "died": None} | more


def test_rows_are_in_groups_with_their_units(monkeypatch):
    lines = printed(monkeypatch, {"a": numbers(joint_speed_max=1)}, 80)
    assert [line.split() for line in lines if line] == [
        ["metric", "a", "unit"],
        [lines[1]],
        ["end", "effector"],
        ["ee_error_rms", "0.25", "m/s"],
        ["base"],
        ["base_speed_max", "0.5", "m/s"],
        ["arm"],
        ["joint_speed_max", "1", "rad/s"],
    ]


def test_row_without_a_value_is_left_out_but_not_one_of_a_single_run(monkeypatch):
    results = {"a": numbers(hand_force_max=None), "b": numbers(hand_force_max=2.0)}
    (row,) = (x for x in printed(monkeypatch, results, 80) if "hand_force" in x)
    assert row.split() == ["hand_force_max", "-", "2", "N"]
    assert "hand_force" not in "".join(printed(monkeypatch, {"a": results["a"]}, 80))


@pytest.mark.parametrize("width", [42, 60, 80, 81, 82, 83, 84, 85, 100, 120, 200])
def test_no_table_is_wider_than_the_terminal(monkeypatch, width):
    names = [f"scenario_{'x' * i}" for i in range(7)]
    results = {name: numbers(base_jerk_rms=1.234e-15) for name in names}
    lines = printed(monkeypatch, results, width)
    assert max(map(len, lines)) <= width
    # Nothing of it is cut off, and each scenario is in one table.
    headings = " ".join(line for line in lines if line.startswith("metric")).split()
    assert [x for x in headings if x not in ("metric", "unit")] == names
    assert " ".join(lines).split().count("1.234e-15") == len(names)


def test_names_with_control_characters_are_shown_as_text(monkeypatch):
    text = "\n".join(printed(monkeypatch, {EVIL: numbers(died=EVIL)}, 120))
    assert "x\\x1b[31m\\x07\\u202ey" in text
    assert "\x1b" not in text


# --- Paths one can click -------------------------------------------------------------

LINK = re.compile(r"\x1b\]8;[^;]*;([^\x1b]*)\x1b\\(.*?)\x1b\]8;;\x1b\\")


def line_of(monkeypatch, path, **options):
    output = io.StringIO()
    console = Console(file=output, width=40, emoji=False, markup=False, **options)
    monkeypatch.setattr(messages, "console", console)
    messages.say_path("written to", path)
    return output.getvalue()


@pytest.mark.parametrize("name", ODD)
def test_path_is_a_link_in_a_terminal(monkeypatch, tmp_path, name):
    monkeypatch.chdir(tmp_path)
    for path in (Path(name), tmp_path / name):
        terminal = {"force_terminal": True, "color_system": "standard"}
        line = line_of(monkeypatch, path, **terminal)
        ((address, shown),) = LINK.findall(line)
        assert shown == str(path)
        assert urlsplit(address).scheme == "file"
        assert unquote(urlsplit(address).path) == str(tmp_path / name)
        assert address.isascii()


@pytest.mark.parametrize("name", ODD)
def test_path_is_plain_text_elsewhere(monkeypatch, name):
    assert line_of(monkeypatch, Path(name)) == f"written to {name}\n"


@pytest.mark.parametrize("options", [{}, {"force_terminal": True}])
def test_no_character_of_a_path_is_obeyed_by_the_terminal(monkeypatch, options):
    line = line_of(monkeypatch, Path(f"/{EVIL}\udcff"), **options)
    plain = LINK.sub(lambda link: link[1] + link[2], line.rstrip("\n"))
    assert plain.isprintable()
    assert "\\x1b[31m\\x07\\u202ey\\udcff" in plain


def test_run_in_a_terminal_links_its_folder_and_its_scene(tmp_path):
    ours, theirs = pty.openpty()
    command = ["run", "kwon_1", "--scene", "--no-figures", "--set", "duration=0.1"]
    with subprocess.Popen(
        [sys.executable, "-m", "drake_mobman", *command],
        stdout=theirs,
        stderr=subprocess.DEVNULL,
        cwd=tmp_path,
        env=os.environ | {"TERM": "xterm-256color", "COLUMNS": "80"},
    ) as process:
        os.close(theirs)
        shown = b""
        while chunk := _read(ours):
            shown += chunk
        assert process.wait() == 0
    os.close(ours)
    links = LINK.findall(shown.decode())
    assert [text for _, text in links] == ["runs/kwon_1", "runs/kwon_1/scene.html"]
    assert [urlsplit(address).path for address, _ in links] == [
        str(tmp_path / text) for _, text in links
    ]


def _read(descriptor):
    try:
        return os.read(descriptor, 4096)
    except OSError:  # The other end is closed.
        return b""
