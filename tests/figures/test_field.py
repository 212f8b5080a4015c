"""Figures of the field show the law, its zones as they are, and where it leads."""

import dataclasses as dc
import math

import numpy as np
import pytest
from matplotlib.figure import Figure

from drake_mobman.base.smoother import Smoother
from drake_mobman.base.unsmoothed import Unsmoothed
from drake_mobman.base.velocity_field import (
    VelocityField,
    field_velocity,
    signed_distances,
    yaw_rate,
)
from drake_mobman.figures.field import field_figures
from drake_mobman.figures.field.approach import AT_REST, distances
from drake_mobman.figures.field.slices import HEIGHTS
from drake_mobman.robot_model import Reach

REACH = Reach(l_0=0.8, r_f=0.7)
PARAMS = VelocityField()
LAWS = {law: dc.replace(PARAMS, law=law) for law in ("printed", "projected")}
SMOOTHER = Smoother()

SLICES = [("side", 0, None), ("top", 0, HEIGHTS[0]), ("top", 1, HEIGHTS[1])]
"""Kind of figure, panel, and height where it is seen from above."""

every_slice = pytest.mark.parametrize(("kind", "panel", "height"), SLICES)
both_laws = pytest.mark.parametrize("law", LAWS)

ROUNDING = 1e-9
"""Of a point on an edge [m]."""


@pytest.fixture(scope="module")
def figures() -> dict[str, Figure]:
    bearings = np.linspace(-math.pi, math.pi, 13)
    coarse = field_figures(PARAMS, REACH, SMOOTHER, pixels=80, bearings=bearings)
    return dict(coarse)


def in_space(across, up, height):
    """The point (3,) in B that a slice shows at `across`, `up`."""
    return (across, 0.0, up) if height is None else (across, up, height)


def lines(axes):
    """The points (N, 2) of the lines that the legend names, by their first word."""
    named = {}
    for line in axes.lines:
        points = line.get_xydata()
        points = points[np.isfinite(points).all(axis=1)]
        named.setdefault(line.get_label().split(",")[0], []).append(points)
    return named


def test_there_is_a_figure_of_each_kind_under_each_law(figures):
    kinds = [f"field_{kind}_{law}" for kind in ("side", "top") for law in LAWS]
    assert list(figures) == [*kinds, "field_rest"]


@both_laws
@every_slice
def test_colours_are_the_law_within_reach_and_none_beyond(
    figures, law, kind, panel, height
):
    (image,) = figures[f"field_{kind}_{law}"].axes[panel].images
    v = image.get_array()
    left, right, bottom, top = image.get_extent()
    n = len(v)
    rng = np.random.default_rng(5)
    for row, column in rng.integers(0, n, (500, 2)):
        p = in_space(
            left + (column + 0.5) * (right - left) / n,
            bottom + (row + 0.5) * (top - bottom) / n,
            height,
        )
        reached = signed_distances(p, REACH, PARAMS.b_d)[0] >= 0
        assert v.mask[row, column] == (not reached)
        if reached:
            expected = field_velocity(p, LAWS[law], REACH)[0]
            assert v[row, column] == pytest.approx(expected, abs=1e-9)
    assert (image.norm.vmin, image.norm.vmax) == (-0.5, 0.5)


def test_forward_is_orange_retreat_is_purple_and_rest_is_white(figures):
    (image,) = figures["field_side_printed"].axes[0].images
    forward, rest, retreat = (image.to_rgba(v)[:3] for v in (0.3, 0.0, -0.3))
    assert forward[0] > forward[1] > forward[2]
    assert rest == pytest.approx((1, 1, 1), abs=0.02)
    assert retreat[2] > retreat[0] > retreat[1]


@both_laws
@every_slice
def test_zone_edges_are_where_the_law_has_them(figures, law, kind, panel, height):
    drawn = lines(figures[f"field_{kind}_{law}"].axes[panel])
    for name, which, distance in (
        ("reach", 0, 0.0),
        ("forward", 0, PARAMS.Delta_f),
        ("retreat", 1, PARAMS.Delta_r),
        ("body", 1, 0.0),
    ):
        (points,) = drawn[name]
        # Low, the forward zone begins within the retreat zone, and has no edge.
        assert len(points) == 0 if (name, height) == ("forward", 0.3) else points.any()
        for across, up in points:
            p = in_space(across, up, height)
            d = signed_distances(p, REACH, PARAMS.b_d)
            assert d[which] == pytest.approx(distance, abs=ROUNDING)
            assert d[0] >= -ROUNDING
            if name == "forward":
                assert d[1] >= PARAMS.Delta_r - ROUNDING


@pytest.mark.parametrize("panel", [0, 1])
def test_rotation_zone_begins_and_is_full_at_its_bearings(figures, panel):
    rays = lines(figures["field_top_projected"].axes[panel])["rotation"]
    bearings = sorted(
        np.unique(np.arctan2(p[:, 1], p[:, 0]).round(9)).item() for p in rays
    )
    assert bearings == pytest.approx([-0.6, -0.2, 0.2, 0.6], abs=ROUNDING)


@pytest.mark.parametrize("panel", [0, 1])
def test_arrows_turn_about_the_base_as_fast_as_it_does(figures, panel):
    (arrows,) = figures["field_top_printed"].axes[panel].collections
    x, y = arrows.get_offsets().T
    phi = np.arctan2(y, x)
    omega = [yaw_rate(at, PARAMS) for at in phi]
    assert arrows.N > 20
    assert -arrows.U * np.sin(phi) + arrows.V * np.cos(phi) == pytest.approx(omega)
    assert arrows.U * np.cos(phi) + arrows.V * np.sin(phi) == pytest.approx(0 * phi)


@both_laws
def test_heights_of_the_slices_are_drawn_in_the_side_view(figures, law):
    flat = [
        line.get_ydata()[0]
        for line in figures[f"field_side_{law}"].axes[0].lines
        if list(line.get_xdata()) == [0, 1]
    ]
    assert flat == list(HEIGHTS)


def test_axes_have_names_and_units(figures):
    for name, (*panels, bar) in (
        (name, figure.axes) for name, figure in figures.items() if name != "field_rest"
    ):
        assert bar.get_ylabel().startswith("$v$ [m/s]")
        for axes in panels:
            assert axes.get_xlabel() == "$x$ [m]"
        up = "$z$ [m]" if "side" in name else "$y$ [m]"
        assert panels[0].get_ylabel() == up
    rest = figures["field_rest"].axes
    assert [axes.get_ylabel() for axes in rest[::3]] == [
        "distance [m], printed",
        "distance [m], projected",
    ]
    assert {axes.get_xlabel() for axes in rest[3:]} == {r"$\varphi$ at the start [rad]"}


def test_rest_shows_the_distances_of_the_closed_loop(figures):
    cases = [(law, start) for law in LAWS for start in (0.35, 0.625, 0.7)]
    for axes, (law, start) in zip(figures["field_rest"].axes, cases, strict=True):
        assert lines(axes)["at the start"][0][:, 1] == pytest.approx(start)
        (last,) = lines(axes)["after 15 s"]
        for i in (0, 4, 9):
            _, _, expected = distances(start, last[i, 0], LAWS[law], REACH, SMOOTHER)
            assert last[i, 1] == pytest.approx(expected, abs=ROUNDING)


SLOW = dc.replace(PARAMS, K_f=2.0, K_r=2.0, K_omega=0.8)
AT_ONCE = Smoother(smoothing=1.0, max_acceleration=1e3, max_yaw_acceleration=1e3)
"""Limits speed, and lets it jump."""


def test_printed_law_runs_away_from_a_hand_behind_and_over_a_near_one():
    printed = dc.replace(SLOW, law="printed")
    _, farthest, last = distances(0.65, 3.1, printed, REACH, AT_ONCE)
    assert 1.4 < farthest < 1.5
    assert last == pytest.approx(0.55, abs=0.01)
    nearest, _, _ = distances(0.35, 3.1, LAWS["printed"], REACH, SMOOTHER)
    assert nearest < 0.5 * PARAMS.b_d


@pytest.mark.parametrize("phi", np.linspace(-math.pi, math.pi, 9))
def test_projected_law_never_leaves_the_hand_nor_closes_in_on_it(phi):
    projected = dc.replace(SLOW, law="projected")
    for start, rest in ((0.35, 0.4), (0.45, 0.45), (0.65, 0.55)):
        nearest, farthest, last = distances(start, phi, projected, REACH, AT_ONCE)
        assert min(start, rest) - 1e-6 < nearest
        assert farthest < max(start, rest) + 1e-6
        assert last == pytest.approx(rest, abs=1e-3)


def test_without_a_smoother_the_base_gets_the_raw_command():
    # From 5 cm within the zone at 4/s: after a step of 10 ms, 4 % nearer its edge.
    raw = Unsmoothed()
    _, _, last = distances(0.6, 0.0, PARAMS, REACH, raw)
    steps = math.ceil(math.log(AT_REST / 0.2) / math.log(0.96))
    assert last == pytest.approx(0.55 + 0.05 * 0.96**steps, abs=1e-9)
