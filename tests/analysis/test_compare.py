"""Decomposers compared: one table, one figure, and what is refused."""

import errno
import json
import typing
from contextlib import contextmanager

import numpy as np
import pytest
from matplotlib.figure import Figure
from pydrake.systems.framework import LeafSystem
from typer.testing import CliRunner

from drake_mobman import signals
from drake_mobman.analysis.compare import (
    chosen_decomposers,
    compared,
    decomposers_by_name,
    variants_of,
    with_each,
)
from drake_mobman.analysis.markdown import markdown_table
from drake_mobman.analysis.metrics import metrics
from drake_mobman.cli import app as cli
from drake_mobman.decomposers.blending import Blending
from drake_mobman.decomposers.decomposer import declare_decomposer_ports
from drake_mobman.decomposers.switching import Switching
from drake_mobman.figures.comparison import draw_comparison
from drake_mobman.figures.style import LIMIT
from drake_mobman.parameters import ParameterError
from drake_mobman.scenario import Teleop, load_scenario
from drake_mobman.simulation.simulate import simulate

FILES = [
    *("comparison.json", "comparison.md", "comparison.png"),
    *("manifest.sha256", "scenario.yaml"),
]
BOTH = ["--decomposers", "blending,switching"]
SHORT = [
    *("--set", "start.l=0.45"),
    *("--set", "robot={upper_link: 0.2, lower_link: 0.25}"),
]
"""An arm too short for a velocity field."""

TIMED = ("step_time_us", "real_time_factor")
"""Metrics that no two runs have the same."""


def compare(*arguments):
    return CliRunner().invoke(cli.app, ["compare", *map(str, arguments)])


def refused(*arguments):
    """Returns the one line by which the command refuses."""
    result = compare(*arguments)
    assert result.exit_code == 2
    assert result.stdout == ""
    (line,) = result.stderr.splitlines()
    return line


def files_in(folder):
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())


def content_of(folder):
    return json.loads((folder / "comparison.json").read_text())


def untimed(table):
    return {key: row for key, row in table.items() if not key.startswith(TIMED)}


@pytest.fixture
def dying(monkeypatch):
    """Has the switching decomposer fail at half a second."""

    class Dying(LeafSystem):
        def __init__(self, joints):
            super().__init__()
            calc = self.fail_later
            declare_decomposer_ports(self, joints, calc, calc, calc)

        def fail_later(self, context, output):
            if context.get_time() > 0.495:
                raise RuntimeError("the law | fell over [here]")
            output.SetFromVector(np.zeros(output.size()))

    def build(_self, setup):
        return Dying(setup.arm.num_joints)

    monkeypatch.setattr(Switching, "build", build)


def test_names_are_those_that_a_scenario_takes():
    names = decomposers_by_name()
    assert {"blending", "switching", "velocityfield"} <= set(names)
    members = typing.get_args(typing.get_type_hints(Teleop)["decomposer"])
    assert list(names.values()) == list(members)
    for name, kind in names.items():
        scenario = load_scenario("kwon_arbitrary", [f"decomposer={name.upper()}"])
        assert type(scenario.decomposer) is kind


def test_decomposers_come_in_the_order_given_and_in_any_case():
    chosen = chosen_decomposers([" Switching", "!BLENDING"])
    assert list(chosen.items()) == [("switching", Switching), ("blending", Blending)]


def test_each_scenario_gets_a_folder_with_a_column_for_each_decomposer(tmp_path):
    out = tmp_path / "new" / "cmp"
    command = ["kwon_1", "kwon_3", *BOTH, "--out", out, "--set", "duration=2"]
    result = compare(*command)
    assert result.exit_code == 0
    assert files_in(out) == [f"{s}/{f}" for s in ("kwon_1", "kwon_3") for f in FILES]
    for name in ("kwon_1", "kwon_3"):
        content = content_of(out / name)
        assert content["scenario"] == name
        assert content["versions"].keys() == {"drake", "python", "drake_mobman"}
        for row in content["metrics"].values():
            assert list(row) == ["blending", "switching"]
        assert name in result.stdout
    assert "ee_error_rms" in result.stdout
    assert result.stderr == ""


def test_table_is_the_metrics_of_runs_by_themselves(tmp_path):
    overrides = ["duration=4", "start.l=1.55"]
    sets = [word for override in overrides for word in ("--set", override)]
    assert compare("kwon_1", *BOTH, "--out", tmp_path, *sets).exit_code == 0
    table = content_of(tmp_path / "kwon_1")["metrics"]
    page = (tmp_path / "kwon_1" / "comparison.md").read_text()
    for name in ("blending", "switching"):
        scenario = load_scenario("kwon_1", [*overrides, f"decomposer={name}"])
        numbers = metrics(simulate(scenario))
        for key in ("ee_error_rms", "base_speed_max", "base_jerk_rms"):
            assert table[key][name] == numbers[key]
        excess = numbers["workspace_excess_max"]["l"]
        assert table["workspace_excess_max.l"][name] == excess
        assert f" {excess:.4g} |" in page
    # Switching, the base takes over within a tick of L_max; blending, past it.
    excess = table["workspace_excess_max.l"]
    assert excess["switching"] <= 0.35 * 0.01 < 0.02 < excess["blending"]
    assert table["died"] == {"blending": None, "switching": None}


def test_own_decomposer_keeps_its_parameters_and_others_have_defaults(tmp_path):
    sets = ["--set", "duration=1", "--set", "decomposer.alpha=9"]
    compare("kwon_1", *BOTH, "--out", tmp_path, *sets)
    params = content_of(tmp_path / "kwon_1")["decomposers"]
    projection = {"projection": {"sigma": 0.5}}
    assert params == {
        "blending": {"alpha": 9.0, "beta": 21.0, "share": "tanh"} | projection,
        "switching": projection,
    }
    scenario = load_scenario("kwon_1", ["decomposer=switching"])
    variants = with_each(scenario, chosen_decomposers(["blending"]))
    assert variants["blending"].decomposer == Blending()
    # How the base's speed follows from its share is the same for all.
    scenario = load_scenario("kwon_1", ["decomposer.projection.sigma=0.3"])
    variants = with_each(scenario, chosen_decomposers(["switching"]))
    assert variants["switching"].decomposer.projection.sigma == 0.3
    # How sharp goes by the size of the workspace; the share is the decomposer's own.
    scenario = load_scenario("kwon_franka")
    variants = with_each(scenario, chosen_decomposers(["blending", "diffik"]))
    assert variants["blending"].decomposer == Blending(alpha=60.0, share="tanh")


def test_resolved_scenario_reproduces_the_comparison(tmp_path):
    sets = ["--set", "duration=3", "--set", "decomposer.alpha=9"]
    compare("kwon_arbitrary", *BOTH, "--out", tmp_path / "a", *sets)
    first = tmp_path / "a" / "kwon_arbitrary"
    again = compare(first / "scenario.yaml", *BOTH, "--out", tmp_path / "b")
    assert again.exit_code == 0
    one, two = content_of(first), content_of(tmp_path / "b" / "kwon_arbitrary")
    assert untimed(one["metrics"]) == untimed(two["metrics"])
    assert one["decomposers"] == two["decomposers"]


def test_comparison_replaces_an_older_one_whole(tmp_path):
    compare("kwon_1", *BOTH, "--out", tmp_path, "--set", "duration=1")
    compare("kwon_1", "--decomposers", "switching", "--out", tmp_path)
    assert list(content_of(tmp_path / "kwon_1")["decomposers"]) == ["switching"]
    assert files_in(tmp_path) == [f"kwon_1/{file}" for file in FILES]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["kwon_1", "--decomposers", "blending,nosuch"], "'nosuch' is not valid; must"),
        (["kwon_1", "--decomposers", "nosuch"], "must be one of "),
        (["kwon_1", "--decomposers", "blending,"], "'' is not valid"),
        (["kwon_1", "--decomposers", "blending,Blending"], "must be given once"),
        (["kwon_1", "petric_guided", *BOTH], "petric_guided: !Guided has no command"),
        (["petric_guided", *BOTH], "must be !Teleop"),
        (["kwon_1", *BOTH, "--set", "source=external"], "is fed by a program"),
        (["kwon_1", "kwon_1", *BOTH], "is given twice"),
        (["kwon_1", "nosuch", *BOTH], "no such scenario"),
        (["kwon_1", *BOTH, "--set", "duratoin=1"], "valid keys are"),
        (
            ["kwon_1", "--decomposers", "blending,velocityfield", *SHORT],
            "kwon_1: with decomposer=velocityfield: decomposer.Delta_r: 0.1 is not",
        ),
    ],
)
def test_bad_input_is_refused_before_anything_runs(
    tmp_path, monkeypatch, arguments, says
):
    monkeypatch.setattr("drake_mobman.simulation.simulate.simulate", None)
    assert says in refused(*arguments, "--out", tmp_path / "cmp")
    assert list(tmp_path.iterdir()) == []


def test_a_decomposer_that_cannot_be_built_is_refused_before_anything_runs(
    tmp_path, monkeypatch
):
    def picky(*_):
        raise ParameterError("robot", "Planar", "must be another")

    monkeypatch.setattr(Switching, "build", picky)
    line = refused("kwon_1", *BOTH, "--out", tmp_path / "cmp")
    assert "with decomposer=switching: decomposer.robot: 'Planar' is not valid" in line
    assert "kwon_1: " in line
    assert list(tmp_path.iterdir()) == []


def test_folder_with_something_else_in_it_is_not_replaced(tmp_path):
    mine = tmp_path / "kwon_1" / "log.npz"
    mine.parent.mkdir()
    mine.write_text("a run's")
    line = refused("kwon_1", *BOTH, "--out", tmp_path)
    assert "it holds log.npz, which would be lost" in line
    assert files_in(tmp_path) == ["kwon_1/log.npz"]


@pytest.mark.usefixtures("dying")
def test_a_run_that_dies_stands_in_the_table_and_the_others_with_it(tmp_path):
    result = compare("kwon_1", *BOTH, "--out", tmp_path, "--set", "duration=1")
    assert result.exit_code == 1
    (line,) = result.stderr.splitlines()
    assert line.startswith("mobman: kwon_1, switching: died at t = 0.")
    table = content_of(tmp_path / "kwon_1")["metrics"]
    assert table["died"]["blending"] is None
    assert "fell over [here]" in table["died"]["switching"]
    assert "fell" in result.stdout
    assert table["step_time_us.mean"]["switching"] is None
    assert table["step_time_us.mean"]["blending"] > 0
    assert "step_time_us" not in table
    page = (tmp_path / "kwon_1" / "comparison.md").read_text()
    rows = [line for line in page.splitlines() if line.startswith("|")]
    bars = {line.replace(r"\|", "").count("|") for line in rows}
    assert bars == {4}
    assert any(r"the law \| fell over" in line for line in rows)


@pytest.mark.parametrize("existed", [False, True])
def test_a_picture_that_cannot_be_drawn_costs_no_numbers(
    tmp_path, monkeypatch, existed
):
    sets = ["--out", tmp_path, "--set", "duration=1"]
    if existed:
        compare("kwon_1", "--decomposers", "switching", *sets)

    def full(*_args, **_kwargs):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Figure, "savefig", full)
    result = compare("kwon_1", *BOTH, *sets)
    assert result.exit_code == 1
    (line,) = result.stderr.splitlines()
    assert "kwon_1: picture not written: " in line
    assert "No space left" in line
    # Nor does a picture of older numbers stay.
    without = [file for file in FILES if file != "comparison.png"]
    assert files_in(tmp_path) == [f"kwon_1/{file}" for file in without]
    table = content_of(tmp_path / "kwon_1")["metrics"]
    assert list(table["ee_error_rms"]) == ["blending", "switching"]


def test_ctrl_c_ends_it_and_keeps_what_was_done(tmp_path, monkeypatch):
    @contextmanager
    def impatient(title, _duration):
        def progress(time):
            if title == "kwon_3, switching" and time > 0.5:
                raise KeyboardInterrupt

        yield progress

    monkeypatch.setattr("drake_mobman.cli.compare.progress_bar", impatient)
    command = ["kwon_1", "kwon_3", "kwon_2", *BOTH]
    result = compare(*command, "--out", tmp_path, "--set", "duration=1")
    assert result.exit_code == 130
    (line,) = result.stderr.splitlines()
    assert "kwon_3, switching: interrupted at t = 0." in line
    # What had been run is compared; what had not been begun is not.
    folders = ("kwon_1", "kwon_3")
    assert files_in(tmp_path) == [
        f"{name}/{file}" for name in folders for file in FILES
    ]
    died = content_of(tmp_path / "kwon_3")["metrics"]["died"]
    assert died["blending"] is None
    assert died["switching"].startswith("interrupted at t = 0.")


@pytest.fixture(scope="module")
def comparison():
    scenario = load_scenario("kwon_arbitrary", ["duration=12", "guard.max_v_c=0.5"])
    return compared(
        scenario, variants_of(scenario, chosen_decomposers(["switching", "blending"]))
    )


@pytest.fixture(scope="module")
def figure(comparison):
    return draw_comparison(comparison.runs)


def panels(figure):
    """The axes (rows, 3): linear, angular, time."""
    return np.array(figure.axes).reshape(-1, 3)


def drawn(axes):
    """What the legend names, by name: (N, 2)."""
    return {
        line.get_label(): line.get_xydata()
        for line in axes.lines
        if line.get_color() != LIMIT
    }


def limits(axes):
    return [line.get_ydata()[0] for line in axes.lines if line.get_color() == LIMIT]


def test_figure_has_a_row_for_each_decomposer_lettered_as_in_the_paper(figure):
    titles = [[axes.get_title(loc="left") for axes in row] for row in panels(figure)]
    starts = [[title.split(",")[0] for title in row] for row in titles]
    assert starts == [
        ["(a) switching", "(c) switching", "(e) switching"],
        ["(b) blending", "(d) blending", "(f) blending"],
    ]


def test_figure_shows_every_sample_within_its_axes(comparison, figure):
    for run, row in zip(comparison.runs.values(), panels(figure), strict=True):
        for i, axes in enumerate(row[:2]):
            low, high = axes.get_ylim()
            for name, signal in (
                ("command", signals.EE_COMMAND),
                ("base", signals.BASE_COMMAND),
                ("arm", signals.ARM_COMMAND),
            ):
                logged = run.log[signal][:, i]
                expected = np.column_stack([run.log["time"], logged])
                assert np.array_equal(drawn(axes)[name], expected)
                assert low <= np.min(logged) <= np.max(logged) <= high
        ticks = drawn(row[2])["tick"]
        assert np.array_equal(ticks[:, 1], run.tick_times * 1e6)
        assert ticks[:, 0] == pytest.approx(0.01 * np.arange(1000))
        low, high = row[2].get_ylim()
        assert low <= np.min(ticks[:, 1]) <= np.max(ticks[:, 1]) <= high
        assert row[2].get_yscale() == "log"


def test_panels_of_a_column_have_one_scale(figure):
    for column in panels(figure).T:
        assert len({axes.get_ylim() for axes in column}) == 1
        assert len({axes.get_xlim() for axes in column}) == 1


def test_limits_are_those_of_the_command_or_of_the_base_that_keeps_to_them(figure):
    for row in panels(figure):
        assert [limits(axes) for axes in row] == [[0.5, -0.5], [0.4, -0.4], [1e4]]
    overrides = ["duration=1", "smoother=smoother", "smoother.max_speed=0.7"]
    scenario = load_scenario("kwon_1", overrides)
    kept = draw_comparison(
        compared(scenario, with_each(scenario, {"blending": Blending})).runs
    )
    assert [limits(axes) for axes in kept.axes] == [[0.7, -0.7], [1.0, -1.0], [1e4]]


@pytest.mark.usefixtures("dying")
def test_a_run_that_died_is_drawn_as_far_as_it_got():
    scenario = load_scenario("kwon_1", ["duration=1"])
    runs = compared(
        scenario, variants_of(scenario, chosen_decomposers(["switching", "blending"]))
    ).runs
    died, whole = panels(draw_comparison(runs))
    assert "died" in died[0].get_title(loc="left")
    assert "died" not in whole[0].get_title(loc="left")
    assert 0 < drawn(died[0])["base"][-1, 0] < 0.5
    assert len(drawn(died[2])["tick"]) == 0


@pytest.mark.parametrize("count", [1, 3])
def test_axes_have_units_and_nothing_is_cut_off(comparison, count):
    runs = dict(zip("abc"[:count], [*comparison.runs.values()] * 2, strict=False))
    figure = draw_comparison(runs)
    for row in panels(figure):
        assert [axes.get_ylabel()[-7:].split("[")[1] for axes in row] == [
            "m/s]",
            "rad/s]",
            "µs]",
        ]
    assert {axes.get_xlabel() for axes in panels(figure)[-1]} == {"time [s]"}
    figure.draw_without_rendering()  # Which lays it out.
    width, height = figure.get_size_inches()
    box = figure.get_tightbbox()
    assert 0 <= box.x0 < box.x1 <= width
    assert 0 <= box.y0 < box.y1 <= height


def test_markdown_columns_line_up():
    table = markdown_table(["metric", "a"], [["x", "1"], ["longer name", "22.5"]])
    assert table.splitlines() == [
        "| metric      |    a |",
        "| ----------- | ---: |",
        "| x           |    1 |",
        "| longer name | 22.5 |",
    ]
