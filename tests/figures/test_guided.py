"""Figures of a guided run show what was felt, followed and sent."""

import dataclasses as dc

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from drake_mobman import signals
from drake_mobman.analysis.metrics import metrics
from drake_mobman.base.velocity_field import Zone
from drake_mobman.figures import draw_figures
from drake_mobman.figures.style import LIMIT, LIMIT_LINE
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import Run, simulate

GUIDED = {"strip", "hand_force", "zones", "path", "base_commands", "manipulability"}
COMMANDED = {"linear", "decomposition", "ee_velocity", "path", "manipulability"}


def run_of(name: str, *overrides: str) -> Run:
    return simulate(load_scenario(name, ("duration=2", *overrides)))


@pytest.fixture(scope="module")
def behind() -> Run:
    """The base turns to a hand behind it; the hand lets go for a while."""
    return run_of("petric_behind", "hand.releases=[{start: 1.0, end: 1.5}]")


@pytest.fixture(scope="module")
def figures(behind: Run) -> dict[str, Figure]:
    return dict(draw_figures(behind))


def lines(axes: Axes) -> dict[str, Line2D]:
    return {line.get_label(): line for line in axes.lines}


def limits(axes: Axes) -> list[float]:
    drawn = [line for line in axes.lines if line.get_linewidth() == LIMIT_LINE["lw"]]
    return sorted(line.get_ydata()[0] for line in drawn if line.get_color() == LIMIT)


def band(axes: Axes, label: str) -> tuple[float, float]:
    (found,) = [c for c in axes.collections if c.get_label() == label]
    times = np.concatenate([path.vertices[:, 0] for path in found.get_paths()])
    return np.min(times), np.max(times)


def test_figures_are_those_of_what_was_logged_and_used(figures):
    assert set(figures) == GUIDED
    followed = set(dict(draw_figures(run_of("petric_teleop"))))
    assert followed == COMMANDED | {"zones", "base_commands"}
    shared = set(dict(draw_figures(run_of("kwon_franka"))))
    assert shared == COMMANDED | {"blending", "base_commands"}


def test_zones_are_those_logged_between_their_thresholds(behind, figures):
    log, field = behind.log, behind.scenario.field
    reach = behind.scenario.robot.reach()
    distance, bearing = figures["zones"].axes
    p_ST = log[signals.P_BT] - [reach.ahead, reach.aside, reach.l_0]
    from_centre = lines(distance)["from $c$"].get_ydata()
    assert from_centre == pytest.approx(np.linalg.norm(p_ST, axis=1))
    thresholds = [field.b_d, field.b_d + field.Delta_r]
    thresholds += [reach.r_f - field.Delta_f, reach.r_f]
    assert limits(distance) == pytest.approx(thresholds)
    angles = [field.phi_min, field.phi_max]
    assert limits(bearing) == sorted([*angles, *(-angle for angle in angles)])
    zone = log[signals.FIELD_ZONE][:, 0].astype(int)
    for axes, label, flag in (
        (distance, "forward", Zone.FORWARD),
        (bearing, "rotation", Zone.ROTATION),
    ):
        inside = log["time"][zone & flag > 0]
        assert band(axes, label) == (inside[0], inside[-1])
    labels = figures["zones"].legends[0].get_texts()
    assert "retreat" not in {text.get_text() for text in labels}


def test_a_hand_that_lets_go_is_shaded_and_has_no_error(behind, figures):
    numbers = metrics(behind)
    force, gap = figures["hand_force"].axes
    norm, error = force.lines[0].get_ydata(), gap.lines[0].get_ydata()
    assert np.max(norm) == pytest.approx(numbers["hand_force_max"])
    assert np.nanmax(error) == pytest.approx(1e3 * numbers["hand_error_max"])
    free = np.isnan(error)
    assert np.array_equal(free[1:], norm[1:] == 0.0)
    for axes in (force, gap):
        shaded = behind.log["time"][free]
        assert band(axes, "hand lets go") == (shaded[0], shaded[-1])
    assert 0.99 < shaded[0] < shaded[-1] < 1.51


def test_the_largest_force_is_drawn_where_it_is_near():
    figure = dict(draw_figures(run_of("petric_guided", "hand.max_force=2")))
    assert limits(figure["hand_force"].axes[0]) == [2.0]


def test_commands_are_drawn_raw_and_sent_between_the_smoothers_limits(behind, figures):
    log = behind.log
    *rates, v_dot, omega_dot = figures["base_commands"].axes
    for i, (axes, limit) in enumerate(zip(rates, (0.5, 1.0), strict=True)):
        drawn = lines(axes)
        raw, sent = drawn["raw"], drawn["smoothed"]
        assert np.array_equal(raw.get_ydata(), log[signals.BASE_COMMAND][:, i])
        assert np.array_equal(
            sent.get_ydata(), log[signals.BASE_COMMAND_SMOOTHED][:, i]
        )
        assert limits(axes) == [-limit, limit]
    assert limits(v_dot) == [-1.0, 1.0]
    assert limits(omega_dot) == [-2.0, 2.0]


def test_the_least_is_marked_and_is_that_of_the_metrics(behind, figures):
    numbers = metrics(behind)
    for axes, name in zip(
        figures["manipulability"].axes,
        ("manipulability_min", "joint_margin_min"),
        strict=True,
    ):
        mark = axes.lines[-1]
        assert mark.get_marker() == "o"
        assert mark.get_ydata()[0] == pytest.approx(numbers[name])


def test_each_arm_on_the_path_ends_at_the_tool(behind, figures):
    arms = [
        line.get_xydata()
        for line in figures["path"].axes[0].lines
        if line.get_label().startswith("_") and len(line.get_xydata()) > 2
    ]
    tool = behind.log[signals.TOOL_POSITION][:, :2]
    drawn = lines(figures["path"].axes[0])["tool"].get_xydata()
    assert np.array_equal(drawn, tool)
    assert len(arms) == 8
    for arm in arms:
        assert np.min(np.linalg.norm(tool - arm[0], axis=1)) < 1e-9
    assert arms[0][0] == pytest.approx(tool[0], abs=1e-9)
    assert arms[-1][0] == pytest.approx(tool[-1], abs=1e-9)


def test_a_strip_shows_the_whole_robot_at_moments(behind, figures):
    times = []
    for axes in figures["strip"].axes:
        time, force = axes.get_title(loc="left").removesuffix(" N").split(" s,  ")
        times.append(float(time))
        (robot,) = [c for c in axes.collections if isinstance(c, PolyCollection)]
        corners = np.vstack([path.vertices for path in robot.get_paths()])
        assert np.all(corners > [axes.get_xlim()[0], axes.get_ylim()[0]])
        assert np.all(corners < [axes.get_xlim()[1], axes.get_ylim()[1]])
        logged = np.linalg.norm(behind.log[signals.HAND_FORCE], axis=1)
        assert np.min(np.abs(logged - float(force))) <= 0.05
    assert times == sorted(times)
    assert (times[0], times[-1], len(times)) == (0.0, 2.0, 8)


def test_a_robot_that_stands_still_is_pictured_once():
    run = run_of("petric_guided", "duration=0.5")
    pictures = [axes for axes in dict(draw_figures(run))["strip"].axes if axes.lines]
    assert len(pictures) == 2  # The first and the last.


def test_axes_have_units_and_nothing_is_cut_off(figures):
    for name, figure in figures.items():
        for axes in figure.axes if name != "strip" else ():
            labels = [axes.get_xlabel(), axes.get_ylabel()]
            assert all("[" in label for label in labels if label)
            assert labels[1]
        figure.draw_without_rendering()  # Which lays it out.
        width, height = figure.get_size_inches()
        box = figure.get_tightbbox()
        assert 0 <= box.x0 < box.x1 <= width
        assert 0 <= box.y0 < box.y1 <= height


@pytest.mark.filterwarnings("error")
def test_a_run_that_died_early_is_drawn(behind):
    for first, last in ((0, 1), (0, 2), (110, 111), (110, 130)):
        log = {signal: x[first:last] for signal, x in behind.log.items()}
        for _, figure in draw_figures(dc.replace(behind, log=log, died="died")):
            figure.draw_without_rendering()
