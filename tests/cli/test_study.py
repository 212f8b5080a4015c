"""`mobman compare --over`: rows of runs, and a table of their numbers."""

import dataclasses as dc
import json

import pytest
from typer.testing import CliRunner

from drake_mobman.analysis.studies import STUDIES
from drake_mobman.analysis.studies.faults import FAULTS
from drake_mobman.analysis.studies.robots import fitted
from drake_mobman.cli.app import app
from drake_mobman.cli.study import completed_studies
from drake_mobman.robots.file import File
from drake_mobman.scenario_files import robot_paths

QUICK = 0.05  # Of each run [s].


def mobman(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments])


def test_every_robot_has_a_row_with_its_runs_numbers(tmp_path, monkeypatch):
    study = STUDIES["robots"]
    whole = study.rows
    fetch = {"fetch": robot_paths()["fetch"]}
    monkeypatch.setattr(
        "drake_mobman.analysis.studies.robots.robot_paths", lambda: fetch
    )

    def short(_self, given):
        return {
            row: {k: dc.replace(x, duration=QUICK) for k, x in runs.items()}
            for row, runs in whole(given).items()
        }

    monkeypatch.setattr(type(study), "rows", short)
    result = mobman("compare", "--over", "robots", "--out", tmp_path)
    assert result.exit_code == 0, result.stderr
    content = json.loads((tmp_path / "over_robots" / "study.json").read_text())
    runs, numbers = content["metrics"]["fetch"], content["table"]["fetch"]
    on_wheels = ["exact on wheels", "measured on wheels"]
    assert list(runs) == ["exact", "blending", *on_wheels, "guided"]
    rolling = runs["exact on wheels"]["ee_error_rms"]
    assert numbers["on wheels"] == pytest.approx(1e3 * rolling)
    assert numbers["exact"] == pytest.approx(1e3 * runs["exact"]["ee_error_rms"])
    assert numbers["hand force"] == runs["guided"]["hand_force_max"]
    page = (tmp_path / "over_robots" / "study.md").read_text()
    assert "| fetch" in page
    assert "fetch" in result.stdout


def test_every_fault_has_a_row_with_each_law_and_estimate(tmp_path, monkeypatch):
    faults = {name: FAULTS[name] for name in ("none", "delay 50 ms")}
    monkeypatch.setattr("drake_mobman.analysis.studies.faults.FAULTS", faults)
    folder = tmp_path / "out"
    result = mobman(
        *("compare", "kwon_franka", "--over", "faults"),
        *("--set", "duration=3", "--out", folder),
    )
    assert result.exit_code == 0, result.stderr
    (file,) = folder.glob("*/study.json")
    content = json.loads(file.read_text())
    assert list(content["table"]) == list(faults)
    for row, runs in content["metrics"].items():
        assert list(runs) == ["blending", "sent", "measured", "noisy"]
        numbers = content["table"][row]
        for name, run in runs.items():
            assert numbers[name] == pytest.approx(1e3 * run["ee_error_rms"])
        assert numbers["stopped"] == 0
    late = content["table"]["delay 50 ms"]
    assert late["measured"] < late["sent"] < late["blending"]


def test_a_robot_without_wheels_is_not_driven_on_them():
    assert "exact on wheels" not in fitted(File(str(robot_paths()["pr2"])))


def test_each_robot_that_comes_along_can_be_used():
    for path in robot_paths().values():
        File(str(path)).check()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--over", "nosuch"], "must be one of faults, robots"),
        (["kwon_1", "--over", "robots"], "has scenarios of its own"),
        (["--over", "faults"], "give a SCENARIO for --over faults"),
        (["petric_guided", "--over", "faults"], "needs a Teleop scenario"),
        (["kwon_1", "--over", "faults"], "!Planar has no wheels"),
        (["--over", "robots", "--decomposers", "exact"], "give it alone"),
        (["--decomposers", "exact"], "give a SCENARIO"),
        (["kwon_1"], "give --decomposers"),
    ],
)
def test_what_does_not_go_together_is_refused(arguments, says, tmp_path):
    result = mobman("compare", *arguments, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert says in result.stderr
    assert not (tmp_path / "out").exists()


def test_shell_completes_the_names_of_all_studies():
    assert completed_studies("") == list(STUDIES)
