"""YAML against a dataclass: whatever a text holds, a value or one line comes of it."""

import dataclasses as dc
import time

import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st

from drake_mobman.parameters import ParameterError
from drake_mobman.robots.defaults import Start
from drake_mobman.scenario import Guided, ScenarioError, Teleop, load_scenario
from drake_mobman.schema import (
    dump_typed,
    dump_yaml,
    load_typed,
    load_yaml,
    with_override,
)


@pytest.mark.parametrize(
    ("override", "says"),
    [
        ("source=!Script [1]", "--set: source, line 1, column 1: '!Script goes befor"),
        ("source=!Script foo", "!Script goes before a mapping, as in !Script {}"),
        ("decomposer=!Switching foo", "!Switching goes before a mapping, as in !Swi"),
        ("source.segments=[!Held 1]", "!Held goes before a mapping, as in !Held {}"),
        ("duration=!!int abc", "'abc' is not a valid !!int"),
        ("duration=!!int ''", "'' is not a valid !!int"),
        ("duration=!!float x", "'x' is not a valid !!float"),
        ("compiled=!!bool maybe", "'maybe' is not a valid !!bool"),
        ("description=!!timestamp abc", "there is no tag tag:yaml.org,2002:timestamp"),
        ("description=!!binary '~'", "there is no tag tag:yaml.org,2002:binary"),
        ("description=!!set {a}", "there is no tag tag:yaml.org,2002:set"),
        ("description=!!str {a: 1}", "expected a scalar node, but found mapping"),
        ('description="\\Uffffffff"', "must be YAML"),
        ("start={? [1] : 2}", "a key must be text"),
        ("start=&a {l: *a}", "found unconstructable recursive node"),
        (f"duration={'9' * 5000}", "duration: inf is not valid; must be a finite num"),
        (f"source.repeat={'9' * 5000}", "source.repeat: inf is not valid; must be a "),
        (f"duration={'[' * 5000}", "line 1, column 41: 'nested too deeply'"),
        (f"{'a.' * 3000}b=1", "valid keys are: description"),
        ("source.repeat=1e300", "must be within [1, 50000] for 2 segments"),
        ("robot.upper_link=1e155", "must be within [0.01, 10] m"),
        ("robot.upper_link=1e-308", "must be within [0.01, 10] m"),
        ("fidelity=!Servo {step: 1e-320}", "fidelity.step: 1e-320 is not valid; must "),
        ("workspace.l_max=50", "workspace.l_max: 50.0 is not valid; must be within [0"),
        ("period=5", "period: 5.0 is not valid; must be within [0.0001, 0.2] s"),
        ("decomposer.alpha=5e-324", "must be within [0.1, 10000] 1/m"),
        ("duration=1:30", "duration: '1:30' is not valid; must be a number"),
        ("duration=1_0", "duration: '1_0' is not valid; must be a number"),
        ("on=1", "on: 1 is not valid; valid keys are: description"),
        ("smoother.enabled=on", "smoother.enabled: 'on' is not valid; must be true"),
        ("start.l.=1", "start.l.: 1 is not valid; must be at keys joined by dots"),
        ("start..l=1", "start..l: 1 is not valid; must be at keys joined by dots"),
        ("start.l.m.n=1", "--set: start.l.m.n: 0.0 is not valid; must lead through m"),
        ('description="a\\nb"', r"description: 'a\nb' is not valid; must be a line of"),
        (
            'description="\\e[31m"',
            r"description: '\x1b[31m' is not valid; must be a li",
        ),
        (
            'description="\\ud800"',
            r"description: '\ud800' is not valid; must be a line",
        ),
    ],
)
def test_what_yaml_can_hold_is_refused_in_one_line(override, says):
    with pytest.raises(ScenarioError) as refusal:
        load_scenario("kwon_1", [override])
    message = str(refusal.value)
    assert says in message
    assert message.isprintable()
    assert len(message) < 500


def test_hand_that_is_led_too_far_too_fast_is_refused():
    far = "hand.path=[{x: 0.58, z: 0.523}, {time: 1, x: 1e5, z: 0.523}]"
    with pytest.raises(ScenarioError, match=r"hand.path\[1\].x: 100000.0 is not valid"):
        load_scenario("petric_guided", [far])
    fast = "hand.path=[{x: 0.58, z: 0.523}, {time: 1, x: 50, z: 0.523}]"
    with pytest.raises(ScenarioError, match="the base follows at most 10 m/s"):
        load_scenario("petric_guided", [fast, "smoother=unsmoothed"])


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1),
        ("-17", -17),
        ("010", 10),
        ("1e-3", 1e-3),
        ("+1.5E3", 1500.0),
        (".5", 0.5),
        ("-.inf", float("-inf")),
        ("true", True),
        ("False", False),
        ("~", None),
        ("", None),
        ("on", "on"),
        ("yes", "yes"),
        ("1:30", "1:30"),
        ("2026-02-30", "2026-02-30"),
        ("0x10", "0x10"),
        ("'1'", "1"),
        ("<<", "<<"),
        ("on: 1", {"on": 1}),
        ("1: 2", {"1": 2}),
        ("[1, [two, {three: 4}]]", [1, ["two", {"three": 4}]]),
        ("[&a {b: 1}, *a]", [{"b": 1}, {"b": 1}]),
        ("!Held {duration: 2}", {"_tag": "!Held", "duration": 2}),
    ],
)
def test_yaml_is_that_of_version_1_2(text, value):
    found = load_yaml(text)
    assert found == value
    assert type(found) is type(value)


@given(st.text().filter(lambda text: text.rstrip("\n") == text and text.isprintable()))
@example("1e5")
@example("on")
@example("2026-02-30")
@example("nan")
@example("0o17")
@example("~")
@example("<<")
def test_any_line_of_text_comes_back_as_it_was(text):
    scenario = Teleop(description=text)
    assert load_typed(Teleop | Guided, load_yaml(dump_typed(scenario))) == scenario
    # And to others, who read YAML 1.1, it is text too.
    assert yaml.safe_load(dump_yaml({"text": text})) == {"text": text}


def test_text_may_end_in_the_line_break_that_yaml_gives_it():
    text = "description: >\n  Two lines\n  that are one.\n"
    assert load_typed(Teleop, load_yaml(text)).description == "Two lines that are one."


def test_what_is_not_told_is_as_where_it_stands():
    scenario = load_typed(Guided, {"start": {"psi": 0.01}})
    assert scenario.start == dc.replace(Guided().start, psi=0.01)
    assert scenario.start != Start(psi=0.01)


def test_overrides_leave_what_they_change_as_it_was():
    before = {"a": {"b": 1}, "c": "Exact"}
    after = with_override(with_override(before, "a.b", 2), "c.d", 3)
    assert after == {"a": {"b": 2}, "c": {"_tag": "Exact", "d": 3}}
    assert before == {"a": {"b": 1}, "c": "Exact"}


def test_reading_takes_time_in_proportion_to_the_text():
    def seconds(keys):
        text = "\n".join(f"k{i}: 1" for i in range(keys))
        start = time.process_time()
        load_yaml(text)
        return time.process_time() - start

    few = min(seconds(2_000) for _ in range(3))
    assert seconds(32_000) < 5 * 16 * few


def test_aliases_of_aliases_cost_nothing():
    lists = [f"l{i}: &l{i} [{', '.join([f'*l{i - 1}'] * 9)}]" for i in range(1, 30)]
    text = "\n".join(["l0: &l0 [x, x]", *lists])
    with pytest.raises(ParameterError) as refusal:
        load_typed(Teleop, load_yaml(text))
    assert len(str(refusal.value)) < 2000
