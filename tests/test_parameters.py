"""Checks of parameters: each names the key, its value and what is valid."""

import dataclasses as dc
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_mobman.base.smoother import Smoother
from drake_mobman.decomposers.blending import Blending
from drake_mobman.parameters import (
    ParameterError,
    checked,
    in_order,
    not_negative,
    one_of,
    positive,
)
from drake_mobman.robots.spatial import Spatial
from drake_mobman.scenario import Teleop
from drake_mobman.teleop.scripted import Held, Script, Smooth

NOT_FINITE = st.sampled_from([math.nan, math.inf, -math.inf])


@dc.dataclass
class Leaf:
    size: float = 1.0
    low: float = 0.0
    high: float = 1.0
    kind: str = "a"
    count: int = 2

    def check(self):
        positive(self, "size")
        not_negative(self, "count")
        in_order(self, "low", "high")
        one_of(self, "kind", ("a", "b"))


@dc.dataclass
class Branch:
    leaf: Leaf = dc.field(default_factory=Leaf)
    leaves: list[Leaf] = dc.field(default_factory=list)
    numbers: list[float] = dc.field(default_factory=list)
    table: list[list[float]] = dc.field(default_factory=list)


@dc.dataclass
class Tree:
    branch: Branch = dc.field(default_factory=Branch)


@pytest.mark.parametrize(
    ("leaf", "message"),
    [
        (Leaf(size=0.0), "size: 0.0 is not valid; must be above 0"),
        (Leaf(size=-1.5), "size: -1.5 is not valid; must be above 0"),
        (Leaf(count=-1), "count: -1 is not valid; must be 0 or above"),
        (Leaf(low=1.0), "low: 1.0 is not valid; must be below high = 1.0"),
        (Leaf(low=2, high=1.5), "low: 2 is not valid; must be below high = 1.5"),
        (Leaf(kind="c"), "kind: 'c' is not valid; must be one of a, b"),
        (Leaf(size=math.nan), "size: nan is not valid; must be a finite number"),
        (Leaf(high=math.inf), "high: inf is not valid; must be a finite number"),
    ],
)
def test_message_names_key_value_and_what_is_valid(leaf, message):
    with pytest.raises(ParameterError) as error:
        checked(leaf)
    assert str(error.value) == message
    found = error.value
    assert message == f"{found.key}: {found.value!r} is not valid; {found.valid}"


@pytest.mark.parametrize(
    ("tree", "key"),
    [
        (Tree(Branch(leaf=Leaf(size=-1.0))), "branch.leaf.size"),
        (Tree(Branch(leaf=Leaf(low=math.nan))), "branch.leaf.low"),
        (Tree(Branch(leaves=[Leaf(), Leaf(kind="c")])), "branch.leaves[1].kind"),
        (Tree(Branch(leaves=[Leaf(high=math.inf)])), "branch.leaves[0].high"),
        (Tree(Branch(numbers=[0.0, -math.inf])), "branch.numbers[1]"),
        (Tree(Branch(table=[[0.0], [1.0, math.nan]])), "branch.table[1][1]"),
        (Tree(Branch(numbers=[np.float64("nan")])), "branch.numbers[0]"),
    ],
)
def test_key_is_the_whole_path(tree, key):
    with pytest.raises(ParameterError) as error:
        checked(tree)
    assert error.value.key == key
    assert str(error.value).startswith(f"{key}: ")


def test_what_is_valid_comes_back_itself():
    tree = Tree(Branch(leaves=[Leaf()], numbers=[1.0], table=[[2.0]]))
    assert checked(tree) is tree


def test_it_is_a_value_error_with_one_line():
    with pytest.raises(ValueError, match="size") as error:
        checked(Leaf(size=math.nan))
    assert "\n" not in str(error.value)


def test_not_a_number_passes_no_comparison():
    # Where a block calls them by themselves, before any look at finiteness.
    nan = Leaf(size=math.nan, low=math.nan)
    for check in (
        lambda: positive(nan, "size"),
        lambda: not_negative(nan, "size"),
        lambda: in_order(nan, "low", "high"),
        lambda: in_order(Leaf(high=math.nan), "low", "high"),
    ):
        with pytest.raises(ParameterError):
            check()


@pytest.mark.parametrize(
    ("params", "key"),
    [
        (Smoother(smoothing=1.5), "smoothing"),
        (Smoother(smoothing=0.0), "smoothing"),
        (Smoother(max_yaw_acceleration=-1.0), "max_yaw_acceleration"),
        (Blending(beta=0.0), "beta"),
        (Spatial(hand=0.0), "hand"),
        (Spatial(shoulder_height=-0.1), "shoulder_height"),
        (Script([Held(), Smooth(duration=0.0)]), "segments[1].duration"),
    ],
)
def test_blocks_parameters_are_told_by_name(params, key):
    with pytest.raises(ParameterError) as error:
        checked(params)
    assert error.value.key == key


def paths(params, path=()):
    """Yields the path of every number of a dataclass, however deep."""
    for field in dc.fields(params):
        value = getattr(params, field.name)
        if dc.is_dataclass(value):
            yield from paths(value, (*path, field.name))
        elif isinstance(value, float):
            yield (*path, field.name)


@given(path=st.sampled_from(sorted(paths(Teleop()))), value=NOT_FINITE)
def test_not_finite_is_refused_anywhere_in_a_scenario(path, value):
    scenario = Teleop()
    holder = scenario
    for key in path[:-1]:
        holder = getattr(holder, key)
    setattr(holder, path[-1], value)
    with pytest.raises(ParameterError) as error:
        checked(scenario)
    assert error.value.key == ".".join(path)
    assert error.value.valid == "must be a finite number"


@given(index=st.integers(0, 2), key=st.sampled_from(["duration", "v_c", "v_z"]))
def test_not_finite_is_refused_in_any_segment(index, key):
    segments = [Held(), Smooth(), Held()]
    setattr(segments[index], key, math.nan)
    with pytest.raises(ParameterError) as error:
        checked(Teleop(source=Script(segments)))
    assert error.value.key == f"source.segments[{index}].{key}"
