"""The process `mobman`: where it is run, what it is given, and who listens to it."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from drake_mobman.cli.app import app
from drake_mobman.scenario import ScenarioError, load_scenario

MOBMAN = [sys.executable, "-m", "drake_mobman"]
COMMANDS = ["list", "run", "compare", "bench", "drive", "graph", "field"]
TAIL = {
    "run": ["kwon_1", "--no-figures", "--set", "duration=0.05"],
    "compare": ["kwon_1", "--decomposers", "exact", "--set", "duration=0.05"],
    "drive": ["kwon_1"],
    "graph": ["kwon_1", "--out", "a.dot"],
    "field": ["petric_guided"],
}
"""Arguments, so that each command has something to do."""

needs_full = pytest.mark.skipif(
    not os.path.exists("/dev/full"), reason="needs /dev/full"
)


def mobman(*arguments, folder, **options):
    """Returns the command's status, and the lines of its standard error."""
    given = {"stdout": subprocess.DEVNULL, "cwd": folder, "timeout": 120} | options
    done = subprocess.run(
        [*MOBMAN, *arguments], stderr=subprocess.PIPE, text=True, check=False, **given
    )
    return done.returncode, done.stderr.splitlines()


@needs_full
@pytest.mark.parametrize("command", ["--help", "list", "run", "compare"])
def test_output_that_is_not_taken_is_told_at_the_end(command, tmp_path):
    with open("/dev/full", "w") as full:
        status, lines = mobman(
            command, *TAIL.get(command, []), folder=tmp_path, stdout=full
        )
    assert status == 1
    (line,) = lines
    assert (
        line == "mobman: cannot write to the standard output: No space left on device"
    )
    # And what there was to be written is.
    written = {"run": "log.npz", "compare": "comparison.json"}
    assert command not in written or list(tmp_path.rglob(written[command]))


def test_reader_who_leaves_is_told_of_too(tmp_path):
    ours, theirs = os.pipe()
    os.close(ours)
    status, lines = mobman("list", folder=tmp_path, stdout=theirs)
    os.close(theirs)
    assert status == 1
    assert lines == ["mobman: cannot write to the standard output: Broken pipe"]


@pytest.mark.parametrize("command", ["--help", *COMMANDS])
def test_closed_output_is_refused_before_anything_is_written(command, tmp_path):
    status, lines = mobman(
        command,
        *TAIL.get(command, []),
        folder=tmp_path,
        stdout=None,
        preexec_fn=lambda: os.close(1),
    )
    assert status == 2
    (line,) = lines
    assert "the standard output is closed" in line
    assert list(tmp_path.iterdir()) == []


@needs_full
def test_status_is_told_where_nothing_else_can_be(tmp_path):
    given = {"stdout": subprocess.DEVNULL, "cwd": tmp_path, "timeout": 120}
    with open("/dev/full", "w") as full:
        for stderr, before in ((full, None), (None, lambda: os.close(2))):
            done = subprocess.run(
                [*MOBMAN, "run", "nosuch"],
                stderr=stderr,
                preexec_fn=before,
                check=False,
                **given,
            )
            assert done.returncode == 2


@pytest.mark.parametrize("command", COMMANDS)
def test_working_folder_that_is_gone_is_told(command, tmp_path):
    gone = tmp_path / "gone"
    gone.mkdir()
    status, lines = mobman(
        command,
        *TAIL.get(command, []),
        folder=gone,
        preexec_fn=gone.rmdir,
    )
    assert status == 2
    (line,) = lines
    assert "the working folder is gone" in line


@pytest.mark.parametrize(
    ("module", "command"),
    [
        ("rich.console", ["list"]),
        ("typer", ["list"]),
        ("numpy", ["list"]),
        ("pydrake", ["list"]),
        ("pydrake.systems.framework", ["list"]),
        ("pydrake.multibody.plant", ["list"]),
        ("pydrake.solvers", ["list"]),
        ("drake_mobman.robots.servo", ["list"]),
        ("drake_mobman.diagrams.guided", ["graph", "kwon_1", "--out", "out.dot"]),
    ],
)
def test_ctrl_c_during_any_import_ends_it_cleanly(module, command, tmp_path):
    """The interpreter is made to interrupt itself when it comes to a module."""
    (tmp_path / "sitecustomize.py").write_text(
        "import os, signal, sys\n"
        "class Interrupt:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        f"        if name == {module!r}:\n"
        "            sys.meta_path.remove(self)\n"
        "            os.kill(os.getpid(), signal.SIGINT)\n"
        "sys.meta_path.insert(0, Interrupt())\n"
    )
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    status, lines = mobman(*command, folder=tmp_path, env=environment)
    assert status == 128 + signal.SIGINT
    assert lines in ([], ["mobman: interrupted"])
    assert [path.name for path in tmp_path.iterdir()] == ["sitecustomize.py"]


# What is given for a scenario.


def refused(name):
    with pytest.raises(ScenarioError) as refusal:
        load_scenario(name)
    line = str(refusal.value)
    assert line.isprintable()
    assert len(line) < 400
    return line


def test_scenario_that_is_no_file_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    Path("loop").symlink_to("loop")
    Path("folder").mkdir()
    Path("big.yaml").write_text("# " + "x" * 2_000_000)
    for name, says in (
        ("pipe", "pipe: cannot be read; it is not a file"),
        ("/dev/zero", "/dev/zero: cannot be read; it is not a file"),
        ("loop", "loop: cannot be read; Too many levels of symbolic links"),
        ("folder", "folder: cannot be read; "),
        ("folder/none.yaml", "folder/none.yaml: no such scenario; valid names are"),
        ("big.yaml", "big.yaml: cannot be read; it has more than 1000000 bytes"),
        ("a" * 300, "cannot be read; File name too long"),
        ("a\nb\x1b[31m", r"'a\nb\x1b[31m': no such scenario"),
        ("a\0b", r"'a\x00b': cannot be read; "),
    ):
        assert says in refused(name)


@pytest.mark.skipif(os.getuid() != 0, reason="needs to become someone else")
def test_scenario_in_a_folder_of_others_is_refused(tmp_path):
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o700)
    (closed / "mine.yaml").touch()
    tmp_path.chmod(0o755)
    os.seteuid(65534)
    try:
        line = refused(str(closed / "mine.yaml"))
    finally:
        os.seteuid(0)
    assert line.endswith("mine.yaml: cannot be read; Permission denied")


def test_name_that_is_no_text_is_refused(tmp_path):
    file = tmp_path / os.fsdecode(b"b\xffd.yaml")
    file.touch()
    assert r"'b\udcffd': a scenario's name must be" in refused(str(file))


def test_name_that_looks_like_markup_is_printed_as_it_is(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("[bold].yaml").touch()
    result = CliRunner().invoke(app, ["run", "[bold].yaml", *TAIL["run"][1:]])
    assert result.exit_code == 0
    assert "[bold]" in result.stdout.splitlines()[0]
