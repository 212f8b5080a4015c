"""However a session ends or is hindered: cleanly, in time, and without a loss."""

import json
import os
import re
import resource
import signal
import socket
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from drake_mobman.cli.app import app
from drake_mobman.console.addresses import listening, token_for
from drake_mobman.console.launch import scenario_file
from drake_mobman.console.mailbox import OperatorInput
from drake_mobman.console.session import LiveSession
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate
from drake_mobman.teleop.gate import Arming
from drake_mobman.teleop.recorded import COMMANDS, read_samples

pytestmark = pytest.mark.realtime

ARMED = 2

END = 120.0
"""How long a session may take to end on a busy machine [s]."""

SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]


def command(*arguments, more=("-X", "importtime")):
    module = [*more, "-m", "drake_mobman"]
    return [sys.executable, *module, "drive", *map(str, arguments), "--port", "0"]


def heeded():
    """Has signals end a process as in a terminal, whatever runs the tests."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)


def said(errors):
    """Returns what is said in a terminal, but for which modules are imported."""
    return [x for x in errors.splitlines() if x and not x.startswith("import time:")]


def plays(folder):
    """Plays a recording back, as far as it came; returns its log."""
    run = simulate(load_scenario(str(folder / "scenario.yaml")))
    assert run.died == ""
    return run.log


# --- While it starts -----------------------------------------------------------------


slow = pytest.mark.slow

MOMENTS = [
    pytest.param(number, module, marks=() if quick else slow)
    for module in (
        *("numpy", "pydrake.systems.framework", "drake_mobman.scenario.scenario"),
        *("drake_mobman.console.session", "uvicorn.server", "nicegui.ui"),
        "drake_mobman.console.server",
    )
    for number in SIGNALS
    for quick in [
        (number.name, module)
        in {
            ("SIGINT", "pydrake.systems.framework"),
            ("SIGINT", "nicegui.ui"),
            ("SIGTERM", "drake_mobman.console.session"),
            ("SIGHUP", "drake_mobman.console.server"),
        }
    ]
]
"""Signals, and the modules at whose import they come: at each point, in the study."""


@pytest.mark.parametrize(("number", "module"), MOMENTS)
def test_signal_while_it_imports_ends_it_without_a_traceback(tmp_path, number, module):
    errors, folder = tmp_path / "errors", tmp_path / "folder"
    folder.mkdir()
    imported = re.compile(rf"\| +{re.escape(module)}$", re.MULTILINE)
    with errors.open("wb") as stderr:
        process = subprocess.Popen(
            command("kwon_1", "--record", folder / "session"),
            stdout=subprocess.PIPE,
            stderr=stderr,
            preexec_fn=heeded,  # noqa: PLW1509 - No thread of ours holds a lock.
            cwd=folder,
        )
    try:
        began = time.monotonic()
        while not imported.search(errors.read_text()):
            assert time.monotonic() < began + END
            time.sleep(0.005)
        process.send_signal(number)
        status = process.wait(END)
    finally:
        process.kill()
        process.communicate()
    assert said(errors.read_text()) in ([], ["mobman: interrupted"])
    if left := list(folder.iterdir()):  # It was quick, and had begun.
        assert left == [folder / "session"]
        assert status in {0, 128 + number}
        plays(folder / "session")
    else:
        assert status in {128 + number, -number}


# --- While it goes on ----------------------------------------------------------------


@pytest.mark.parametrize(
    "number", [signal.SIGINT, pytest.param(signal.SIGHUP, marks=slow)]
)
def test_who_asks_twice_does_not_wait_for_what_is_completed_all_the_same(
    mobman_drive, operator_of, tmp_path, number
):
    folder = tmp_path / "session"
    options = {"preexec_fn": heeded, "cwd": tmp_path}
    with mobman_drive("kwon_1", "--record", folder, **options) as drive:
        with operator_of(drive) as operator:
            operator.drives()
            operator.until(lambda state: state["time"] > 0.5, "it goes on")
            before = set(drive.children)
            drive.process.send_signal(number)
            drive.until(lambda: set(drive.children) - before, "it completes it")
            assert drive.end(number) == 0
            assert not (folder / "figures").exists()
        assert said(drive.errors.decode()) == [
            "mobman: recordings are completed without you; that takes some seconds"
        ]
    ended = time.monotonic() + END
    while not (folder / "figures").exists():
        assert time.monotonic() < ended
        time.sleep(0.1)
    log = plays(folder)
    assert np.abs(log["ee_command"]).max() > 0
    assert np.load(folder / "log.npz")["time"].tobytes() == log["time"].tobytes()


@contextmanager
def output_to(kind):
    """Gives a standard output that takes nothing."""
    if kind == "full":
        with open("/dev/full", "w") as full:
            yield full
    else:
        reader, writer = os.pipe()
        os.close(reader)
        with os.fdopen(writer, "w") as broken:
            yield broken


@pytest.mark.parametrize("kind", ["full", pytest.param("broken", marks=slow)])
def test_output_that_takes_nothing_ends_it_without_a_traceback(tmp_path, kind):
    with output_to(kind) as output:
        process = subprocess.Popen(
            command("kwon_1", "--record", tmp_path / "s", more=()),
            stdout=output,
            stderr=subprocess.PIPE,
            text=True,
        )
        try:
            _, errors = process.communicate(timeout=END)
        finally:
            process.kill()
    why = "No space left on device" if kind == "full" else "Broken pipe"
    assert errors == f"mobman: cannot write to the standard output: {why}\n"
    assert process.returncode == 1


# --- Stopped, and gone ---------------------------------------------------------------


def test_operator_who_is_killed_leaves_the_robot_at_rest(drive, operator):
    operator.moves()
    operator.socket.shutdown(socket.SHUT_RDWR)  # As the kernel does of a browser.
    state = drive.rests("stopped: the operator left")
    assert state["arming"] != ARMED


def test_server_that_stood_still_is_at_rest_when_it_goes_on(drive, operator):
    operator.moves()
    os.kill(drive.pid, signal.SIGSTOP)
    try:
        time.sleep(3.0)  # The operator pushes on; all that waits in his socket.
    finally:
        stamp = time.monotonic()
        operator.holds = None
        os.kill(drive.pid, signal.SIGCONT)
    operator.until(lambda state: state["clock"] > stamp + 0.3, "it goes on")
    operator.rests()
    assert operator.state["arming"] != ARMED
    assert "stopped" in operator.state["text"] or "not armed" in operator.state["text"]


def test_wall_clock_that_jumps_changes_nothing(monkeypatch):
    real, began = time.time, time.monotonic()

    def jumping():
        return real() + 1000.0 * (-1) ** int(10 * (time.monotonic() - began))

    monkeypatch.setattr(time, "time", jumping)
    with LiveSession(load_scenario("kwon_1")) as session:
        until_armed, sequence = time.monotonic() + END, 0
        while session.snapshot().time < 2.0 or session.snapshot().text != "driving":
            assert time.monotonic() < until_armed
            sequence += 1
            held = session.snapshot().arming != Arming.LATCHED
            session.send(OperatorInput(sequence, dead_man=held))
            time.sleep(0.02)
        simulated, wall = session.snapshot().time, time.monotonic()
        time.sleep(1.0)
        went = session.snapshot().time - simulated
        assert went == pytest.approx(time.monotonic() - wall, abs=0.6)


# --- Recordings ----------------------------------------------------------------------


def test_dozens_of_resets_and_records_have_one_post_processor(
    mobman_drive, operator_of, tmp_path
):
    arguments = ("kwon_1", "--record", tmp_path / "session")
    with mobman_drive(*arguments, cwd=tmp_path) as drive:
        before, most = set(drive.children), 0
        with operator_of(drive) as operator:
            for k in range(12):
                operator.until(lambda state: state["time"] > 0.1, "it runs")
                operator.ask("reset")
                name = f"session-{k + 2}"
                operator.until(lambda state: state["recording"].endswith(name), name)  # noqa: B023
                most = max(most, len(set(drive.children) - before))
            for what in ("record", "end_record", "reset") * 12:  # All by one name.
                operator.ask(what)
            operator.until(lambda state: not state["recording"], "it ends")
            operator.drives()
        assert most == 1
        drive.process.send_signal(signal.SIGINT)
        for _ in range(10):
            time.sleep(0.05)
            most = max(most, len(set(drive.children) - before))
        assert most <= 2  # One that ends, and one that begins.
        assert drive.end(signal.SIGINT) == 0  # We will not wait.
    folders = [*tmp_path.glob("session*"), *(tmp_path / "runs").glob("*")]
    assert len(folders) >= 13
    for folder in folders:
        assert read_samples(folder / COMMANDS).size > 0


def small_files():
    resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))


def test_file_that_may_not_grow_ends_the_recording_and_says_so(
    mobman_drive, operator_of, tmp_path
):
    folder = tmp_path / "session"
    arguments = ("kwon_1", "--record", folder)
    with mobman_drive(*arguments, preexec_fn=small_files) as drive:
        with operator_of(drive) as operator:
            operator.until(lambda state: state["problem"], "it is told")
            assert (
                "recording ended: [Errno 27] File too large"
                in (operator.state["problem"])
            )
            operator.until(lambda state: not state["recording"], "it ends")
            with operator.drives_on():
                time.sleep(1.0)
        assert drive.end() == 1
        assert b"File too large" in drive.errors
        assert b"Traceback" not in drive.errors
    assert plays(folder)["time"][-1] > 0.5


def test_folder_that_takes_no_recording_is_told_of_on_the_page(operator):
    operator.ask("record")  # Its place is taken by a file.
    operator.until(lambda state: state["notice"], "it is told")
    assert "runs is a file" in operator.state["notice"]
    assert operator.state["recording"] == ""
    operator.drives()


# --- What is named on the command line -----------------------------------------------


def refused(*arguments):
    """Returns the one line by which `mobman drive` refuses."""
    result = CliRunner().invoke(app, ["drive", *map(str, arguments)])
    assert (result.exit_code, result.stdout) == (2, "")
    (line,) = result.stderr.splitlines()
    return line


def test_run_folder_is_opened(mobman_drive, tmp_path):
    folder = tmp_path / "mine"
    folder.mkdir()
    text = "decomposer: !Switching\nduration: 1.0\ndescription: of a run\n"
    (folder / "scenario.yaml").write_text(text)
    assert scenario_file(str(folder)) == str(folder / "scenario.yaml")
    assert scenario_file("kwon_1") == "kwon_1"
    with mobman_drive(f"{folder}/") as drive:
        assert drive.line.startswith("drive mine at http://")
        with drive.connect() as page:
            assert json.loads(page.recv(timeout=10))["choice"] == "switching"
        # Who reads what it prints may leave.
        drive.process.stdout.close()
        assert drive.end() == 0
        assert drive.errors == b""


def test_what_cannot_be_driven_is_refused_in_one_line(tmp_path):
    (tmp_path / "empty").mkdir()
    line = refused(tmp_path / "empty")
    assert line == (
        f"mobman: {tmp_path}/empty: holds no scenario.yaml; must be a run folder, a "
        "scenario's file or name"
    )
    assert "no such scenario" in refused("x" * 300) or "too long" in refused("x" * 300)
    circle = tmp_path / "circle"
    circle.symlink_to(circle)
    port = ("--port", 0)
    for folder in ("x" * 300, tmp_path / ("x" * 300) / "s", circle, circle / "s"):
        line = refused("kwon_1", "--record", folder, *port)
        assert "cannot be written" in line
    for folder in ("/proc/s", "/sys/s", "/dev/null/s"):  # Where nobody may write.
        assert "cannot be written" in refused("kwon_1", "--record", folder, *port)


def test_place_that_cannot_be_had_is_refused_in_one_line(shared):
    line = refused("kwon_1", "--port", shared.port)
    assert f"cannot serve at 127.0.0.1, port {shared.port}: Address already" in line
    line = refused("kwon_1", "--port", 0, "--host", "203.0.113.1")
    assert "cannot serve at 203.0.113.1, port 0: " in line
    for host in ("no.such.host.example", "a..b", "x" * 300, "é" * 80, "\x1b[31m", ""):
        line = refused("kwon_1", "--port", 0, "--host", host)
        assert line.startswith("mobman: cannot serve at ")
        assert "\x1b" not in line


@pytest.mark.parametrize(
    ("host", "seen"),
    [
        ("0.0.0.0", True),
        ("0", True),
        ("::", True),
        ("::1", False),
        ("127.0.0.2", False),
        ("localhost", False),
    ],
)
def test_token_is_asked_for_where_others_can_come(host, seen):
    if ":" in host and not Path("/proc/net/if_inet6").exists():
        pytest.skip("there is no IPv6")
    with listening(host, 0) as place:
        assert (token_for(place) is not None) == seen
        assert token_for(place) != token_for(place) or not seen
