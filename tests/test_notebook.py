"""Scenarios run in a line of Python, and shown in a notebook."""

import dataclasses as dc
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import drake_mobman as mm


@pytest.fixture(scope="module")
def run():
    return mm.simulate("kwon_spatial", decomposer=mm.Blending(alpha=10), duration=2.0)


def test_run_has_its_signals_by_name(run):
    assert len(run.time) == 201
    assert run.time[-1] == pytest.approx(2.0)
    assert run["ee_command"].shape == (201, 3)
    assert {"base_command", "base_command_smoothed", "ee_cylindrical"} <= set(
        run.signals
    )
    assert run.scenario.decomposer == mm.Blending(alpha=10)
    with pytest.raises(KeyError, match=r"valid names are .*ee_command"):
        run["workspace"]


def test_run_has_its_metrics(run):
    assert run.metrics() == mm.metrics(run)
    speed = np.max(np.abs(run["base_command_smoothed"][:, 0]))
    assert run.metrics()["base_speed_max"] == speed


def test_changes_are_those_of_a_scenario_changed_by_hand(run):
    scenario = dc.replace(
        mm.load_scenario("kwon_spatial"),
        decomposer=mm.Blending(alpha=10),
        duration=2.0,
    )
    again = mm.simulate(scenario)
    assert again.signals == run.signals
    for name in run.signals:
        assert again[name].tobytes() == run[name].tobytes(), name


def test_scenario_may_be_a_file(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("duration: 0.1\n")
    for given in (file, str(file)):
        assert len(mm.simulate(given).time) == 11


def test_whole_number_is_a_duration_too():
    assert len(mm.simulate("kwon_1", duration=np.int64(1)).time) == 101


def test_new_robot_brings_its_own_start_and_limits():
    run = mm.simulate("kwon_spatial", robot=mm.Planar(), duration=0.1)
    own = mm.Teleop(robot=mm.Planar())
    assert (run.scenario.start, run.scenario.workspace) == (own.start, own.workspace)
    assert run["arm_position"].shape[1] == 2


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"duratoin": 1.0}, "duratoin: no such field of the scenario; valid fields"),
        ({"duration": "long"}, "duration: 'long' is not valid; must be of type float"),
        ({"duration": True}, "duration: True is not valid; must be of type float"),
        ({"duration": float("nan")}, "duration: nan is not valid; must be a finite"),
        ({"compiled": 1}, "compiled: 1 is not valid; must be of type bool"),
        ({"decomposer": "qp"}, "decomposer: 'qp' is not valid; must be parameters"),
        ({"decomposer": mm.Blending}, "must be parameters, such as `mm.Blending()`"),
        ({"decomposer": mm.Blending(alpha=-1)}, "decomposer.alpha: -1 is not valid"),
        ({"start": mm.Start(l=9.0)}, "out of reach"),
    ],
)
def test_change_that_is_not_valid_is_refused_in_one_line(changes, says):
    with pytest.raises((mm.ScenarioError, mm.ParameterError)) as refusal:
        mm.simulate("kwon_1", **changes)
    assert says in str(refusal.value)
    assert len(str(refusal.value).splitlines()) == 1


def test_scenario_that_is_not_there_is_refused():
    with pytest.raises(mm.ScenarioError, match="nosuch: no such scenario; valid names"):
        mm.simulate("nosuch")


def cells_of(page):
    """Returns the rows of a page's table; the page must be well-formed."""
    page = re.sub(r"<img [^>]*>", "", page)
    table = ET.fromstring(f"<div>{page}</div>").find("table")
    return [["".join(cell.itertext()) for cell in row] for row in table]


def test_notebook_shows_metrics_in_groups_with_units_and_a_picture(run):
    page = run._repr_html_()
    rows = cells_of(page)
    assert ["end effector"] in rows
    assert ["base"] in rows
    by_name = {row[0]: row[1:] for row in rows if len(row) == 3}
    number = run.metrics()["ee_error_rms"]
    assert by_name["ee_error_rms"] == [f"{number:.4g}", "m/s"]
    assert "hand_force_max" not in by_name  # Nobody pulls.
    assert 'src="data:image/png;base64,iVBORw0KGgo' in page
    assert repr(run) == "<NotebookRun: 2 s, 201 samples>"


def test_notebook_shows_text_as_text(run):
    odd = dc.replace(run.scenario, description="<script>alert(1)</script> & more")
    page = dc.replace(run, scenario=odd, died="<b>fell over</b>")._repr_html_()
    assert "<script" not in page
    assert "<b>" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt; &amp; more" in page
    assert "&lt;b&gt;fell over&lt;/b&gt;" in page


@dc.dataclass
class Ramp:
    """Parameters of a decomposer of a user's own."""

    width: float = 0.2  # Of the transition [m].
    projection: mm.Projection = dc.field(default_factory=mm.Projection)

    def shares(self, limits, command, at):
        room = limits.l_max - at[0] if command[0] > 0 else at[0] - limits.l_min
        return min(1.0, max(0.0, 1.0 - room / self.width)), 0.0

    def build(self, setup):
        return RampDecomposer(self, setup.workspace, setup.arm.num_joints)


@mm.scalar_block
class RampDecomposer(mm.ShareDecomposer):
    """Authority passes in a straight line."""


def test_decomposer_of_ones_own_runs_in_a_scenario():
    run = mm.simulate("kwon_arbitrary", decomposer=Ramp(width=0.3), duration=5.0)
    assert not run.died
    v_c, l = run["ee_command"][:, 0], run["ee_cylindrical"][:, 0]
    l_max = run.scenario.workspace.l_max
    half = (v_c > 0) & (np.abs(l - (l_max - 0.15)) < 0.01)
    assert half.any()
    share = run["base_contribution"][half, 0] / v_c[half]
    np.testing.assert_allclose(share, 0.5, atol=0.01 / 0.3)
    assert "Paths of base and end effector" in run._repr_html_()


@dc.dataclass
class Falling(Ramp):
    """A decomposer that fails while it runs."""

    def shares(self, *_):
        raise RuntimeError("the law fell over")


def test_run_that_died_warns_and_says_why():
    with pytest.warns(RuntimeWarning, match=r"died at t = 0 s: .*fell over"):
        run = mm.simulate("kwon_arbitrary", decomposer=Falling(), duration=0.1)
    assert "fell over" in repr(run)
    assert "fell over" in run._repr_html_()
