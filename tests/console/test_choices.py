"""What an operator may choose from: all of the scenario's union that works."""

import dataclasses as dc

import pytest

from drake_mobman.console.choices import choice_names, live_scenario
from drake_mobman.decomposers.blending import Blending
from drake_mobman.decomposers.switching import Switching
from drake_mobman.parameters import ParameterError
from drake_mobman.scenario import Teleop, load_scenario


@dc.dataclass
class Still:
    """A decomposer that the package does not know."""

    works: bool = True

    def build(self, setup):
        if not self.works:
            raise ParameterError("", "!Still", "must be another")
        return Switching().build(setup)


@dc.dataclass
class OneMore(Teleop):
    """A scenario whose union has one more member."""

    alternatives: list[Blending | Switching | Still] = dc.field(default_factory=list)


@pytest.fixture
def one_more():
    """A scenario of that class, in which Blending drives."""
    scenario = load_scenario("kwon_arbitrary")
    fields = {f.name: getattr(scenario, f.name) for f in dc.fields(scenario)}
    return OneMore(**fields)


def test_new_member_of_the_union_is_offered_by_its_name(one_more):
    names = choice_names(live_scenario(one_more))
    assert names == ["blending", "switching", "still"]


def test_what_does_not_work_with_the_robot_is_not_offered(one_more, monkeypatch):
    monkeypatch.setattr(Still, "works", False)
    monkeypatch.setattr(Still.__init__, "__defaults__", (False,))
    assert choice_names(live_scenario(one_more)) == ["blending", "switching"]


def test_alternatives_that_the_scenario_names_stay_as_they_are(one_more):
    named = dc.replace(one_more, alternatives=[Switching()])
    assert live_scenario(named).alternatives == [Switching()]


def test_field_is_offered_by_each_law_with_the_parameters_of_the_one_that_drives():
    scenario = load_scenario("petric_guided", ["field.K_f=3.0"])
    first, second = live_scenario(scenario).controllers
    assert (first.law, second.law) == ("projected", "printed")
    assert second.K_f == 3.0
