"""Scenarios: layers of values, and bad ones refused in one line."""

import pytest

from drake_mobman.decomposers.blending import Blending
from drake_mobman.decomposers.exact import Exact
from drake_mobman.decomposers.switching import Switching
from drake_mobman.scenario import (
    Guided,
    ScenarioError,
    Teleop,
    load_scenario,
    scenario_paths,
)
from drake_mobman.schema import dump_typed, load_typed, load_yaml
from drake_mobman.teleop.scripted import Held, Script, Smooth


def test_every_default_is_valid():
    assert load_typed(Teleop, {}) == Teleop()
    assert load_typed(Guided, {}) == Guided()


def test_defaults_are_those_of_table_1():
    scenario = Teleop()
    assert scenario.period == 0.01
    assert (scenario.robot.upper_link, scenario.robot.lower_link) == (1.0, 1.0)
    limits = scenario.workspace
    assert (limits.l_min, limits.l_max) == (0.4, 1.6)
    assert (limits.psi_min, limits.psi_max) == (-0.7, 0.7)
    assert (scenario.guard.max_v_c, scenario.guard.max_omega_c) == (0.4, 0.4)
    assert scenario.decomposer == Exact()
    for number in "1234":
        scenario = load_scenario(f"kwon_{number}")
        assert scenario.decomposer == Blending(alpha=21.0, beta=21.0)


@pytest.mark.parametrize(
    ("name", "l", "psi", "v_c", "omega_c"),
    [
        ("kwon_1", 0.0, 0.0, 0.35, 0.0),
        ("kwon_2", 1.8, 0.0, -0.35, 0.0),
        ("kwon_3", 0.0, -0.85, 0.0, 0.35),
        ("kwon_4", 0.0, 0.85, 0.0, -0.35),
    ],
)
def test_scenarios_are_those_of_table_2(name, l, psi, v_c, omega_c):
    scenario = load_scenario(name)
    assert (scenario.start.l, scenario.start.psi, scenario.start.z) == (l, psi, 0.0)
    assert scenario.source == Script(
        [Held(duration=1.0), Held(duration=14.0, v_c=v_c, omega_c=omega_c)]
    )


@pytest.mark.parametrize("name", scenario_paths())
def test_resolved_scenario_loads_as_the_same(name, tmp_path):
    scenario = load_scenario(name)
    file = tmp_path / "some_run" / "scenario.yaml"
    file.parent.mkdir()
    file.write_text(dump_typed(scenario))
    again = load_scenario(str(file))
    assert again == scenario
    assert again.name == "some_run"


@pytest.mark.parametrize("name", scenario_paths())
def test_every_scenario_has_one_line_that_says_what_it_is(name):
    scenario = load_scenario(name)
    assert 20 < len(scenario.description) < 100
    assert "\n" not in scenario.description


@pytest.mark.parametrize(
    "spelling", ["!Switching", "!Switching {}", "Switching", "switching", "SWITCHING"]
)
def test_decomposer_is_chosen_by_tag_or_by_name(spelling):
    scenario = load_scenario("kwon_1", [f"decomposer={spelling}"])
    assert scenario.decomposer == Switching()


def test_later_layers_lie_over_earlier_ones():
    overrides = ["decomposer=blending", "decomposer.alpha=5", "decomposer.alpha=6"]
    scenario = load_scenario("kwon_1", overrides)
    assert scenario.decomposer == Blending(alpha=6.0, beta=21.0)
    assert scenario.start.l == 0.0  # The file's, not the default.


def test_override_takes_whole_lists_of_tagged_members():
    text = "source.segments=[!Held {duration: 2}, !Smooth {duration: 1e-1, v_c: 0.1}]"
    scenario = load_scenario("kwon_1", [text])
    assert scenario.source.segments == [Held(duration=2.0), Smooth(0.1, v_c=0.1)]


@pytest.mark.parametrize(
    ("override", "says"),
    [
        ("durration=1", "durration: 1 is not valid; valid keys are: description, "),
        ("decomposer.gamma=1", "decomposer.gamma: 1 is not valid; valid keys are: al"),
        ("decomposer=!Blend", "decomposer: '!Blend' is not valid; must be one of !"),
        ("decomposer=[1]", "decomposer: [1] is not valid; must be one of !"),
        ("duration=long", "duration: 'long' is not valid; must be a number"),
        ("duration=true", "duration: True is not valid; must be a number"),
        ("duration=", "duration: None is not valid; must be a number"),
        ("source.repeat=1.5", "source.repeat: 1.5 is not valid; must be a whole numb"),
        ("source.repeat=0", "source.repeat: 0 is not valid; must be within [1, 50"),
        ("smoother.enabled=1", "smoother.enabled: 1 is not valid; must be true, fal"),
        ("start=3", "start: 3 is not valid; must be a mapping with keys of l, psi"),
        ("source.segments=7", "source.segments: 7 is not valid; must be a list"),
        ("duration=.nan", "duration: nan is not valid; must be a finite number"),
        ("duration=.inf", "duration: inf is not valid; must be a finite number"),
        ("start.theta=nan", "start.theta: nan is not valid; must be a finite number"),
        ("robot.upper_link=.inf", "robot.upper_link: inf is not valid; must be a fi"),
        (
            "source.segments=[{duration: 1}, {v_c: .nan}]",
            "source.segments[1].v_c: nan is not valid; must be a finite number",
        ),
        (
            "source.segments=[{duration: -1}]",
            "source.segments[0].duration: -1.0 is not valid; must be within [1e-06, 1",
        ),
        ("duration=0", "duration: 0.0 is not valid; must be at least period = 0.0"),
        ("duration=-2", "duration: -2.0 is not valid; must be within [0, 1e+06] s"),
        ("duration=1e-3", "duration: 0.001 is not valid; must be at least period = 0"),
        ("period=0", "period: 0.0 is not valid; must be within [0.0001, 0.2] s"),
        ("workspace.l_min=1.6", "workspace.l_min: 1.6 is not valid; must be below l_"),
        ("workspace.psi_max=-1", "workspace.psi_min: -0.7 is not valid; must be below"),
        ("robot.upper_link=-1", "robot.upper_link: -1.0 is not valid; must be within"),
        ("robot.lower_link=0", "robot.lower_link: 0.0 is not valid; must be within ["),
        ("start.l=2.5", "out of reach; the nearest is l = 2.0, psi = 0.0, z = 0.0"),
        ("start.l=-0.1", "out of reach; the nearest is l = 0.0, psi = 0.0, z = 0.0"),
        ("start.z=0.2", "out of reach; the nearest is l = 0.0, psi = 0.0, z = 0.0"),
        ("start.psi=4", "must keep joint shoulder within [-3.4, 4.9] rad"),
        ("fidelity=perfect", "fidelity: 'perfect' is not valid; must be one of !Kin"),
        ("inverse=newton", "inverse: 'newton' is not valid; must be one of position"),
        ("projection.sigma=0", "projection.sigma: 0.0 is not valid; must be within ["),
        ("guard.max_v_c=0", "guard.max_v_c: 0.0 is not valid; must be within [0.0"),
        ("guard.stop_time=-1", "guard.stop_time: -1.0 is not valid; must be within ["),
        ("decomposer.alpha=-1", "decomposer.alpha: -1.0 is not valid; must be within"),
        (
            "smoother=!Smoother {smoothing: 2}",
            "smoother.smoothing: 2.0 is not valid; must be withi",
        ),
        ("duration", "'duration' is not valid; must be key.path=value"),
        ("start.l.m=1", "must lead through mappings"),
        ("duration=[1", "must be YAML"),
    ],
)
def test_bad_value_is_refused_in_one_line(override, says):
    with pytest.raises(ScenarioError) as refusal:
        load_scenario("kwon_1", [override])
    message = str(refusal.value)
    assert says in message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a: b: c", "mapping values are not allowed here"),
        ("- 1\n- 2", "the whole: [1, 2] is not valid; must be a mapping"),
        ("\tduration: 1", "that cannot start any token"),
        ("duration: 1\nduration: 2", "the key 'duration' is given twice"),
        ("decomposer: !Foo {}", "decomposer: '!Foo' is not valid; must be one of !"),
        ("just words", "the whole: 'just words' is not valid; must be a mapping"),
        ("duration: 1\n\x00", "must be YAML"),
    ],
)
def test_bad_file_is_refused_in_one_line_that_names_it(tmp_path, text, says):
    file = tmp_path / "mine.yaml"
    file.write_text(text)
    with pytest.raises(ScenarioError) as refusal:
        load_scenario(str(file))
    message = str(refusal.value)
    assert message.startswith("mine.yaml: ")
    assert says in message
    assert "\n" not in message


def test_file_that_is_not_text_is_refused(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_bytes(b"\xff\xfe\x80")
    with pytest.raises(ScenarioError, match="cannot be read"):
        load_scenario(str(file))


def test_unknown_scenario_is_refused_with_the_names_that_are_known():
    with pytest.raises(ScenarioError, match="no such scenario; valid names are kwon_1"):
        load_scenario("kwon_99")


def test_scenario_from_an_empty_file_is_all_defaults(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("")
    scenario = load_scenario(str(file))
    assert (scenario, scenario.name) == (Teleop(), "mine")


def test_tag_by_itself_means_all_defaults():
    assert load_yaml("!Switching") == {"_tag": "!Switching"}
