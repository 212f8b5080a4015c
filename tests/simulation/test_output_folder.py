"""Folders that are written to: nobody else's file is touched, and ours are whole."""

import dataclasses as dc
import os
import shutil
import subprocess
import sys
from contextlib import contextmanager, suppress

import numpy as np
import pytest
from typer.testing import CliRunner

from drake_mobman.cli.app import app
from drake_mobman.figures import FIGURES
from drake_mobman.report import job
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.manifest import DRAFT, MANIFEST, hash_of, read_manifest
from drake_mobman.simulation.output_folder import FolderError, OutputFolder
from drake_mobman.simulation.simulate import simulate
from drake_mobman.teleop.live import NOBODY
from drake_mobman.teleop.recorded import COMMANDS, header, write_samples

MOBMAN = [sys.executable, "-m", "drake_mobman"]
QUICK = ["--no-figures", "--set", "duration=0.3"]
ROOT = os.geteuid() == 0


def mobman(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments])


def ran(*arguments):
    result = mobman("run", "kwon_1", *QUICK, *arguments)
    assert (result.exit_code, result.stderr) == (0, "")


def refused(*arguments):
    """Returns the one line by which the command refuses, before it simulates."""
    result = mobman(*arguments)
    assert result.exit_code == 2, result.stderr
    assert result.stdout == ""
    (line,) = result.stderr.splitlines()
    return line


def content(folder):
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


# --- Whose files these are -----------------------------------------------------------


def test_manifest_is_what_sha256sum_reads(tmp_path):
    ran("--out", tmp_path)
    folder = tmp_path / "kwon_1"
    assert set(read_manifest(folder)) == set(content(folder)) - {MANIFEST}
    if shutil.which("sha256sum"):
        subprocess.run(["sha256sum", "-c", "--quiet", MANIFEST], cwd=folder, check=True)


@pytest.fixture(scope="module")
def ours(tmp_path_factory):
    """A run folder with figures."""
    out = tmp_path_factory.mktemp("ours")
    mobman("run", "kwon_1", "--out", out, "--set", "duration=0.1")
    return out / "kwon_1"


def put(folder, name, text="mine"):
    file = folder / name
    file.parent.mkdir(exist_ok=True, parents=True)
    file.write_text(text)


@pytest.mark.parametrize(
    ("name", "named"),
    [
        ("notes.txt", "notes.txt"),
        ("figures/my_plot.py", "figures/my_plot.py"),
        ("scene.html/page", "scene.html"),
        ("mine/figures/path.png", "mine"),
        (".hidden", ".hidden"),
    ],
)
def test_what_others_put_there_is_named_and_stays(tmp_path, ours, name, named):
    folder = shutil.copytree(ours, tmp_path / "kwon_1")
    put(folder, name)
    before = content(tmp_path)
    line = refused("run", "kwon_1", *QUICK, "--out", tmp_path)
    assert f"it holds {named}, " in line
    assert content(tmp_path) == before


def test_scenario_with_comments_is_not_replaced(tmp_path):
    ran("--out", tmp_path)
    file = tmp_path / "kwon_1" / "scenario.yaml"
    file.write_text("# What I found out by this.\n" + file.read_text())
    before = content(tmp_path)
    line = refused("run", file, *QUICK, "--out", tmp_path)
    assert "it holds scenario.yaml, which was changed since we wrote it" in line
    assert content(tmp_path) == before


def test_scenario_written_by_hand_is_not_replaced(tmp_path):
    put(tmp_path / "mine", "scenario.yaml", "# By hand.\nduration: 0.2\n")
    file = tmp_path / "mine" / "scenario.yaml"
    line = refused("run", file, "--out", tmp_path)
    assert f"it holds scenario.yaml, but no {MANIFEST} that shows who wrote it" in line
    assert file.read_text() == "# By hand.\nduration: 0.2\n"


def test_folder_of_before_there_was_a_manifest_is_not_replaced(tmp_path):
    ran("--out", tmp_path)
    (tmp_path / "kwon_1" / MANIFEST).unlink()
    before = content(tmp_path)
    line = refused("run", "kwon_1", *QUICK, "--out", tmp_path)
    assert f"it holds log.npz, but no {MANIFEST} that shows who wrote it" in line
    assert content(tmp_path) == before


def test_links_are_neither_followed_nor_replaced(tmp_path):
    ran("--out", tmp_path)
    (tmp_path / "log").write_bytes((tmp_path / "kwon_1" / "log.npz").read_bytes())
    (tmp_path / "kwon_1" / "log.npz").unlink()
    (tmp_path / "kwon_1" / "log.npz").symlink_to(tmp_path / "log")
    line = refused("run", "kwon_1", *QUICK, "--out", tmp_path)
    assert "it holds log.npz, which was changed" in line


def test_field_leaves_a_persons_pictures(tmp_path):
    put(tmp_path, "field_trip.png")
    line = refused("field", "petric_guided", "--out", tmp_path)
    assert "it holds field_trip.png, " in line
    assert content(tmp_path) == {"field_trip.png": b"mine"}


def while_simulating(monkeypatch, act):
    """Has something done to the folder while the simulation goes on."""

    def acting(*args, **options):
        act()
        return simulate(*args, **options)

    monkeypatch.setattr(job, "simulate", acting)


def test_notes_put_there_while_it_runs_stay(tmp_path, monkeypatch):
    ran("--out", tmp_path)
    folder = tmp_path / "kwon_1"
    while_simulating(monkeypatch, lambda: put(folder, "notes.txt"))
    ran("--out", tmp_path, "--set", "duration=0.2")
    assert (folder / "notes.txt").read_text() == "mine"
    assert len(np.load(folder / "log.npz")["time"]) == 21


@pytest.mark.parametrize("name", ["log.npz", "scenario.yaml"])
def test_what_takes_a_files_place_meanwhile_stays_and_the_run_goes_beside(
    tmp_path, monkeypatch, name
):
    ran("--out", tmp_path)
    folder = tmp_path / "kwon_1"
    while_simulating(monkeypatch, lambda: put(folder, name))
    result = mobman("run", "kwon_1", *QUICK, "--out", tmp_path)
    assert result.exit_code == 1
    (line,) = result.stderr.splitlines()
    assert f"it holds {name}, which was put there or changed meanwhile" in line
    assert f"written to {tmp_path / 'kwon_1-2'}" in line
    assert (folder / name).read_text() == "mine"
    assert len(np.load(tmp_path / "kwon_1-2" / "log.npz")["time"]) == 31
    assert not (folder / DRAFT).exists()


def test_picture_that_has_no_place_costs_itself_alone(tmp_path, monkeypatch):
    folder = tmp_path / "kwon_1"
    while_simulating(monkeypatch, lambda: put(folder, "figures"))
    result = mobman("run", "kwon_1", "--out", tmp_path, "--set", "duration=0.3")
    assert result.exit_code == 1
    (line,) = result.stderr.splitlines()
    assert "pictures not written: " in line
    assert (folder / "figures").read_text() == "mine"
    assert {"log.npz", "metrics.json"} < read_manifest(folder).keys()


# --- Recordings ----------------------------------------------------------------------


@pytest.fixture
def recording(tmp_path):
    """The folder of a recorded session."""
    folder = tmp_path / "runs" / "s"
    folder.mkdir(parents=True)
    with (folder / COMMANDS).open("wb") as file:
        file.write(header(0.01))
        write_samples(file, np.tile(NOBODY, (200, 1)))
    (folder / "scenario.yaml").write_text("source: !Recording {}\n")
    return folder


def test_replay_never_destroys_its_recording(recording, monkeypatch):
    monkeypatch.chdir(recording.parent.parent)
    before = content(recording)
    command = ["run", "runs/s/scenario.yaml", "--set", "duration=1", "--no-figures"]
    line = refused(*command)
    assert "it holds a recorded session" in line
    assert "choose another --out" in line
    assert content(recording) == before
    assert mobman(*command, "--out", "replays").exit_code == 0
    assert content(recording) == before
    # Nor is the copy that goes with a replay replaced: nobody knows what it is of.
    assert "it holds a recorded session" in refused(*command, "--out", "replays")


# --- Paths ---------------------------------------------------------------------------


def test_run_from_inside_its_own_folder(tmp_path, monkeypatch):
    ran("--out", tmp_path)
    monkeypatch.chdir(tmp_path / "kwon_1")
    ran("--out", "..", "--set", "duration=0.2")
    assert len(np.load("log.npz")["time"]) == 21
    assert [path.name for path in tmp_path.iterdir()] == ["kwon_1"]


def test_working_folder_that_changes_meanwhile(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "elsewhere").mkdir()
    while_simulating(monkeypatch, lambda: os.chdir(tmp_path / "elsewhere"))
    ran("--out", "runs")
    assert (tmp_path / "runs" / "kwon_1" / "log.npz").exists()


@pytest.mark.parametrize("at", ["runs", "runs/kwon_1"])
def test_broken_link_is_refused(tmp_path, at):
    link = tmp_path / at
    link.parent.mkdir(exist_ok=True)
    link.symlink_to(tmp_path / "nowhere")
    line = refused("run", "kwon_1", *QUICK, "--out", tmp_path / "runs")
    assert "is a broken link" in line
    assert not (tmp_path / "nowhere").exists()


def test_links_in_a_circle_are_refused(tmp_path):
    (tmp_path / "runs").symlink_to(tmp_path / "runs")
    line = refused("run", "kwon_1", *QUICK, "--out", tmp_path / "runs")
    assert "cannot be written" in line


def test_link_to_a_folder_is_that_folder(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "runs").symlink_to(tmp_path / "there")
    ran("--out", tmp_path / "runs")
    assert (tmp_path / "there" / "kwon_1" / "log.npz").exists()


@contextmanager
def mounted(folder, options):
    """A file system of its own, if we may mount one."""
    folder.mkdir(parents=True, exist_ok=True)
    command = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)]
    if not ROOT or subprocess.run(command, capture_output=True, check=False).returncode:
        pytest.skip("needs to mount a file system")
    try:
        yield
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def test_run_folder_may_be_a_mount_point(tmp_path):
    with mounted(tmp_path / "kwon_1", "size=10m"):
        ran("--out", tmp_path)
        ran("--out", tmp_path)
        assert "log.npz" in read_manifest(tmp_path / "kwon_1")


def test_folder_that_is_read_only_is_refused_before_anything_runs(tmp_path):
    with mounted(tmp_path / "runs", "size=1m,ro"):
        line = refused("run", "kwon_1", *QUICK, "--out", tmp_path / "runs")
        assert "cannot be written, Read-only file system" in line


@pytest.mark.skipif(ROOT, reason="the superuser may write anywhere")
def test_folder_of_somebody_else_is_refused_before_anything_runs(tmp_path):
    ran("--out", tmp_path)
    (tmp_path / "kwon_1").chmod(0o555)
    line = refused("run", "kwon_1", *QUICK, "--out", tmp_path)
    assert "cannot be written, Permission denied" in line


def test_parent_need_not_be_ours(tmp_path):
    ran("--out", tmp_path)
    tmp_path.chmod(0o555)
    try:
        ran("--out", tmp_path)
    finally:
        tmp_path.chmod(0o755)


@pytest.mark.parametrize("umask", [0o000, 0o027])
def test_umask_is_respected(tmp_path, umask):
    before = os.umask(umask)
    try:
        ran("--out", tmp_path / "runs", "--set", "duration=0.1")
        mobman("graph", "kwon_1", "--out", tmp_path / "graph.dot")
        with OutputFolder(tmp_path / "runs" / "x", []) as folder:
            folder.put("figures/path.png", b"")
    finally:
        os.umask(before)
    paths = [tmp_path / "graph.dot", *(tmp_path / "runs").rglob("*")]
    assert {path.stat().st_mode & 0o777 for path in paths if path.is_file()} == {
        0o666 & ~umask
    }
    assert {path.stat().st_mode & 0o777 for path in paths if path.is_dir()} == {
        0o777 & ~umask
    }


def test_two_runs_into_one_new_folder_do_not_collide(tmp_path):
    command = [*MOBMAN, "run", "kwon_1", "--out", str(tmp_path / "runs"), *QUICK]
    pipes = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True}
    processes = [subprocess.Popen(command, **pipes) for _ in range(3)]
    ends = []
    for process in processes:
        _, said = process.communicate(timeout=120)
        ends.append((process.returncode, said))
    for status, said in ends:
        assert status == 0 or "another run is being written there" in said, said
    assert any(status == 0 for status, _ in ends)
    folder = tmp_path / "runs" / "kwon_1"
    for name, digest in read_manifest(folder).items():
        assert hash_of(folder / name) == digest


def test_a_folder_is_one_runs_at_a_time(tmp_path):
    with (
        OutputFolder(tmp_path / "x", []),
        pytest.raises(FolderError, match="another run is being written there"),
        OutputFolder(tmp_path / "x", []),
    ):
        pass
    with OutputFolder(tmp_path / "x", []):
        pass
    assert list(tmp_path.iterdir()) == []


# --- Killed between two moves --------------------------------------------------------


class Killed(BaseException):
    pass


@pytest.mark.parametrize("moves", range(5))
def test_killed_between_two_moves_the_next_one_completes_it(
    tmp_path, monkeypatch, moves
):
    """After each move; the process that is killed does nothing more, nor do we."""
    names = ["a", "figures/b", "c"]

    def publish(text, stop_after=None):
        folder = OutputFolder(tmp_path / "x", names)
        folder.__enter__()
        for name in names:
            folder.file(name).write_text(text)
        if stop_after is not None:
            replace, count = type(tmp_path).replace, []

            def counted(path, target):
                count.append(path)
                if len(count) > stop_after + 1:  # The first is the decision.
                    raise Killed
                return replace(path, target)

            monkeypatch.setattr(type(tmp_path), "replace", counted)
        try:
            folder.publish(names if text == "new" else [*names], anew=True)
        except Killed:
            os.close(folder._lock)
        else:
            folder.__exit__()
        monkeypatch.undo()

    publish("old")
    publish("new", moves)
    with OutputFolder(tmp_path / "x", names) as folder:
        texts = {(folder.path / name).read_text() for name in names}
        assert texts == {"new"}
        assert len(read_manifest(folder.path)) == 3
    assert not (tmp_path / "x" / DRAFT).exists()


# --- Each failing alone --------------------------------------------------------------


def failing(error):
    def fail(*_args, **_kwargs):
        raise error

    return fail


@pytest.mark.parametrize("error", [MemoryError(), SystemExit("Failure at mesh.cc:1")])
def test_picture_that_fails_costs_itself_alone(tmp_path, monkeypatch, error):
    fails = ("ee_velocity", "manipulability")
    figures = [
        dc.replace(one, draw=failing(error)) if one.name in fails else one
        for one in FIGURES
    ]
    monkeypatch.setattr("drake_mobman.figures.FIGURES", figures)
    result = mobman("run", "kwon_1", "--out", tmp_path, "--set", "duration=0.3")
    assert result.exit_code == 1
    (line,) = result.stderr.splitlines()
    why = str(error) or "MemoryError"
    assert line == f"mobman: kwon_1: pictures not written: {why} (and 1 more)"
    written = read_manifest(tmp_path / "kwon_1")
    assert {"log.npz", "metrics.json", "figures/path.png"} < written.keys()
    assert not {f"figures/{name}.png" for name in fails} & written.keys()


@pytest.mark.parametrize("error", [MemoryError(), SystemExit("DRAKE_DEMAND")])
def test_metrics_that_fail_cost_themselves_alone(tmp_path, monkeypatch, error):
    monkeypatch.setattr(
        "drake_mobman.analysis.metrics.window.ee_motion", failing(error)
    )
    result = mobman("run", "kwon_1", "--out", tmp_path, *QUICK)
    assert result.exit_code == 1
    (line,) = result.stderr.splitlines()
    assert line.startswith("mobman: kwon_1: metrics not computed: ")
    assert len(np.load(tmp_path / "kwon_1" / "log.npz")["time"]) == 31
    assert "versions" in (tmp_path / "kwon_1" / "metrics.json").read_text()


def test_scene_of_a_body_without_height_costs_the_scene_alone(tmp_path):
    command = [*QUICK, "--scene", "--set", "robot.shoulder_height=0"]
    result = mobman("run", "kwon_1", "--out", tmp_path, *command)
    assert result.exit_code in {1, 2}  # 2: the robot itself may be refused.
    if result.exit_code == 1:
        (line,) = result.stderr.splitlines()
        assert line.startswith("mobman: kwon_1: pictures not written: Failure at ")
        assert {"log.npz", "metrics.json"} < read_manifest(tmp_path / "kwon_1").keys()


def test_users_matplotlibrc_costs_pictures_at_most(tmp_path):
    (tmp_path / "matplotlibrc").write_text("text.usetex: true\n")
    result = subprocess.run(
        [*MOBMAN, "run", "kwon_1", "--out", "runs", "--set", "duration=0.3"],
        cwd=tmp_path,
        env=os.environ | {"PATH": ""},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert result.returncode == 1
    (line,) = result.stderr.splitlines()
    assert line.startswith("mobman: kwon_1: pictures not written: ")
    assert "latex" in line
    written = read_manifest(tmp_path / "runs" / "kwon_1")
    assert {"log.npz", "metrics.json"} < written.keys()


def test_run_that_dies_before_its_first_sample_leaves_a_folder(tmp_path, monkeypatch):
    dying = failing(RuntimeError("no diagram today"))
    monkeypatch.setattr("drake_mobman.simulation.simulate.make_diagram", dying)
    result = mobman("run", "kwon_1", "--out", tmp_path, *QUICK)
    monkeypatch.undo()
    assert result.exit_code == 1
    (line,) = result.stderr.splitlines()
    assert line.startswith("mobman: kwon_1: died at t = 0 s: no diagram today")
    folder = tmp_path / "kwon_1"
    assert "no diagram today" in (folder / "metrics.json").read_text()
    assert load_scenario(str(folder / "scenario.yaml")).duration == 0.3
    assert len(np.load(folder / "log.npz")["time"]) == 0


# --- Disks that fill up --------------------------------------------------------------


def limited(size, *arguments, cwd):
    """Runs the command where no file may grow beyond some bytes."""
    code = (
        "import resource\n"
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size}))\n"
        "from drake_mobman.__main__ import main; main()"
    )
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_log_that_cannot_grow_is_kept_as_far_as_it_goes(tmp_path):
    command = ["run", "kwon_1", "--out", "runs", "--no-figures"]
    result = limited(10**6, *command, "--set", "duration=60", cwd=tmp_path)
    assert result.returncode == 1
    (line,) = result.stderr.splitlines()
    assert "File too large; the log until then is kept" in line
    log = np.load(tmp_path / "runs" / "kwon_1" / "log.npz")
    assert 1000 < len(log["time"]) < 6001
    assert len({len(log[name]) for name in log.files}) == 1


def test_field_on_a_full_disk_leaves_the_old_pictures(tmp_path):
    with mounted(tmp_path / "disk", "size=100k"):
        out = tmp_path / "disk" / "field"
        with OutputFolder(out, []) as folder:
            folder.put("field_rest.png", b"an older one")
        before = content(out)
        with suppress(OSError), (tmp_path / "disk" / "fill").open("wb") as file:
            while True:
                file.write(b"x" * 4096)
                file.flush()
        result = mobman("field", "petric_guided", "--out", out)
        assert result.exit_code in {1, 2}
        (line,) = result.stderr.splitlines()
        assert "No space left on device" in line
        assert content(out) == before


def test_graph_on_a_full_disk_leaves_the_old_one(tmp_path):
    file = tmp_path / "graph.dot"
    mobman("graph", "kwon_1", "--out", file)
    before = file.read_bytes()
    result = limited(100, "graph", "kwon_1", "--out", "graph.dot", cwd=tmp_path)
    assert result.returncode == 1
    (line,) = result.stderr.splitlines()
    assert "not written: " in line
    assert content(tmp_path) == {"graph.dot": before}


# --- Names ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("file", "text", "says"),
    [
        (
            b"caf\xe9.yaml",
            "{duration: 0.3}",
            "a scenario's name must be printable text",
        ),
        (
            b"cafe.yaml",
            '{description: "\\ud800"}',
            "description: '\\ud800' is not valid",
        ),
    ],
    ids=["name", "description"],
)
def test_comparison_of_what_cannot_be_printed_is_refused_at_once(
    tmp_path, file, text, says
):
    name = os.fsdecode(file)
    (tmp_path / name).write_text(text)
    command = ["compare", name, "--decomposers", "blending", "--out", "cmp"]
    result = subprocess.run(
        [*MOBMAN, *command],
        cwd=tmp_path,
        capture_output=True,
        timeout=120,
        check=False,
    )
    assert result.returncode == 2
    (line,) = result.stderr.decode("ascii").splitlines()
    assert says in line
    assert os.listdir(tmp_path) == [name]
