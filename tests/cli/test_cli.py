"""The command line: what it writes, what it refuses, and how it ends."""

import errno
import json
import os
import pty
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
import urllib.request
import zipfile
from contextlib import contextmanager
from http.cookiejar import CookieJar
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from typer.testing import CliRunner

from drake_mobman import __version__
from drake_mobman.cli.app import app
from drake_mobman.console.panel_process import EXPOSED

MOBMAN = [sys.executable, "-m", "drake_mobman"]
QUICK = ["--no-figures", "--set", "duration=0.5"]


def mobman(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments])


def refused(*arguments):
    """Returns the one line by which the command refuses."""
    result = mobman(*arguments)
    assert result.exit_code == 2
    assert result.stdout == ""
    (line,) = result.stderr.splitlines()
    return line


def files_in(folder):
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())


def test_list_names_every_scenario_and_robot_with_one_line():
    scenarios, _, robots = mobman("list").stdout.partition("\n\n")
    _, *lines = robots.splitlines()
    assert {"tiago", "fetch", "so101"} < {line.split()[0] for line in lines}
    assert all(len(line.split()) > 3 for line in lines)
    lines = scenarios.splitlines()
    names = [line.split()[0] for line in lines]
    assert {"kwon_1", "kwon_2", "kwon_3", "kwon_4"} < set(names)
    assert {"kwon_arbitrary", "kwon_spatial"} < set(names)
    assert all(len(line.split()) > 3 for line in lines)


def test_run_writes_the_whole_folder(tmp_path):
    out = tmp_path / "new" / "runs"
    result = mobman("run", "kwon_1", "--out", out, "--scene", "--set", "duration=2")
    assert result.exit_code == 0
    files = files_in(out)
    assert {"kwon_1/log.npz", "kwon_1/metrics.json", "kwon_1/scenario.yaml"} < set(
        files
    )
    assert "kwon_1/scene.html" in files
    assert sum(f.startswith("kwon_1/figures/") for f in files) >= 5
    assert "ee_error_rms" in result.stdout
    numbers = json.loads((out / "kwon_1" / "metrics.json").read_text())
    assert numbers["versions"].keys() == {"drake", "python", "drake_mobman"}
    for metric in (
        "ee_error_rms",
        "ee_error_max",
        "ee_drift_max",
        "workspace_excess_max",
        "authority_flips",
        "base_speed_max",
        "base_yaw_rate_max",
        "joint_speed_max",
        "base_jerk_rms",
        "lateral_slip_max",
        "manipulability_min",
        "step_time_us",
        "real_time_factor",
    ):
        assert numbers[metric] is not None, metric


def test_scene_stands_by_itself(tmp_path):
    mobman("run", "kwon_1", "--out", tmp_path, "--scene", *QUICK)
    page = (tmp_path / "kwon_1" / "scene.html").read_text()
    assert "<html" in page
    assert not re.search(r'<(script|link|img|iframe)[^>]*(src|href)="?http', page)


def test_resolved_scenario_reproduces_its_folder(tmp_path):
    overrides = ["--set", "duration=1.5", "--set", "decomposer.alpha=9"]
    mobman("run", "kwon_arbitrary", "--out", tmp_path / "a", "--no-figures", *overrides)
    first = tmp_path / "a" / "kwon_arbitrary"
    again = mobman(
        "run", first / "scenario.yaml", "--out", tmp_path / "b", "--no-figures"
    )
    assert again.exit_code == 0
    second = tmp_path / "b" / "kwon_arbitrary"
    assert (first / "scenario.yaml").read_text() == (
        second / "scenario.yaml"
    ).read_text()
    one, two = np.load(first / "log.npz"), np.load(second / "log.npz")
    assert one.files == two.files
    for name in one.files:
        assert one[name].tobytes() == two[name].tobytes(), name


def test_several_scenarios_give_several_folders(tmp_path):
    result = mobman("run", "kwon_1", "kwon_3", "--out", tmp_path, *QUICK)
    assert result.exit_code == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["kwon_1", "kwon_3"]
    assert "kwon_1" in result.stdout
    assert "kwon_3" in result.stdout


def test_run_again_replaces_the_old_run_whole(tmp_path):
    mobman("run", "kwon_1", "--out", tmp_path, "--set", "duration=0.5")
    assert (tmp_path / "kwon_1" / "figures").is_dir()
    mobman("run", "kwon_1", "--out", tmp_path, *QUICK)
    assert files_in(tmp_path) == [
        "kwon_1/log.npz",
        "kwon_1/manifest.sha256",
        "kwon_1/metrics.json",
        "kwon_1/scenario.yaml",
    ]


def test_json_is_all_there_is_on_the_standard_output(tmp_path):
    command = [*MOBMAN, "run", "kwon_1", "petric_guided", "--json", *QUICK]
    done = subprocess.run(
        [*command, "--out", tmp_path], capture_output=True, text=True, check=True
    )
    assert done.stderr == ""
    content = json.loads(done.stdout)
    assert list(content) == ["kwon_1", "petric_guided"]
    for name, one in content.items():
        assert one["folder"] == str(tmp_path / name)
        assert one["status"] == 0
        written = json.loads((tmp_path / name / "metrics.json").read_text())
        assert one["metrics"] == written


def test_json_of_a_run_that_died_says_so(tmp_path, monkeypatch):
    def full(*_args, **_kwargs):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(zipfile.ZipFile, "open", full)
    result = mobman("run", "kwon_1", "--json", "--out", tmp_path, *QUICK)
    assert result.exit_code == 1
    assert "not written" in result.stderr
    one = json.loads(result.stdout)["kwon_1"]
    assert (one["metrics"], one["status"]) == (None, 1)


def test_json_of_bad_input_is_nothing(tmp_path):
    line = refused("run", "nosuch", "--json", "--out", tmp_path)
    assert "no such scenario" in line


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["nosuch"], "no such scenario"),
        (["kwon_1", "--set", "duratoin=1"], "valid keys are"),
        (["kwon_1", "--set", "duration=soon"], "must be a number"),
        (["kwon_1", "--set", "start.x=.nan"], "must be a finite number"),
        (["kwon_1", "--set", "start.x=.inf"], "must be a finite number"),
        (["kwon_1", "--set", "workspace.l_min=1.7"], "must be below l_max = 1.6"),
        (["kwon_1", "--set", "robot.lower_link=-1"], "must be within [0.01, 10] m"),
        (["kwon_1", "--set", "start.l=2.1"], "out of reach"),
        (["kwon_1", "--set", "duration=0"], "must be at least period"),
        (["kwon_1", "--set", "source=external"], "is fed by a program"),
        (["kwon_1", "kwon_2", "kwon_1"], "is given twice"),
        (["kwon_1", "kwon_2", "nosuch"], "no such scenario"),
    ],
)
def test_bad_input_is_refused_before_anything_is_written(tmp_path, arguments, says):
    out = tmp_path / "runs"
    line = refused("run", *arguments, "--out", out)
    assert says in line
    assert list(tmp_path.iterdir()) == []


def test_scenario_that_is_not_yaml_is_refused(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("start: {l: 1.0")
    assert "must be YAML" in refused("run", file, "--out", tmp_path / "runs")
    assert list(tmp_path.iterdir()) == [file]


def test_output_folder_that_is_a_file_is_refused(tmp_path):
    out = tmp_path / "runs"
    out.write_text("mine")
    assert "is a file" in refused("run", "kwon_1", "--out", out)
    assert out.read_text() == "mine"


def test_run_folder_that_is_a_file_is_refused(tmp_path):
    (tmp_path / "kwon_1").write_text("mine")
    assert "it is a file" in refused("run", "kwon_1", "--out", tmp_path)
    assert (tmp_path / "kwon_1").read_text() == "mine"


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="needs /proc")
def test_output_folder_that_cannot_be_written_is_refused():
    # Not even the superuser can make a folder there.
    assert "cannot be written" in refused("run", "kwon_1", "--out", "/proc/self/runs")


def test_folder_with_something_of_the_users_in_it_is_not_replaced(tmp_path):
    mine = tmp_path / "kwon_1" / "notes.txt"
    mine.parent.mkdir()
    mine.write_text("mine")
    assert "it holds notes.txt" in refused("run", "kwon_1", "--out", tmp_path)
    assert files_in(tmp_path) == ["kwon_1/notes.txt"]


def start_long_run(out):
    return subprocess.Popen(
        [*MOBMAN, "run", "kwon_1", "--out", out, "--set", "duration=2000"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def wait_for_draft(out):
    deadline = time.monotonic() + 60
    while not (out.is_dir() and any(out.iterdir())):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    time.sleep(1.0)


def test_ctrl_c_keeps_the_log_so_far(tmp_path):
    process = start_long_run(tmp_path)
    wait_for_draft(tmp_path)
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 130
    (line,) = stderr.splitlines()
    assert "kwon_1: interrupted at t = " in line
    log = np.load(tmp_path / "kwon_1" / "log.npz")
    assert 10 < len(log["time"]) < 200_000
    assert len({len(log[name]) for name in log.files}) == 1
    numbers = json.loads((tmp_path / "kwon_1" / "metrics.json").read_text())
    assert "interrupted" in numbers["died"]


def test_killed_run_leaves_the_old_folder_as_it_was(tmp_path):
    mobman("run", "kwon_1", "--out", tmp_path, *QUICK)
    before = (tmp_path / "kwon_1" / "log.npz").read_bytes()
    process = start_long_run(tmp_path)
    deadline = time.monotonic() + 60
    while not list(tmp_path.rglob("log.part")):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    process.kill()
    process.communicate()
    assert (tmp_path / "kwon_1" / "log.npz").read_bytes() == before


def test_progress_is_shown_in_a_terminal_only(tmp_path):
    command = [*MOBMAN, "run", "kwon_1", "--out", str(tmp_path), *QUICK]
    piped = subprocess.run(command, capture_output=True, text=True, check=True)
    assert piped.stderr == ""
    assert "\x1b" not in piped.stdout
    ours, theirs = pty.openpty()
    environment = os.environ | {"TERM": "xterm-256color"}
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=theirs, env=environment
    ) as process:
        os.close(theirs)
        shown = b""
        while chunk := read_terminal(ours):
            shown += chunk
        assert process.wait() == 0
    os.close(ours)
    assert b"kwon_1" in shown


def read_terminal(descriptor):
    try:
        return os.read(descriptor, 4096)
    except OSError:  # The other end is closed.
        return b""


def test_help_does_not_wait_for_drake():
    code = (
        "import sys, drake_mobman.cli.app\n"
        "from typer.testing import CliRunner\n"
        "result = CliRunner().invoke(drake_mobman.cli.app.app, ['--help'])\n"
        "assert 'run' in result.stdout\n"
        "heavy = {'pydrake', 'matplotlib', 'numpy', 'scipy'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_run_without_figures_does_not_wait_for_matplotlib(tmp_path):
    arguments = ["run", "kwon_1", "--no-figures", "--set", "duration=0.05"]
    code = (
        "import sys, drake_mobman.cli.app\n"
        "from typer.testing import CliRunner\n"
        f"arguments = {[*arguments, '--out', str(tmp_path / 'runs')]!r}\n"
        "result = CliRunner().invoke(drake_mobman.cli.app.app, arguments)\n"
        "assert result.exit_code == 0, result.output\n"
        "assert 'matplotlib' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_version_is_that_of_the_package_and_of_drake():
    result = mobman("--version")
    assert result.exit_code == 0
    assert result.stdout.startswith(f"mobman {__version__}, Drake {version('drake')}, ")


@pytest.mark.parametrize("command", ["run", "compare", "bench", "drive", "graph"])
def test_help_says_what_each_option_is_for(command):
    result = mobman(command, "--help")
    assert result.exit_code == 0
    assert all(line.isascii() and len(line) <= 80 for line in result.stdout.split("\n"))
    options = re.findall(r"^  (--[a-z-]+)(.*(?:\n {10,}.*)*)", result.stdout, re.M)
    assert len(options) >= 2
    for name, text in options:
        assert re.search(r" {2,}[A-Z][a-z]+ \S+", text), name


def completed(*words):
    """Returns what the shell offers where Tab is pressed after the last word."""
    environment = os.environ | {
        "_MOBMAN_COMPLETE": "complete_bash",
        "COMP_WORDS": " ".join(words),
        "COMP_CWORD": str(len(words) - 1),
    }
    done = subprocess.run(
        MOBMAN, capture_output=True, text=True, check=False, env=environment
    )
    assert done.stderr == ""
    return done.stdout.split()


def test_shell_completes_commands_and_names_of_scenarios():
    assert completed("mobman", "co") == ["compare"]
    for command in ("run", "compare", "drive", "graph", "field", "bench"):
        offered = completed("mobman", command, "petric_b")
        assert offered == ["petric_behind", "petric_behind_near"]
    assert completed("mobman", "run", "kwon_1", "kwon_sp") == ["kwon_spatial"]
    assert completed("mobman", "run", "./mine") == []
    assert "--install-completion" in mobman("--help").stdout


def test_completion_does_not_wait_for_drake():
    code = (
        "import sys\n"
        "from drake_mobman.cli.options import completed_scenarios\n"
        "assert 'kwon_spatial' in completed_scenarios('kwon')\n"
        "heavy = {'pydrake', 'matplotlib', 'numpy', 'scipy'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_graph_names_every_block_and_signal(tmp_path):
    file = tmp_path / "new" / "teleop.dot"
    assert mobman("graph", "kwon_1", "--out", file).exit_code == 0
    text = file.read_text()
    for block in ("source", "guard", "decomposer", "smoother", "arm", "robot"):
        assert f'"{block}" [' in text
    assert '"decomposer" -> "smoother" [label="base_command"]' in text
    assert '"robot" -> "decomposer" [label="ee_cylindrical"]' in text
    assert "SwitchingDecomposer" in (
        mobman("graph", "kwon_1", "--out", file, "--set", "decomposer=switching")
        and file.read_text()
    )


@pytest.mark.skipif(shutil.which("dot") is None, reason="needs Graphviz")
def test_graph_draws_a_picture(tmp_path):
    file = tmp_path / "teleop.svg"
    assert mobman("graph", "kwon_spatial", "--out", file).exit_code == 0
    assert "<svg" in file.read_text()


def test_graph_without_graphviz_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "")
    line = refused("graph", "kwon_1", "--out", tmp_path / "teleop.svg")
    assert "install the system package graphviz" in line
    assert list(tmp_path.iterdir()) == []


def test_graph_refuses_other_kinds_of_file(tmp_path):
    line = refused("graph", "kwon_1", "--out", tmp_path / "teleop.gif")
    assert "must end in .svg or .dot" in line


@pytest.mark.slow
def test_field_draws_both_laws(tmp_path):
    out = tmp_path / "new" / "field"
    assert mobman("field", "petric_guided", "--out", out).exit_code == 0
    assert files_in(out) == [
        "field_rest.png",
        "field_side_printed.png",
        "field_side_projected.png",
        "field_top_printed.png",
        "field_top_projected.png",
        "manifest.sha256",
    ]


def test_field_of_a_scenario_without_one_is_refused(tmp_path):
    line = refused("field", "kwon_1", "--out", tmp_path / "field")
    assert "follows no velocity field" in line
    assert list(tmp_path.iterdir()) == []


def test_field_does_not_replace_a_run(tmp_path):
    mobman("run", "kwon_1", "--out", tmp_path, *QUICK)
    before = files_in(tmp_path)
    line = refused("field", "petric_guided", "--out", tmp_path / "kwon_1")
    assert "it holds log.npz, which would be lost" in line
    assert files_in(tmp_path) == before


def test_disk_that_fills_up_costs_pictures_only(tmp_path, monkeypatch):
    def full(*_args, **_kwargs):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Figure, "savefig", full)
    result = mobman("run", "kwon_1", "--out", tmp_path, "--set", "duration=0.5")
    assert result.exit_code == 1
    assert "pictures not written: [Errno 28] No space left" in result.stderr
    assert len(np.load(tmp_path / "kwon_1" / "log.npz")["time"]) == 51


def test_disk_that_is_full_leaves_the_old_run_as_it_was(tmp_path, monkeypatch):
    mobman("run", "kwon_1", "--out", tmp_path, *QUICK)
    before = (tmp_path / "kwon_1" / "log.npz").read_bytes()

    def full(*_args, **_kwargs):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(zipfile.ZipFile, "open", full)
    result = mobman("run", "kwon_1", "--out", tmp_path, *QUICK)
    assert result.exit_code == 1
    (line,) = result.stderr.splitlines()
    assert "not written" in line
    assert (tmp_path / "kwon_1" / "log.npz").read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["kwon_1"]


# --- Driving -------------------------------------------------------------------------


@contextmanager
def driving(*arguments, code="", **options):
    """Gives a process of `mobman drive`, before which `code` runs, and its address."""
    code = f"{code}\nfrom drake_mobman.__main__ import main\nmain()"
    process = subprocess.Popen(
        [sys.executable, "-u", "-c", code, "drive", *arguments, "--port", "0"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )
    try:
        yield process, re.search(r"http://\S+(?=;)", process.stdout.readline())[0]
    finally:
        process.kill()
        process.communicate()


def opened(address):
    """Returns the status of a page, once it answers."""
    jar = urllib.request.HTTPCookieProcessor(CookieJar())
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}), jar)
    deadline = time.monotonic() + 60
    while True:
        try:
            return opener.open(address).status
        except OSError:
            assert time.monotonic() < deadline
            time.sleep(0.1)


def ended(process, number=signal.SIGINT):
    """Ends a process by a signal; returns its exit status and what it has to say.

    But for what Meshcat's panel says at the start.
    """
    process.send_signal(number)
    _, stderr = process.communicate(timeout=60)
    return process.returncode, stderr.removeprefix(f"mobman: {EXPOSED}\n")


@pytest.mark.realtime
@pytest.mark.parametrize("panel", [(), ("--plain",)], ids=["page", "plain"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_drive_completes_its_recording_however_it_is_ended(tmp_path, number, panel):
    folder = tmp_path / "session"
    # Whatever the tests are run by may have been told to ignore a closed terminal.
    code = "import signal\nsignal.signal(signal.SIGHUP, signal.SIG_DFL)"
    arguments = ("kwon_1", "--record", folder, *panel)
    with driving(*arguments, code=code) as (process, address):
        assert opened(address) == 200
        time.sleep(0.5)
        assert ended(process, number) == (0, "")
    assert {"figures", "log.npz", "metrics.json"} < {p.name for p in folder.iterdir()}


@pytest.mark.realtime
def test_drive_goes_on_without_its_terminal_if_told_so_by_nohup():
    code = "import signal\nsignal.signal(signal.SIGHUP, signal.SIG_IGN)"
    with driving("kwon_1", "--plain", code=code) as (process, address):
        process.send_signal(signal.SIGHUP)
        time.sleep(0.5)
        assert opened(address) == 200
        assert ended(process) == (0, "")


def test_simulation_that_died_is_told_of_at_the_end(tmp_path):
    code = """
from pathlib import Path
from drake_mobman.console import session

def failing(_diagram, context):
    if context.get_time() > 0.2:
        Path("dying").touch()
        raise ArithmeticError("arm_position is not finite any more")

session.check_finite = failing
"""
    with driving("kwon_1", "--plain", code=code, cwd=tmp_path) as (process, _):
        deadline = time.monotonic() + 60
        while not (tmp_path / "dying").exists():
            assert time.monotonic() < deadline
            time.sleep(0.05)
        status, line = ended(process)
    died = "died at t = 0.21 s: arm_position is not finite any more"
    assert (status, line) == (1, f"mobman: kwon_1: {died}\n")


@pytest.mark.realtime
def test_plain_panel_needs_nothing_of_the_extra():
    code = """
import sys

class Missing:
    def find_spec(self, name, *_):
        if name.split(".")[0] in {"nicegui", "uvicorn", "fastapi", "aiohttp"}:
            raise ModuleNotFoundError(name)

sys.meta_path.insert(0, Missing())
"""
    with driving("kwon_1", "--plain", code=code) as (process, address):
        assert opened(address) == 200
        assert ended(process) == (0, "")


@pytest.mark.realtime
def test_beyond_this_machine_it_is_found_at_the_address_that_is_printed():
    with driving("kwon_1", "--host", "0.0.0.0") as (process, address):
        host = re.match(r"http://([^/:]+):\d+/\?token=", address)[1]
        with socket.socket(type=socket.SOCK_DGRAM) as probe:
            try:
                probe.connect(("198.51.100.1", 9))
                assert host == probe.getsockname()[0]
            except OSError:  # It is in no network.
                assert host == socket.gethostname()
        assert opened(address) == 200
        assert ended(process) == (0, "")


# --- Continuous integration ----------------------------------------------------------


def test_ci_without_a_browser_fails_in_a_line(tmp_path):
    # Where it went on it would find no Python either, and end.
    for tool in ("bash", "dirname"):
        (tmp_path / tool).symlink_to(shutil.which(tool))
    result = subprocess.run(
        ["bash", Path(__file__).parent.parent.parent / ".ci" / "run"],
        env={"PATH": str(tmp_path), "HOME": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 1
    (line,) = result.stderr.splitlines()
    assert line.startswith("no Chromium is here")
