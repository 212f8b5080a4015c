"""`mobman robot`: from a model to runs with figures, without editing a file by hand."""

import pytest
from typer.testing import CliRunner

from drake_mobman.cli.app import app
from drake_mobman.scenario import load_scenario

TIAGO = (
    "package://example-robot-data/robots/tiago_description/robots/tiago_no_hand.urdf"
)


def mobman(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments])


def refused(*arguments):
    """Returns the one line by which the command refuses."""
    result = mobman(*arguments)
    assert result.exit_code == 2
    assert result.stdout == ""
    (line,) = result.stderr.splitlines()
    return line


@pytest.fixture(scope="module")
def drafted(tmp_path_factory):
    """Returns a robot file, as `mobman robot new` prints it."""
    result = mobman("robot", "new", TIAGO, "--tool", "wrist_ft_tool_link")
    assert result.exit_code == 0, result.stderr
    file = tmp_path_factory.mktemp("robots") / "mine.robot.yaml"
    file.write_text(result.stdout)
    return file


def test_model_becomes_a_run_with_figures_without_an_editor(drafted, tmp_path):
    made = mobman("robot", "scenario", drafted, "--out", tmp_path)
    assert made.exit_code == 0, made.stderr
    files = [tmp_path / "mine_kwon.yaml", tmp_path / "mine_guided.yaml"]
    assert all(load_scenario(file).robot for file in files)
    out = tmp_path / "runs"
    quick = ["--out", out, "--set", "duration=0.1"]
    ran = mobman("run", files[0], *quick)
    assert ran.exit_code == 0, ran.stderr
    assert any((out / "mine_kwon" / "figures").glob("*.png"))
    ran = mobman("run", files[1], "--no-figures", *quick)
    assert ran.exit_code == 0, ran.stderr
    assert (out / "mine_guided" / "metrics.json").exists()


def test_scenario_names_its_robot_by_a_path_from_where_it_is(drafted, tmp_path):
    folder = tmp_path / "deep" / "down"
    assert mobman("robot", "scenario", drafted, "--out", folder).exit_code == 0
    text = (folder / "mine_kwon.yaml").read_text()
    assert "!File {path: ../../" in text
    again = refused("robot", "scenario", drafted, "--out", folder)
    assert "is there already" in again


def test_robot_that_comes_along_is_named(tmp_path):
    assert mobman("robot", "scenario", "fetch", "--out", tmp_path).exit_code == 0
    assert "!File {path: fetch}" in (tmp_path / "fetch_kwon.yaml").read_text()


def test_check_prints_what_is_given_and_what_is_derived(drafted, tmp_path):
    bare = tmp_path / "bare.robot.yaml"
    lines = drafted.read_text().splitlines()
    bare.write_text("\n".join(x for x in lines if "wheel_radius" not in x))
    picture = tmp_path / "bare.png"
    result = mobman("robot", "check", bare, "--draw", picture)
    assert result.exit_code == 0, result.stderr
    lines = [x for x in result.stdout.splitlines() if x.startswith("  ") and x.strip()]
    rows = {line.split()[0]: line for line in lines}
    assert "0.0985 m" in rows["wheel_radius"]
    assert "radius of" in rows["wheel_radius"]
    assert "given" in rows["track"]
    assert "warning: limits: the model's acceleration limit is missing" in result.stderr
    assert {"B", "S", "T", "r_f", "posture", "l", "psi", "z", "field"} <= rows.keys()
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["check", "nosuch"], "no such robot; valid names are fetch"),
        (["check", "fetch", "--draw", "fetch.jpg"], "must end in .png"),
        (["scenario", "nosuch.robot.yaml"], "no such robot"),
        (["new", "nosuch.urdf", "--tool", "E"], "must be a file"),
        (["new", TIAGO, "--tool", "hand"], "must be a link or frame; near are"),
        (["new", TIAGO, "--tool", "E", "--package", "mine"], "must be NAME=FOLDER"),
        (["new", TIAGO, "--tool", "E", "--at", "deck"], "give --on too"),
        (["new", "package://none/a.urdf", "--tool", "E"], "package none is not found"),
    ],
)
def test_bad_input_ends_in_one_line(arguments, says):
    assert says in refused("robot", *arguments)
