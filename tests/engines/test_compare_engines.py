"""`mobman compare --engine`: one scenario in several engines, in one table."""

import dataclasses as dc
import json

import pytest
from typer.testing import CliRunner

from drake_mobman.analysis.compare import (
    chosen_decomposers,
    chosen_engines,
    variants_of,
)
from drake_mobman.analysis.studies import STUDIES, InEngines, Studied
from drake_mobman.cli import app as cli
from drake_mobman.engines import Drake, Mujoco
from drake_mobman.scenario import ScenarioError, load_scenario
from drake_mobman.scenario_files import robot_paths


def compare(*arguments):
    return CliRunner().invoke(cli.app, ["compare", *map(str, arguments)])


def refused(*arguments):
    """Returns the one line by which the command refuses."""
    result = compare(*arguments)
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    return line


def test_each_decomposer_runs_in_each_engine():
    scenario = load_scenario("kwon_franka", ["engine=!Mujoco {substeps: 2}"])
    decomposers = chosen_decomposers(["exact", "blending"])
    variants = variants_of(scenario, decomposers, chosen_engines(["mujoco", "!Drake"]))
    assert {name: x.engine for name, x in variants.items()} == {
        "exact, mujoco": Mujoco(substeps=2),
        "exact, drake": Drake(),
        "blending, mujoco": Mujoco(substeps=2),
        "blending, drake": Drake(),
    }


@pytest.mark.parametrize("name", ["kwon_franka", "petric_guided"])
def test_a_table_of_both_engines_is_written(tmp_path, name):
    options = ["--set", "duration=1.5", "--out", tmp_path]
    result = compare(name, "--engine", "drake,mujoco", *options)
    assert result.exit_code == 0, result.output
    content = json.loads((tmp_path / name / "comparison.json").read_text())
    assert [*content["engines"]] == ["drake", "mujoco"]
    assert content["engines"]["mujoco"] == {"substeps": 4, "impratio": 100.0}
    speeds = content["metrics"]["joint_speed_max"]
    assert speeds["drake"] > 0.01  # It moves: else they would agree on nothing.
    assert speeds["mujoco"] == pytest.approx(speeds["drake"], rel=0.05)
    assert "drake | mujoco" in (tmp_path / name / "comparison.md").read_text()


def test_an_engine_that_is_not_one_is_refused_with_those_that_are(tmp_path):
    line = refused("kwon_franka", "--engine", "drake,bullet", "--out", tmp_path)
    assert "--engine: 'bullet' is not valid; must be one of drake, mujoco" in line
    line = refused("kwon_franka", "--engine", "drake,drake", "--out", tmp_path)
    assert "must be given once" in line
    assert list(tmp_path.iterdir()) == []


def test_a_scenario_without_masses_is_refused_before_anything_runs(tmp_path):
    line = refused("kwon_1", "--engine", "drake,mujoco", "--out", tmp_path)
    assert "kwon_1: with engine=mujoco: engine: '!Mujoco' is not valid" in line
    assert list(tmp_path.iterdir()) == []


def test_without_anything_to_compare_the_options_are_named(tmp_path):
    assert "--engine NAME,..." in refused("kwon_franka", "--out", tmp_path)


@pytest.fixture
def quick_robots(monkeypatch):
    """Leaves two robots and a short run of each in the study of robots."""
    study = STUDIES["robots"]
    whole, some = study.rows, {x: robot_paths()[x] for x in ("fetch", "gen3")}
    monkeypatch.setattr(
        "drake_mobman.analysis.studies.robots.robot_paths", lambda: some
    )

    def short(_self, given):
        return {
            row: {k: dc.replace(x, duration=0.05) for k, x in runs.items()}
            for row, runs in whole(given).items()
        }

    monkeypatch.setattr(type(study), "rows", short)


@pytest.mark.usefixtures("quick_robots")
def test_a_study_in_both_engines_has_its_columns_side_by_side(tmp_path):
    options = ["--engine", "drake,mujoco", "--out", tmp_path]
    result = compare("--over", "robots", *options)
    assert result.exit_code == 0, result.output
    content = json.loads((tmp_path / "over_robots" / "study.json").read_text())
    assert [*content["table"]] == ["fetch", "gen3"]
    for row, numbers in content["table"].items():
        assert [*numbers][:4] == [
            "exact, drake",
            "exact, mujoco",
            "blending, drake",
            "blending, mujoco",
        ]
        runs = content["metrics"][row]
        assert "mujoco" in runs["exact, mujoco"]["versions"]
        for engine in ("drake", "mujoco"):
            force = runs[f"guided, {engine}"]["hand_force_max"]
            assert numbers[f"hand force, {engine}"] == force
    page = (tmp_path / "over_robots" / "study.md").read_text()
    assert "exact, drake [mm/s] | exact, mujoco [mm/s]" in page


def test_columns_of_an_engine_are_worked_out_from_its_runs_alone():
    engines = chosen_engines(["drake", "mujoco"])
    errors = {"drake": {"exact": 0.002, "blending": 0.05}, "mujoco": {"exact": 0.004}}
    of_row = {
        f"{name}, {engine}": {"ee_error_rms": error}
        for engine, runs in errors.items()
        for name, error in runs.items()
    }
    done = Studied(InEngines(STUDIES["robots"], engines), {"fetch": of_row})
    numbers = done.numbers()["fetch"]
    assert numbers["exact, drake"] == pytest.approx(2.0)
    assert numbers["exact, mujoco"] == pytest.approx(4.0)
    assert numbers["ratio, drake"] == pytest.approx(25.0)
    assert numbers["ratio, mujoco"] is None  # Of a run that is not there.


def test_a_study_refuses_an_engine_that_is_not_one(tmp_path):
    line = refused("--over", "robots", "--engine", "bullet", "--out", tmp_path)
    assert "--engine: 'bullet' is not valid; must be one of drake, mujoco" in line
    assert list(tmp_path.iterdir()) == []


def test_a_row_that_an_engine_cannot_step_is_refused_by_its_name():
    class Fidelities:
        name, help, own, columns = "fidelities", "each", True, ()

        def rows(self, _):
            return {"massless": {"run": load_scenario("kwon_1")}}

    study = InEngines(Fidelities(), chosen_engines(["mujoco"]))
    with pytest.raises(ScenarioError, match="massless: with engine=mujoco: engine"):
        study.rows(None)
