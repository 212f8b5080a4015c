"""`mobman compare --engine`: one scenario in several engines, in one table."""

import json

import pytest
from typer.testing import CliRunner

from drake_mobman.analysis.compare import (
    chosen_decomposers,
    chosen_engines,
    variants_of,
)
from drake_mobman.cli import app as cli
from drake_mobman.engines import Drake, Mujoco
from drake_mobman.scenario import load_scenario


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
    options = ["--set", "duration=0.3", "--out", tmp_path]
    result = compare(name, "--engine", "drake,mujoco", *options)
    assert result.exit_code == 0, result.output
    content = json.loads((tmp_path / name / "comparison.json").read_text())
    assert [*content["engines"]] == ["drake", "mujoco"]
    assert content["engines"]["mujoco"] == {"substeps": 4, "impratio": 100.0}
    speeds = content["metrics"]["joint_speed_max"]
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
