"""What `mobman drive` refuses, before anything runs."""

import importlib.util
import socket

from typer.testing import CliRunner

from drake_mobman.cli.app import app
from drake_mobman.teleop.recorded import COMMANDS


def refused(*arguments):
    """Returns the one line by which `mobman drive` refuses."""
    result = CliRunner().invoke(app, ["drive", *map(str, arguments)])
    assert (result.exit_code, result.stdout) == (2, "")
    (line,) = result.stderr.splitlines()
    return line


def test_without_the_extra_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    assert "pip install 'drake_mobman[console]'" in refused("kwon_arbitrary")


def test_bad_input_is_refused_before_anything_runs(tmp_path):
    folder = tmp_path / "session"
    record = ("--record", folder, "--port", 0)
    assert "valid names are" in refused("kwon_9", *record)
    assert "must be" in refused("kwon_1", "--set", "period=0", *record)
    assert "gate.fresh" in refused("kwon_1", "--set", "gate.fresh=-1", *record)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        line = refused("kwon_1", "--record", folder, "--port", port)
        assert f"cannot serve at 127.0.0.1, port {port}" in line
        line = refused("kwon_1", "--record", folder, "--port", port, "--plain")
        assert f"cannot serve at port {port}" in line
    assert "no.such.host" in refused("kwon_1", *record, "--host", "no.such.host")
    assert "this machine alone" in refused("kwon_1", "--plain", "--host", "0.0.0.0")
    assert not folder.exists()
    folder.mkdir()
    (folder / "thesis.tex").write_text("years of work")
    assert "thesis.tex" in refused("kwon_1", *record)
    assert len(list(folder.iterdir())) == 1


def test_recording_is_not_replaced(tmp_path):
    (tmp_path / COMMANDS).write_text("an hour of a person's work")
    line = refused("kwon_1", "--record", tmp_path, "--port", 0)
    assert line == (
        f"mobman: {tmp_path}: cannot be written, it holds a recorded session, which "
        "would be lost; must be new, or of an earlier run"
    )
    assert (tmp_path / COMMANDS).read_text() == "an hour of a person's work"
    assert len(list(tmp_path.iterdir())) == 1
