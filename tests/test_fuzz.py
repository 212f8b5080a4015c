"""Whatever a scenario says, it runs, or it is refused in one line.

Values are made for every field of every dataclass that a scenario may hold, found by
the dataclasses' own types; and text is made that is nearly YAML. Each case is tried in
a process of its own, so that one that ends or stops the process is told like any other.
"""

import collections
import contextlib
import dataclasses as dc
import json
import math
import select
import subprocess
import sys
import typing
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drake_mobman.parameters import ParameterError, checked
from drake_mobman.scenario import AnyScenario, load_scenario, scenario_paths

PATIENCE = 60.0
"""How long a case may take [s]: on a busy machine, the longest takes ten."""

ENOUGH = 250
"""Cases that a process tries: each leaves some megabytes of Drake's behind."""

SCENARIOS = {name: type(load_scenario(name)) for name in scenario_paths()}


# A process that tries cases.


class Worker:
    """Tries cases in a process, which is replaced after some, or by one it has cost."""

    def __init__(self):
        self.counts = collections.Counter()
        self.process = None
        self.tried = 0

    def try_out(self, case):
        """Fails where what becomes of a case is not as it must be."""
        self.tried += 1
        if self.tried % ENOUGH == 0:
            self.close()
        if self.process is None:
            self.process = subprocess.Popen(
                [sys.executable, Path(__file__).with_name("fuzz_worker.py")],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
            )
        line = self.answer_to(case)
        if not line.endswith("\n"):
            status = self.close()
            pytest.fail(f"the process {line or 'ended'}, status {status}: {case}")
        answer = json.loads(line)
        self.counts[answer if answer in {"ran", "refused"} else "escaped"] += 1
        assert answer in {"ran", "refused"}, f"{case}: {answer}"

    def answer_to(self, case):
        """Returns the line that the process answers, or what it says of it instead."""
        try:
            self.process.stdin.write(json.dumps(case) + "\n")
            self.process.stdin.flush()
        except BrokenPipeError:
            return ""
        waited, _, _ = select.select([self.process.stdout], [], [], PATIENCE)
        if not waited:
            self.process.kill()
            return "hangs"
        return self.process.stdout.readline()

    def close(self):
        """Ends the process; returns its status."""
        process, self.process = self.process, None
        if process is None:
            return 0
        with contextlib.suppress(BrokenPipeError):
            process.stdin.close()
        try:
            return process.wait(timeout=5)
        except subprocess.TimeoutExpired:
            process.kill()
            return process.wait()


@pytest.fixture(scope="module")
def worker():
    made = Worker()
    yield made
    made.close()
    print(dict(made.counts))  # noqa: T201 - What a study is for; shown by `-s`.


# Values for every field.

SIZES = [0.0, 5e-324, 1e-308, 1e-16, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e16, 1e155, 1e308]
ODD_NUMBERS = st.sampled_from(
    [*SIZES, *(-size for size in SIZES), math.inf, math.nan, 10**30, 2**63]
)
ODD_WORDS = st.sampled_from(["", " ", "\n", "\x1b[31m", "\x00", "\ud800", "/dev/zero"])
ODD_VALUES = st.recursive(
    st.none() | st.booleans() | st.text(max_size=5) | ODD_NUMBERS | ODD_WORDS,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.text(max_size=3), inner, max_size=3)
    ),
    max_leaves=4,
)


TAG = object()
"""Key of a mapping's tag."""


def flow(data):
    """Returns data as YAML, in the style that is nearly JSON."""
    if isinstance(data, dict):
        pairs = ((key, flow(value)) for key, value in data.items() if key is not TAG)
        inner = ", ".join(f"{json.dumps(key)}: {value}" for key, value in pairs)
        return f"{data.get(TAG, '')} {{{inner}}}".lstrip()
    if isinstance(data, list):
        return f"[{', '.join(map(flow, data))}]"
    if isinstance(data, float) and not math.isfinite(data):
        return f"{data}".replace("nan", ".nan").replace("inf", ".inf")
    return json.dumps(data)


def members_of(schema):
    """Returns the dataclasses that a union, a list or a dataclass is of."""
    if typing.get_origin(schema) is list:
        return members_of(typing.get_args(schema)[0])
    return typing.get_args(schema) or ((schema,) if dc.is_dataclass(schema) else ())


def words(params, key):
    """Returns the words that a field of text takes, as its refusal tells them."""
    try:
        checked(dc.replace(params, **{key: "?"}))
    except ParameterError as error:
        listed = error.valid.removeprefix("must be one of ")
        return listed.split(", ") if listed != error.valid else []
    return []


def rarely(often):
    """Returns whether something is to be, once in so many times."""
    # Ends of a range are drawn more often than that.
    return st.integers(0, often - 1).map(lambda i: i == often // 2)


@st.composite
def numbers(draw, usual):
    """Draws a number: mostly of the size of the usual one, or one that is odd."""
    if draw(rarely(10)):
        return draw(ODD_NUMBERS | st.floats())
    decades = draw(st.sampled_from([0.2, 0.5, 1.5]))
    factor = 10.0 ** draw(st.floats(-decades, decades))
    sign = draw(st.sampled_from([1.0, 1.0, 1.0, 1.0, 1.0, -1.0]))
    return sign * (usual or 0.1) * factor


@st.composite
def values(draw, schema, usual, holder=None, key=""):
    """Draws what is nearly YAML data for a type, given what it usually is."""
    if draw(rarely(40)):
        return draw(ODD_VALUES)
    if typing.get_origin(schema) is list:
        (item,) = typing.get_args(schema)
        usual = members_of(item)[0]()
        return draw(st.lists(values(item, usual), max_size=3))
    if members := members_of(schema):
        member = draw(st.sampled_from(members))
        params = usual if isinstance(usual, member) else member()
        tag = {TAG: f"!{member.__name__}"} if typing.get_args(schema) else {}
        return tag | draw(mappings(params, most=3))
    if schema is str:
        return draw(st.sampled_from([usual, *words(holder, key)]) | ODD_WORDS)
    plain = {
        bool: st.booleans(),
        float: numbers(usual),
        int: st.integers(-1, 3 * usual) | ODD_NUMBERS,
    }
    return draw(plain[schema])


@st.composite
def mappings(draw, params, most):
    """Draws data for some fields of a dataclass."""
    fields = dc.fields(params)
    chosen = draw(st.lists(st.sampled_from(fields), max_size=most)) if fields else []
    return {
        f.name: draw(values(f.type, getattr(params, f.name), params, f.name))
        for f in chosen
    }


@st.composite
def changed_scenarios(draw):
    """Draws a scenario of the package with some of its fields changed."""
    name = draw(st.sampled_from(sorted(SCENARIOS)))
    data = draw(mappings(SCENARIOS[name](), most=4))
    texts = [f"{key}={flow(value)}" for key, value in data.items()]
    return {"name": name, "text": None, "overrides": texts}


# Text that is nearly YAML.

WORDS = r"""
!Script !Held !Teleop !!int !!bool !!float !!null !!set !!binary !!timestamp !<x> ! &a
*a << ? : - , { } [ ] [[[[[[[[ ' " > | # %YAML --- ... \Uffffffff "\U99999999" 1:30 on ~
= 2026-02-30 .nan .inf 1e300 0x 0o 1_0 @ ` start source decomposer duration segments
"""
PIECES = st.sampled_from(
    [
        *WORDS.split(),
        "? ",
        ": ",
        "- ",
        " ",
        "\n",
        "\n  ",
        "\t",
        "\x00",
        "\x85",
        "\ufeff",
    ]
) | st.sampled_from(["9" * 30, "9" * 5000, "[" * 3000, "!a " * 30])


@st.composite
def mangled_texts(draw):
    """Draws text, or a scenario of the package with pieces cut out and put in."""
    if draw(rarely(5)):
        return draw(st.text() | st.binary().map(lambda b: b.decode("latin-1")))
    text = draw(st.sampled_from(sorted(scenario_paths().values()))).read_text()
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(text)))
        cut = draw(st.integers(0, 20))
        text = text[:at] + draw(PIECES | st.just("")) + text[at + cut :]
    return text


@st.composite
def mangled_files(draw):
    """Draws a file; not all of its bytes need be text."""
    text = draw(mangled_texts())
    as_bytes = text.encode("utf-8", "surrogatepass").decode("latin-1")
    name = draw(st.sampled_from(["mine.yaml", "[bold].yaml", "scenario.yaml"]))
    return {"name": name, "text": as_bytes, "overrides": []}


CASES = changed_scenarios() | changed_scenarios() | mangled_files()
QUIETLY = settings(
    suppress_health_check=list(HealthCheck), max_examples=150, print_blob=True
)


@QUIETLY
@given(case=CASES)
def test_scenario_runs_or_is_refused_in_one_line(worker, case):
    worker.try_out(case)


@pytest.mark.slow
@settings(QUIETLY, max_examples=10_000, derandomize=False)
@given(case=CASES)
def test_ten_thousand_scenarios_run_or_are_refused_in_one_line(worker, case):
    worker.try_out(case)


# What needs no process.


def all_parameters(schema, found=()):
    """Returns the dataclasses that may stand in a scenario, at any depth."""
    for member in members_of(schema):
        if member not in found:
            found = (*found, member)
            for field in dc.fields(member):
                found = all_parameters(field.type, found)
    return found


NUMBERS = [
    (params, field.name)
    for params in all_parameters(AnyScenario)
    for field in dc.fields(params)
    if field.type in (float, int)
]


@pytest.mark.parametrize(
    ("kind", "key"), NUMBERS, ids=lambda x: getattr(x, "__name__", x)
)
def test_every_number_has_a_range_on_both_sides(kind, key):
    for value in (1e9, -1e9):
        with pytest.raises(ParameterError) as refusal:
            checked(dc.replace(kind(), **{key: value}))
        assert refusal.value.key == key
