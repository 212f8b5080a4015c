"""Recordings of a session: complete, and played back to the bit.

Times here are generous: what is promised holds on a busy machine, too.
"""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from drake_mobman.console import session as session_module
from drake_mobman.console.mailbox import OperatorInput
from drake_mobman.console.recorder import PART, Recorder, complete
from drake_mobman.console.session import LiveSession
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.output_folder import FolderError, OutputFolder
from drake_mobman.simulation.run_folder import RUN, write_log
from drake_mobman.simulation.simulate import simulate
from drake_mobman.teleop.recorded import COMMANDS, read_samples

pytestmark = pytest.mark.realtime

PATIENCE = 20.0
"""Of a test that waits for what is to happen at once [s]."""


def scenario_of(name="kwon_arbitrary", *overrides):
    return load_scenario(name, overrides)


def until(condition, what):
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, what
        time.sleep(0.01)


def until_recorded(session, folder):
    """Waits until there is something of a session in a folder."""
    until(lambda: session.snapshot().recording == folder, "it records")
    until(lambda: session.snapshot().time > 0.3, "it runs")


def same(log, folder):
    """Asserts that a log is that of a run folder, bit for bit."""
    kept = np.load(folder / "log.npz")
    assert set(kept.files) == log.keys()
    for name, values in log.items():
        assert kept[name].tobytes() == values.tobytes(), name


def mess_about(session, seconds, seed):
    """Drives as a child would, over a link that is as bad."""
    rng = np.random.default_rng(seed)
    end = time.monotonic() + seconds
    sequence = 0
    while time.monotonic() < end:
        for held in (False, True):
            command = rng.uniform(-0.4, 0.4, 3) * held
            for _ in range(int(rng.integers(3, 40 if held else 8))):
                sequence += 1
                late = int(rng.integers(0, 3)) if rng.random() < 0.2 else 0
                said = OperatorInput(sequence - late, *command, held)
                session.send(said)
                time.sleep(rng.uniform(0.001, 0.03))
        event = rng.random()
        if event < 0.2:
            session.send(OperatorInput(sequence + 1, float("nan"), 0, 0, True))
        elif event < 0.3:
            session.stop("a child")
        elif event < 0.5:
            time.sleep(0.3)
        elif event < 0.9:
            session.choose(session.choices[int(rng.integers(len(session.choices)))])


@pytest.mark.parametrize("name", ["kwon_spatial", "petric_guided"])
def test_recorded_session_is_played_back_bit_for_bit(name, tmp_path):
    folder = tmp_path / "session"
    with LiveSession(scenario_of(name), record=folder) as session:
        mess_about(session, 5.0, seed=1)
        assert session.snapshot().recording == folder
    assert session.snapshot().problem == ""
    assert {path.name for path in folder.iterdir()} == {
        "scenario.yaml",
        "log.npz",
        "metrics.json",
        "figures",
        "manifest.sha256",
        COMMANDS,
    }
    run = simulate(load_scenario(str(folder / "scenario.yaml")))
    assert run.log["time"][-1] > 3.0
    assert len(np.unique(run.log["gate_status"])) > 2
    assert np.abs(run.log["arm_velocity"]).max() > 0.05
    same(run.log, folder)


KILLED = """
import sys, time
from pathlib import Path
from drake_mobman.console.mailbox import OperatorInput
from drake_mobman.console.session import LiveSession
from drake_mobman.scenario import load_scenario

session = LiveSession(load_scenario("kwon_spatial"), record=Path(sys.argv[1]))
k = 0
while True:
    k += 1
    session.send(OperatorInput(k, 0.2 * (k > 10), 0.1 * (k > 10), 0.0, k > 10))
    time.sleep(0.02)
    print(session.snapshot().time, flush=True)
"""


def test_killed_session_loses_at_most_its_last_second(tmp_path):
    folder = tmp_path / "killed"
    process = subprocess.Popen(
        [sys.executable, "-c", KILLED, folder], stdout=subprocess.PIPE, text=True
    )
    end = time.monotonic() + PATIENCE
    while (shown := float(process.stdout.readline())) < 2.5:
        assert time.monotonic() < end
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    assert (folder / PART).exists()
    scenario = load_scenario(str(folder / "scenario.yaml"))
    assert scenario.duration > shown - 1.0
    run = simulate(scenario)
    assert run.died == ""
    assert run.log["time"][-1] == scenario.duration
    said = read_samples(folder / COMMANDS)
    assert run.log["operator_input"].tobytes() == said.tobytes()
    assert np.abs(run.log["ee_command"]).max() == 0.2


def test_each_recording_after_a_reset_has_a_folder_of_its_own(tmp_path):
    folder = tmp_path / "session"
    with LiveSession(scenario_of(), record=folder) as session:
        shown = session.snapshot
        until_recorded(session, folder)
        session.reset()
        second = tmp_path / "session-2"
        until_recorded(session, second)
        session.record(None)
        until(lambda: shown().recording is None, "it ends")
        assert shown().time > 0.3  # The session goes on.
        session.record(tmp_path / "other")
        until(lambda: shown().recording == tmp_path / "other", "it records again")
    for name in ("session", "session-2", "other"):
        run = simulate(load_scenario(str(tmp_path / name / "scenario.yaml")))
        same(run.log, tmp_path / name)


def test_recordings_go_past_what_exists_on_disk(tmp_path):
    folder = tmp_path / "session"
    (tmp_path / "session-2").mkdir()
    (tmp_path / "session-2" / COMMANDS).write_text("an hour of a person's work")
    (tmp_path / "session-3").write_text("a file")
    with LiveSession(scenario_of(), record=folder) as session:
        until_recorded(session, folder)
        session.reset()
        until_recorded(session, tmp_path / "session-4")
    assert session.snapshot().problem == ""
    work = (tmp_path / "session-2" / COMMANDS).read_text()
    assert work == "an hour of a person's work"
    # Nor is one replaced that another session has left.
    before = (folder / COMMANDS).read_bytes()
    with pytest.raises(FolderError, match="it holds a recorded session"):
        LiveSession(scenario_of(), record=folder)
    assert (folder / COMMANDS).read_bytes() == before


def test_folder_of_an_ordinary_run_is_recorded_to(tmp_path):
    folder = tmp_path / "kwon_1"
    with OutputFolder(folder, RUN) as place:
        write_log(simulate(scenario_of("kwon_1", "duration=0.1")), place)
    with LiveSession(scenario_of(), record=folder) as session:
        until(lambda: session.snapshot().time > 0.3, "it runs")
    assert len(read_samples(folder / COMMANDS)) > 20


def test_recording_too_short_to_be_played_back_leaves_no_folder(tmp_path):
    recorder = Recorder(scenario_of(), tmp_path / "session")
    assert not recorder.plays
    recorder.drop()
    assert list(tmp_path.iterdir()) == []
    with LiveSession(scenario_of(), record=tmp_path / "session") as session:
        for wait in np.linspace(0.0, 0.05, 8):
            session.reset()
            time.sleep(wait)
        # However busy the machine is.
        until(lambda: session.snapshot().time > 0.1, "the last one records")
    assert session.snapshot().problem == ""
    assert (tmp_path / "session").exists()
    for folder in tmp_path.iterdir():
        load_scenario(str(folder / "scenario.yaml"))
        assert (folder / "metrics.json").exists()


def test_folder_that_cannot_be_completed_is_told_of_while_one_drives_on(tmp_path):
    folder = tmp_path / "session"
    with LiveSession(scenario_of(), record=folder) as session:
        shown = session.snapshot
        until_recorded(session, folder)
        (folder / PART).unlink()
        session.reset()
        until(lambda: shown().problem, "it is told of")
        why = f"{folder}: recorded, but not completed: FileNotFoundError: "
        assert shown().problem.startswith(why)
        # Also after what goes on well.
        session.reset()
        until(lambda: shown().recording == tmp_path / "session-3", "it records on")
    assert session.snapshot().problem.startswith(why)


def test_figures_that_cannot_be_drawn_cost_no_log(tmp_path, monkeypatch):
    recorder = Recorder(scenario_of(), tmp_path / "session")
    run = simulate(scenario_of("kwon_arbitrary", "source=operator", "duration=0.2"))
    recorder.append(run.log)
    recorder.close()

    def full(*_args, **_kwargs):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Figure, "savefig", full)
    with pytest.raises(OSError, match="No space left"):
        complete(recorder.folder, 0.2)
    same(run.log, recorder.folder)


def test_folder_of_something_else_is_refused_before_anything_runs(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(FolderError, match=r"thesis\.tex"):
        LiveSession(scenario_of(), record=tmp_path)
    assert (tmp_path / "thesis.tex").exists()


def test_session_that_dies_says_so_in_a_line_and_keeps_its_log(tmp_path, monkeypatch):
    def failing(_diagram, context):
        if context.get_time() > 0.5:
            raise ArithmeticError("arm_position is not\nfinite any more")

    monkeypatch.setattr(session_module, "check_finite", failing)
    folder = tmp_path / "session"
    with LiveSession(scenario_of(), record=folder) as session:
        until(lambda: session.snapshot().died, "it dies")
        died = session.snapshot().died
        assert died == "died at t = 0.51 s: arm_position is not finite any more"
        assert session.snapshot().text.startswith(died)
        session.send(OperatorInput(1))  # Nobody is disturbed.
        session.stop("a viewer")
        monkeypatch.undo()
        session.reset()
        until(lambda: not session.snapshot().died, "it starts over")
    numbers = json.loads((folder / "metrics.json").read_text())
    assert numbers["died"] == died
    assert np.load(folder / "log.npz")["time"][-1] == 0.51
    assert (tmp_path / "session-2" / "log.npz").exists()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("file", ["_commands", "_log"])
def test_recording_that_cannot_be_written_does_not_stop_the_session(tmp_path, file):
    folder = tmp_path / "session"
    with LiveSession(scenario_of(), record=folder) as session:
        until(lambda: session.snapshot().time > 0.5, "it records")
        # A disk that is full: what has been written stays, nothing more gets there.
        with Path("/dev/full").open("ab") as full:
            os.dup2(
                full.fileno(), getattr(session._recordings._recorder, file).fileno()
            )
        until(lambda: session.snapshot().problem, "it notices")
        assert session.snapshot().problem == (
            "recording ended: [Errno 28] No space left on device"
        )
        until(lambda: session.snapshot().recording is None, "it ends")
        time_ = session.snapshot().time
        until(lambda: session.snapshot().time > time_ + 0.1, "it goes on")
        assert session.snapshot().died == ""
    # What had been written before is a run folder.
    run = simulate(load_scenario(str(folder / "scenario.yaml")))
    assert run.log["time"][-1] > 0.1
    same(run.log, folder)
