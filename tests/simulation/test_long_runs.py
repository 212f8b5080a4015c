"""Runs that are long: in bounded memory, thinned if asked, and refused if too long."""

import dataclasses as dc
import itertools
import json
import os
import resource
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from drake_mobman.diagrams import make_diagram
from pydrake.systems.analysis import Simulator
from typer.testing import CliRunner

from drake_mobman.analysis.metrics import metrics
from drake_mobman.cli.app import app
from drake_mobman.report.pictures import PICTURED, figures, shown_of
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation import log as log_module
from drake_mobman.simulation import npz
from drake_mobman.simulation.log import (
    StoredLog,
    finite_rows,
    head,
    read_log,
    windows,
)
from drake_mobman.simulation.npz import write_npz
from drake_mobman.simulation.simulate import Run, simulate

QUICK = ["--no-figures", "--set", "duration=0.3"]


def mobman(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments])


@contextmanager
def little_memory():
    """Leaves a gigabyte more than there is in use: who fills memory fails."""
    before = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    used = pages * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + (1 << 30), before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def refused(tmp_path, *arguments):
    """Returns the one line by which it is refused, before anything is simulated."""
    with little_memory():
        result = mobman(*arguments, "--out", tmp_path / "runs")
    assert result.exit_code == 2, result.stderr
    assert not (tmp_path / "runs").exists()
    (line,) = result.stderr.splitlines()
    return line


# --- Too long ------------------------------------------------------------------------


@pytest.mark.parametrize("setting", ["duration=1e9", "period=1e-12"])
def test_log_that_has_no_room_is_refused_by_its_size(tmp_path, setting):
    line = refused(tmp_path, "run", "kwon_1", "--set", setting)
    # Where no range has refused it before.
    assert "samples" in line or "must be within" in line
    assert "of disk" in line or "must be within" in line


def test_size_of_a_log_is_that_of_what_is_logged(tmp_path, monkeypatch):
    monkeypatch.setattr("drake_mobman.simulation.size._disk", lambda _: 10**6)
    result = mobman("run", "kwon_1", "--out", tmp_path, "--set", "duration=1000")
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    part = tmp_path / "part"
    simulate(load_scenario("kwon_1", ["duration=1"]), part=part)
    with part.open("rb") as file:
        row = 8 * sum(json.loads(file.readline()).values())
    size = 2 * 100_001 * row / 1e6
    assert f"makes 1e+05 samples at a period of 0.01 s, {size:.3g} MB of log" in line
    assert "there are 1 MB of disk" in line
    assert list(tmp_path.iterdir()) == [part]


@pytest.mark.parametrize(
    ("name", "settings", "key"),
    [
        ("kwon_1", ["source.repeat=1000000"], "source.repeat"),
        ("kwon_arbitrary", ["source.repeat=99999"], "source.repeat"),
        ("kwon_1", ["fidelity=servo", "fidelity.step=1e-12"], "fidelity.step"),
    ],
)
def test_what_would_never_be_built_or_end_is_refused(tmp_path, name, settings, key):
    sets = [word for setting in settings for word in ("--set", setting)]
    line = refused(tmp_path, "run", name, *sets)
    assert f"{key}: " in line
    assert "is not valid; " in line


def test_what_has_no_room_in_memory_is_refused_in_programs_too():
    scenario = dc.replace(load_scenario("kwon_1"), duration=9e9)
    with pytest.raises(ValueError, match=r"samples .* of memory"):
        simulate(scenario)


@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_recording_that_never_ends_is_refused(tmp_path, kind):
    if kind == "pipe":
        os.mkfifo(tmp_path / "commands.bin")
    else:
        (tmp_path / "commands.bin").symlink_to("/dev/zero")
    (tmp_path / "s.yaml").write_text("source: !Recording {}")
    line = refused(tmp_path, "run", tmp_path / "s.yaml")
    assert "must be a recorded session" in line


# --- The log on disk -----------------------------------------------------------------


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    """The same run's log by Drake's own logger, in memory, and on disk."""
    scenario = load_scenario("kwon_arbitrary", ["duration=25"])
    diagram = make_diagram(scenario)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(25.0)
    part = tmp_path_factory.mktemp("logs") / "part"
    stored = simulate(scenario, part=part)
    return (
        read_log(diagram, simulator.get_context()),
        simulate(scenario).log,
        stored.log,
        stored,
        part,
    )


def test_log_is_the_same_in_memory_and_on_disk_to_the_bit(logs):
    whole, in_memory, stored, *_ = logs
    assert list(whole) == list(in_memory) == list(stored)
    for name, x in whole.items():
        for other in (in_memory[name], stored[name]):
            assert other.shape == x.shape
            assert other.tobytes() == x.tobytes(), name


def test_log_that_is_cut_off_is_read_as_far_as_it_is_whole(logs, tmp_path):
    whole, *_, part = logs
    cut = tmp_path / "cut"
    cut.write_bytes(part.read_bytes()[:-1])
    assert len(StoredLog(cut)["time"]) == len(whole["time"]) - 1
    cut.write_bytes(b"")
    assert len(StoredLog(cut)["time"]) == 0


def test_npz_is_what_numpy_would_write(logs, tmp_path, monkeypatch):
    whole, _, stored, *_ = logs
    monkeypatch.setattr(npz, "WINDOW", 700)
    write_npz(tmp_path / "log.npz", stored)
    np.savez_compressed(tmp_path / "numpy.npz", **whole)
    ours, theirs = np.load(tmp_path / "log.npz"), np.load(tmp_path / "numpy.npz")
    assert ours.files == theirs.files
    for name in theirs.files:
        assert ours[name].dtype == theirs[name].dtype
        assert ours[name].shape == theirs[name].shape
        assert ours[name].tobytes() == theirs[name].tobytes(), name


@pytest.mark.parametrize("every", [2, 7, 900])
def test_npz_is_thinned_evenly_from_the_first_sample(
    logs, tmp_path, monkeypatch, every
):
    whole, _, stored, *_ = logs
    monkeypatch.setattr(npz, "WINDOW", 100)
    write_npz(tmp_path / "log.npz", stored, every)
    thinned = np.load(tmp_path / "log.npz")
    for name, x in whole.items():
        assert thinned[name].tobytes() == x[::every].tobytes(), name


def test_windows_show_every_sample_once_and_some_twice(logs, monkeypatch):
    whole, _, stored, *_ = logs
    monkeypatch.setattr(log_module, "WINDOW", 600)
    seen = list(windows(stored, before=2))
    assert [shown for shown, _ in seen] == [0, 2, 2, 2, 2]
    for name, x in whole.items():
        fresh = np.concatenate([log[name][shown:] for shown, log in seen])
        assert fresh.tobytes() == x.tobytes(), name
    for (_, before), (_, after) in itertools.pairwise(seen):
        assert before["time"][-2:].tobytes() == after["time"][:2].tobytes()


@pytest.mark.parametrize("bad", [0, 1, 599, 600, 2400])
def test_first_sample_that_is_not_finite_is_found_in_any_window(logs, monkeypatch, bad):
    whole, *_ = logs
    monkeypatch.setattr(log_module, "WINDOW", 600)
    log = head(whole, len(whole["time"]))
    log["base_command"][bad, 1] = np.inf
    assert finite_rows(log) == bad
    assert finite_rows(whole) == len(whole["time"])


# --- What is worked out of it --------------------------------------------------------


def flat(numbers, prefix=""):
    for key, value in numbers.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("kwon_arbitrary", ["duration=25", "guard.max_v_c=0.2"]),
        ("kwon_dither", ["decomposer=switching", "duration=12"]),
        ("petric_teleop", ["duration=6"]),
        ("petric_hold", ["duration=8"]),
    ],
)
@pytest.mark.parametrize("window", [3, 97, 400])
def test_metrics_do_not_depend_on_the_windows(monkeypatch, name, overrides, window):
    run = simulated_once(name, tuple(overrides))
    whole = dict(flat(metrics(run)))
    monkeypatch.setattr(log_module, "WINDOW", window)
    if window < 50:
        run = dc.replace(run, log=head(run.log, 100))
        monkeypatch.setattr(log_module, "WINDOW", 10**9)
        whole = dict(flat(metrics(run)))
        monkeypatch.setattr(log_module, "WINDOW", window)
    by_windows = dict(flat(metrics(run)))
    assert by_windows.keys() == whole.keys()
    for key, value in whole.items():
        if isinstance(value, float):
            # Sums are rounded in another order.
            assert by_windows[key] == pytest.approx(value, rel=1e-12, abs=1e-13), key
        else:
            assert by_windows[key] == value, key


_RUNS = {}


def simulated_once(name, overrides):
    if (name, overrides) not in _RUNS:
        run = simulate(load_scenario(name, overrides))
        assert run.died == ""
        _RUNS[name, overrides] = run
    return _RUNS[name, overrides]


def test_log_period_thins_the_log_and_nothing_else(tmp_path):
    plain = ["run", "kwon_arbitrary", "--no-figures", "--set", "duration=3"]
    assert mobman(*plain, "--out", tmp_path / "a").exit_code == 0
    thin = [*plain, "--log-period", "0.07"]
    assert mobman(*thin, "--out", tmp_path / "b").exit_code == 0
    a, b = tmp_path / "a" / "kwon_arbitrary", tmp_path / "b" / "kwon_arbitrary"
    whole, thinned = np.load(a / "log.npz"), np.load(b / "log.npz")
    for name in whole.files:
        assert thinned[name].tobytes() == whole[name][::7].tobytes(), name
    one, two = (json.loads((x / "metrics.json").read_text()) for x in (a, b))
    timed = ("step_time_us", "real_time_factor")
    for key in one.keys() - set(timed):
        assert one[key] == two[key], key
    assert (a / "scenario.yaml").read_bytes() == (b / "scenario.yaml").read_bytes()
    # From the scenario of a thinned run, the whole run again.
    again = ["run", b / "scenario.yaml", "--no-figures", "--out", tmp_path / "c"]
    assert mobman(*again).exit_code == 0
    rerun = np.load(tmp_path / "c" / "kwon_arbitrary" / "log.npz")
    for name in whole.files:
        assert rerun[name].tobytes() == whole[name].tobytes(), name


@pytest.mark.parametrize("given", ["0.015", "0.001", "0", "-0.01", "nan", "inf"])
def test_log_period_that_is_no_multiple_is_refused(tmp_path, given):
    command = ["run", "kwon_1", *QUICK, f"--log-period={given}", "--out", tmp_path]
    result = mobman(*command)
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert "must be a multiple of the period, 0.01" in line
    assert list(tmp_path.iterdir()) == []


def test_pictures_of_a_long_run_say_what_they_show(monkeypatch):
    run = simulated_once("petric_hold", ("duration=8",))
    assert len(run.log["time"]) < PICTURED
    assert shown_of(run) == ""
    monkeypatch.setattr("drake_mobman.report.pictures.PICTURED", 301)
    assert shown_of(run) == "the first 3 of 8 s"
    texts = []
    monkeypatch.setattr(
        "drake_mobman.report.pictures.png",
        lambda figure: texts.append([text.get_text() for text in figure.texts]) or b"",
    )
    figures(run)["figures/path.png"]()
    assert texts == [["the first 3 of 8 s"]]


PEAK = """
import resource, sys
from drake_mobman.cli.app import app
try:
    app(["run", "kwon_1", "--out", sys.argv[2], "--no-figures",
         "--set", "compiled=true", "--set", f"duration={sys.argv[1]}"])
except SystemExit:
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@pytest.mark.slow
def test_memory_does_not_grow_with_the_simulated_time(tmp_path):
    def peak(hours):
        result = subprocess.run(
            [
                sys.executable,
                "-c",
                PEAK,
                str(3600 * hours),
                tmp_path / str(hours),
            ],
            capture_output=True,
            text=True,
            check=True,
        )
        return int(result.stdout.splitlines()[-1]) / 1024  # [MB].

    one, four = peak(1), peak(4)
    assert four < one + 30, (one, four)


def test_run_with_a_log_on_disk_is_a_run_like_any_other(logs):
    *_, run, _ = logs
    assert isinstance(run, Run)
    numbers = metrics(run)
    assert numbers["ee_error_rms"] is not None
