"""Figures show the run as it was, in units, between the scenario's limits."""

import dataclasses as dc

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from drake_mobman import figures as figures_package
from drake_mobman import signals
from drake_mobman.analysis.metrics import metrics
from drake_mobman.decomposers.projection import base_speed, radial_weight
from drake_mobman.decomposers.share import blended_share
from drake_mobman.figures import FIGURES, RunFigure, draw_figures
from drake_mobman.figures.style import LIMIT
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import Run, simulate

BOTH = ("linear", "angular")


def run_of(name: str, *overrides: str) -> Run:
    return simulate(load_scenario(name, overrides))


@pytest.fixture(scope="module")
def arbitrary() -> Run:
    return run_of("kwon_arbitrary", "workspace.l_max=1.5", "workspace.psi_min=-0.6")


@pytest.fixture(scope="module")
def figures(arbitrary: Run) -> dict[str, Figure]:
    return dict(draw_figures(arbitrary))


def lines(axes: Axes) -> dict[str, Line2D]:
    return {line.get_label(): line for line in axes.lines}


def limits(axes: Axes) -> list[float]:
    drawn = [line for line in axes.lines if line.get_color() == LIMIT]
    # A limit spans the axes, from 0 to 1, in the direction it does not measure.
    return [
        (line.get_xdata() if list(line.get_ydata()) == [0, 1] else line.get_ydata())[0]
        for line in drawn
    ]


def test_limits_are_drawn_where_the_scenario_has_them(figures):
    decomposition = figures["decomposition"].axes
    for name, part, expected in zip(
        BOTH, ("l", r"\psi"), ([0.4, 1.5], [-0.6, 0.7]), strict=True
    ):
        over_time, across, _ = figures[name].axes
        (twin,) = [
            axes for axes in decomposition if axes.get_ylabel().startswith(f"${part}$")
        ]
        for axes in (over_time, across, twin):
            assert limits(axes) == expected
        low, high = over_time.get_ylim()
        assert low < expected[0] < expected[1] < high


def test_a_limit_far_from_all_data_is_left_out():
    figure = dict(draw_figures(run_of("kwon_dither")))["linear"]
    assert limits(figure.axes[0]) == [1.6]


@pytest.mark.parametrize("part", [0, 1])
def test_lines_are_the_log(arbitrary, figures, part):
    log, symbol = arbitrary.log, ("v", r"\omega")[part]
    time, at = log["time"], log[signals.EE_CYLINDRICAL][:, part]
    reach, across, rates = figures[BOTH[part]].axes
    assert np.array_equal(reach.lines[0].get_xydata(), np.column_stack([time, at]))
    for axes, x in ((rates, time), (across, at)):
        for signal, end in (
            (signals.EE_COMMAND, "c"),
            (signals.BASE_COMMAND_SMOOTHED, "b"),
            (signals.ARM_COMMAND, "m"),
        ):
            drawn = lines(axes)[f"${symbol}_{end}$"].get_xydata()
            assert np.array_equal(drawn, np.column_stack([x, log[signal][:, part]]))
    outputs = lines(figures["decomposition"].axes[2 + part])
    base, arm = outputs["base"].get_ydata(), outputs["arm"].get_ydata()
    assert np.array_equal(base, log[signals.BASE_CONTRIBUTION][:, part])
    assert np.array_equal(arm, log[signals.ARM_COMMAND][:, part])
    assert np.array_equal(outputs["sum"].get_ydata(), base + arm)


def test_kappa_is_the_law_at_the_scenarios_sigma(arbitrary, figures):
    kappa, speed, *_ = figures["kappa"].axes[0].lines
    projection = arbitrary.scenario.decomposer.projection
    for (psi, k), (_, v) in zip(kappa.get_xydata(), speed.get_xydata(), strict=True):
        assert k == radial_weight(psi, projection.sigma)
        assert v == base_speed(1.0, psi, projection)


def test_blending_is_the_law_and_what_is_left_of_it(figures):
    for axes, v_c in zip(figures["blending"].axes, (-1.0, 1.0), strict=True):
        drawn = lines(axes)
        base, arm = drawn[r"base, $\mu$"], drawn[r"arm, $1 - \mu$"]
        share = [blended_share(v_c, l, 0.4, 1.5, 21.0) for l in base.get_xdata()]
        assert list(base.get_ydata()) == share
        assert list(arm.get_ydata()) == [1.0 - mu for mu in share]
        assert limits(axes) == [0.4 if v_c < 0 else 1.5]


def test_switching_is_drawn_as_a_step():
    figure = dict(draw_figures(run_of("kwon_1", "decomposer=switching")))["blending"]
    inward, outward = (lines(axes)[r"base, $\mu$"] for axes in figure.axes)
    assert np.array_equal(inward.get_ydata(), inward.get_xdata() < 0.4)
    assert np.array_equal(outward.get_ydata(), outward.get_xdata() >= 1.6)


def test_slip_and_drift_are_those_of_the_metrics(arbitrary, figures):
    numbers = metrics(arbitrary)
    (error,) = figures["ee_velocity"].axes[2].lines
    assert np.max(error.get_ydata()) == numbers["ee_error_max"] > 0.1
    drawn = lines(figures["path"].axes[0])
    path = drawn["end effector"].get_xydata()
    commanded = drawn["command"].get_xydata()
    drift = np.max(np.linalg.norm(path - commanded, axis=1))
    assert drift == pytest.approx(numbers["ee_drift_max"], rel=1e-9)


def test_path_is_drawn_to_scale(figures):
    axes = figures["path"].axes[0]
    figures["path"].draw_without_rendering()
    ratio = np.divide(*np.diff(axes.transData.transform([[0, 0], [1, 1]]), axis=0)[0])
    assert ratio == pytest.approx(1.0)


def test_what_is_never_commanded_is_left_out():
    assert "angular" not in dict(draw_figures(run_of("kwon_1")))
    drawn = dict(draw_figures(run_of("kwon_3")))
    assert "linear" not in drawn
    rates = {axes.get_ylabel() for axes in drawn["decomposition"].axes}
    assert rates == {r"$\omega_c$ [rad/s]", r"$\omega$ [rad/s]", r"$\psi$ [rad]"}


@pytest.mark.parametrize(
    ("name", "decomposer"),
    [
        ("kwon_1", "switching"),
        ("kwon_3", "blending"),
        ("kwon_spatial", "switching"),
        ("kwon_franka", "blending"),
    ],
)
def test_axes_have_units_and_nothing_is_cut_off(name, decomposer):
    run = run_of(name, f"decomposer={decomposer}", "duration=16")
    for figure in dict(draw_figures(run)).values():
        labels = [
            label
            for axes in figure.axes
            for label in (axes.get_xlabel(), axes.get_ylabel())
        ]
        assert all("[" in label for label in labels if label)
        for axes in figure.axes:
            same = axes.get_shared_y_axes().get_siblings(axes)
            assert any(sibling.get_ylabel() for sibling in same)
            same = axes.get_shared_x_axes().get_siblings(axes)
            assert any(sibling.get_xlabel() for sibling in same)
        figure.draw_without_rendering()  # Which lays it out.
        width, height = figure.get_size_inches()
        box = figure.get_tightbbox()
        assert 0 <= box.x0 < box.x1 <= width
        assert 0 <= box.y0 < box.y1 <= height


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", ["kwon_1", "kwon_spatial"])
def test_a_run_that_died_early_is_drawn(name):
    run = run_of(name, "duration=1.5")
    # At 1 s the command begins.
    for first, last in ((0, 1), (0, 2), (100, 102)):
        log = {signal: x[first:last] for signal, x in run.log.items()}
        for _, figure in draw_figures(dc.replace(run, log=log, died="died")):
            figure.draw_without_rendering()


def test_nothing_is_drawn_of_an_empty_log(arbitrary):
    log = {signal: x[:0] for signal, x in arbitrary.log.items()}
    assert not dict(draw_figures(dc.replace(arbitrary, log=log)))


def test_global_settings_of_matplotlib_are_left_alone(arbitrary):
    def settings():
        # Asked by itself, `rcParams` would choose a backend.
        return dict(dict.items(mpl.rcParams))

    before = settings()
    dict(draw_figures(arbitrary))
    assert settings() == before


def test_a_new_figure_is_a_function_and_a_line(arbitrary, monkeypatch):
    def draw(run: Run) -> Figure:
        figure = Figure()
        figure.subplots().plot(run.time, run[signals.BASE_POSE][:, 0])
        return figure

    own = RunFigure("x_of_base", draw)
    never = RunFigure("never", draw, lambda run: "nothing_logged" in run.log)
    monkeypatch.setattr(figures_package, "FIGURES", [own, never])
    ((name, figure),) = draw_figures(arbitrary)
    assert name == "x_of_base"
    drawn = figure.axes[0].lines[0].get_ydata()
    assert np.array_equal(drawn, arbitrary[signals.BASE_POSE][:, 0])


def test_no_two_figures_have_the_same_file():
    names = [figure.name for figure in FIGURES]
    assert len(names) == len(set(names))
