"""Ended by signals: nothing is lost from the first sample to the last file.

In a real process of `mobman run`, forked off one that has imported all it needs, each
signal is raised at step after step of our own code, once and twice; and from outside
at random times.
"""

import json
import os
import pty
import random
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.manifest import DRAFT, MANIFEST, hash_of, read_manifest

pytestmark = pytest.mark.realtime

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

DRIVER = r"""
import json, os, signal, sys, tempfile, time, traceback
from pathlib import Path
import drake_mobman.cli.app as cli
from drake_mobman.report import job
from drake_mobman.simulation import run_folder, stop

ROOT = Path(cli.__file__).parent.parent
OURS = tuple(str(ROOT / name) for name in ("cli", "report", "simulation", "analysis"))
spec = json.loads(sys.argv[1])

def ours(file):
    return file.startswith(OURS)

class Steps:
    # Counts the steps of our own code while signals are taken, and acts at one.
    def __init__(self, at=None, act=None):
        self.at, self.act, self.sites, self.began = at, act, [], None
    def __call__(self, frame, event, _):
        code = frame.f_code
        if not ours(code.co_filename):
            return
        name = code.co_name
        if code.co_filename.endswith("stop.py"):
            if name == "__enter__" and event == "return":
                self.on = True
            elif name == "__exit__":
                self.on = False
            return
        if not getattr(self, "on", False):
            return
        if name == "simulate" and self.began is None:
            self.began = len(self.sites)
        self.sites.append((code.co_filename[-20:], frame.f_lineno, event))
        if len(self.sites) - 1 == self.at:
            self.act()

def child(folder, profile, after=None):
    pid = os.fork()
    if pid:
        return pid
    status = 99
    try:
        os.chdir(folder)
        for n in (signal.SIGTERM, signal.SIGHUP):
            signal.signal(n, signal.SIG_DFL)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        for n, name in ((1, "out"), (2, "err")):
            os.dup2(os.open(name, os.O_CREAT | os.O_WRONLY, 0o666), n)
        sys.setprofile(profile)
        try:
            cli.app(spec["arguments"], prog_name="mobman")
        except SystemExit as end:
            status = end.code or 0
        sys.setprofile(None)
        if after:
            after()
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        os._exit(status)

def ended(pid):
    deadline = time.monotonic() + 120
    while time.monotonic() < deadline:
        done, status = os.waitpid(pid, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.005)
    os.kill(pid, signal.SIGKILL)
    os.waitpid(pid, 0)
    return "hangs"

base = Path(spec["folder"])
def new_folder(name):
    (base / name).mkdir()
    return base / name

dry, counted = new_folder("dry"), Steps()
def tell():
    Path("sites").write_text(json.dumps([counted.began, counted.sites]))
began = time.monotonic()
assert ended(child(dry, counted, tell)) == 0, (dry / "err").read_text()
took = time.monotonic() - began
first, sites = json.loads((dry / "sites").read_text())
print(json.dumps({"first": first, "sites": len(sites), "took": took}), flush=True)
for line in sys.stdin:
    case = json.loads(line)
    folder = new_folder(case["name"])
    number, times = case["number"], case["times"]
    if "share" in case:  # Of the sites: there are not as many each time.
        places = {tuple(site): k for k, site in reversed(list(enumerate(sites)))}
        steps = sorted(places.values())
        at = steps[int(case["share"] * len(steps))]
        def act():
            for _ in range(times):
                os.kill(os.getpid(), number)
        status, early = ended(child(folder, Steps(at, act))), at <= first
        where = sites[at]
    else:
        pid = child(folder, None)
        time.sleep(case["after"] * took)
        for _ in range(times):
            try:
                os.kill(pid, number)
            except ProcessLookupError:
                pass
            time.sleep(case.get("pause", 0))
        status, early, where = ended(pid), None, case["after"]
    print(json.dumps({"status": status, "early": early, "where": where}), flush=True)
"""


class Driver:
    """Runs the command again and again, and has it signalled."""

    def __init__(self, folder, *arguments):
        self.folder = folder
        command = ["run", "kwon_1", "--out", "runs", *arguments]
        spec = json.dumps({"arguments": command, "folder": str(folder)})
        self.process = subprocess.Popen(
            [sys.executable, "-c", DRIVER, spec],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.told = json.loads(self.process.stdout.readline())
        self.count = 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.stdin.close()
        self.process.wait(timeout=60)
        self.process.stdout.close()

    def signalled(self, **case):
        """Returns how it ended, and the folder that it ran in."""
        self.count += 1
        name = str(self.count)
        self.process.stdin.write(json.dumps(case | {"name": name}) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline()), self.folder / name


def is_whole(folder):
    """Asserts that a run folder has all that belongs to a log, and no draft."""
    written = read_manifest(folder)
    assert {"scenario.yaml", "log.npz", "metrics.json"} <= written.keys()
    there = {
        path.relative_to(folder).as_posix()
        for path in folder.rglob("*")
        if path.is_file()
    }
    assert there == {*written, MANIFEST}
    assert not (folder / DRAFT).exists()
    for name, digest in written.items():
        assert hash_of(folder / name) == digest, name
    log = np.load(folder / "log.npz")
    assert {len(log[name]) for name in log.files} == {len(log["time"])}
    load_scenario(str(folder / "scenario.yaml"))
    return log


def nothing_is_lost(end, folder, number):
    said = (folder / "err").read_text()
    assert end["status"] == 128 + number, (end, said)
    assert "Traceback" not in said, (end, said)
    assert "ignored" not in said, (end, said)
    assert all(line.startswith("mobman: ") for line in said.splitlines()), said
    run = folder / "runs" / "kwon_1"
    if end["early"]:
        if not run.exists():
            return
        assert not (run / DRAFT).exists()
    log = is_whole(run)
    assert end["early"] or len(log["time"]) > 0, (end, said)


def study(driver, cases, seed):
    rng = random.Random(seed)
    for k in range(cases):
        for number in SIGNALS:
            times = rng.choice((1, 2))
            share = (k + rng.random()) / cases
            end, folder = driver.signalled(share=share, number=number, times=times)
            nothing_is_lost(end, folder, number)


QUICK = ("--no-figures", "--set", "duration=0.3")


def test_nothing_is_lost_whichever_step_a_signal_comes_at(tmp_path):
    with Driver(tmp_path, *QUICK) as driver:
        assert driver.told["sites"] > 500
        study(driver, 12, seed=1)


def test_nothing_is_lost_while_pictures_are_drawn(tmp_path):
    arguments = ("--scene", "--set", "duration=0.3")
    with Driver(tmp_path, *arguments) as driver:
        study(driver, 2, seed=2)


@pytest.mark.slow
def test_nothing_is_lost_at_any_step(tmp_path):
    with Driver(tmp_path, *QUICK) as driver:
        study(driver, 150, seed=3)


@pytest.mark.parametrize("times", [1, 2])
def test_nothing_is_lost_by_signals_from_outside_at_any_time(tmp_path, times):
    rng = random.Random(times)
    with Driver(tmp_path, *QUICK) as driver:
        for k in range(9):
            case = {"after": rng.uniform(0.05, 0.9), "pause": rng.choice((0, 0.05))}
            number = SIGNALS[k % 3]
            end, folder = driver.signalled(number=number, times=times, **case)
            # Or before it began, or when all was written.
            assert end["status"] in (128 + number, -number, 0), end
            run = folder / "runs" / "kwon_1"
            if run.exists():
                is_whole(run)


def test_killed_at_any_time_the_next_run_is_whole(tmp_path):
    rng = random.Random(7)
    with Driver(tmp_path, *QUICK) as driver:
        for _ in range(5):
            kill = {"number": signal.SIGKILL, "times": 1, "share": rng.random()}
            end, folder = driver.signalled(**kill)
            assert end["status"] == -signal.SIGKILL
            command = [sys.executable, "-m", "drake_mobman"]
            again = subprocess.run(
                [*command, "run", "kwon_1", "--out", "runs", *QUICK],
                cwd=folder,
                capture_output=True,
                text=True,
                timeout=60,
                check=False,
            )
            assert (again.returncode, again.stderr) == (0, "")
            is_whole(folder / "runs" / "kwon_1")


def test_closed_terminal_costs_nothing(tmp_path):
    ours, theirs = pty.openpty()
    code = (
        "import fcntl, signal, termios; signal.signal(signal.SIGHUP, signal.SIG_DFL)\n"
        "fcntl.ioctl(0, termios.TIOCSCTTY, 0)\n"
        "from drake_mobman.__main__ import main; main()"
    )
    arguments = ["run", "kwon_1", "--out", "runs", "--set", "duration=2000"]
    process = subprocess.Popen(
        [sys.executable, "-c", code, *arguments],
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        cwd=tmp_path,
        start_new_session=True,
        env=os.environ | {"TERM": "xterm-256color"},
    )
    os.close(theirs)
    deadline = time.monotonic() + 60
    shown = b""
    while not re.search(rb"[1-9]\d* of 2000 s", shown):
        assert time.monotonic() < deadline
        shown += os.read(ours, 4096)
    os.close(ours)
    try:
        assert process.wait(timeout=60) == 129
    finally:
        process.kill()
    log = is_whole(tmp_path / "runs" / "kwon_1")
    assert 0 < log["time"][-1] < 2000
