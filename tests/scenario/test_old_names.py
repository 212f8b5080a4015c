"""Scenarios of version 0.1, as run folders hold them, load as what they are now."""

import dataclasses as dc
import warnings
from pathlib import Path

import pytest

from drake_mobman.base.smoother import Smoother
from drake_mobman.base.unsmoothed import Unsmoothed
from drake_mobman.scenario import ScenarioError, load_scenario

OLD = {file.stem: file for file in Path(__file__).parent.glob("version_0_1/*.yaml")}


def mine(tmp_path, text):
    """A scenario of somebody's own, written by hand."""
    file = tmp_path / "mine.yaml"
    file.write_text(text)
    return file


def loaded(file, *overrides):
    """Returns a scenario, and what was warned of meanwhile."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scenario = load_scenario(file, overrides)
    return scenario, [str(warning.message) for warning in caught]


@pytest.mark.parametrize("name", OLD)
def test_a_resolved_scenario_of_0_1_is_the_same_one_now(name):
    old, said = loaded(OLD[name])
    now = load_scenario(name)
    assert dc.replace(old, description=now.description) == now
    assert any("smoother.enabled is an old name" in line for line in said)
    assert all("version_0_1" not in line and "\n" not in line for line in said)


def test_there_are_old_scenarios_of_both_kinds():
    assert {"kwon_arbitrary", "petric_hold"} <= OLD.keys()


def test_new_scenarios_warn_of_nothing():
    assert loaded("kwon_franka")[1] == []


def test_a_smoother_is_switched_on_and_off_as_it_was(tmp_path):
    file = mine(tmp_path, "smoother: {enabled: true, max_speed: 0.4}")
    assert loaded(file)[0].smoother == Smoother(max_speed=0.4)
    file = mine(tmp_path, "{robot: !FrankaTiago {}, smoother: {enabled: false}}")
    assert loaded(file)[0].smoother == Unsmoothed()
    scenario, said = loaded("kwon_1", "smoother.enabled=true")
    assert isinstance(scenario.smoother, Smoother)
    (line,) = said
    assert line.startswith("kwon_1.yaml with --set: smoother.enabled is an old name")


def test_a_projection_goes_to_each_decomposer_that_has_one(tmp_path):
    file = mine(
        tmp_path,
        "{projection: {sigma: 0.3}, decomposer: blending, alternatives: [!Switching {},"
        " !Exact {}], change: {duration: 2.0}}",
    )
    scenario, said = loaded(file)
    assert scenario.decomposer.projection.sigma == 0.3
    assert scenario.alternatives[0].projection.sigma == 0.3
    assert scenario.transition.duration == 2.0
    assert len(said) == 2


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("smoother: {enabled: 2}", "smoother.enabled: 2 is not valid"),
        ("{projection: {sigma: -1}, decomposer: blending}", "sigma: -1.0 is not valid"),
        ("change: {duration: -1}", "transition.duration: -1.0 is not valid"),
    ],
)
def test_what_is_wrong_under_an_old_name_is_refused_in_one_line(tmp_path, text, says):
    file = mine(tmp_path, text)
    with pytest.raises(ScenarioError, match=says):
        loaded(file)
