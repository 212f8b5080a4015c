"""Minima and maxima for each scalar type: none lets what is not a number vanish."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.autodiffutils import AutoDiffXd
from pydrake.symbolic import Expression, MakeVectorVariable
from pydrake.systems.primitives import SymbolicVectorSystem

from drake_mobman.decomposers.switching import switched_share
from drake_mobman.scalars import larger, saturated, smaller, smallest, smoothstep

LAWS = {
    "smaller": (smaller, 2),
    "larger": (larger, 2),
    "smallest": (smallest, 3),
    "saturated": (lambda x, limit: saturated(x, abs(limit)), 2),
    "smoothstep": (lambda x: smoothstep(x, -1.0, 2.0), 1),
    "one of two is a constant": (lambda x, y: smaller(1.0, x) + larger(y, 1.0), 2),
    "share that switches at its upper limit": (
        lambda x: switched_share(1.0, x, -1.0, 2.0),
        1,
    ),
    "share that switches at its lower limit": (
        lambda x: switched_share(-1.0, x, -1.0, 2.0),
        1,
    ),
}
"""Each with its number of arguments."""


def by_floats(law, values):
    return law(*values)


def by_numpy(law, values):
    return law(*np.array(values))


def by_autodiff(law, values):
    found = law(*[AutoDiffXd(x, np.eye(len(values))[i]) for i, x in enumerate(values)])
    return found.value() if isinstance(found, AutoDiffXd) else float(found)


def by_expressions(law, values):
    """As compiled blocks evaluate it, which take what is not a number."""
    x = MakeVectorVariable(len(values), "x")
    system = SymbolicVectorSystem(input=x, output=[law(*map(Expression, x))])
    context = system.CreateDefaultContext()
    system.get_input_port().FixValue(context, values)
    return system.get_output_port().Eval(context)[0]


every_scalar = pytest.mark.parametrize(
    "found_by", [by_floats, by_numpy, by_autodiff, by_expressions]
)


@every_scalar
@pytest.mark.parametrize("name", LAWS)
def test_what_is_not_a_number_stays_none(name, found_by):
    law, count = LAWS[name]
    for rest in itertools.product([-2.0, 0.0, 0.5, math.inf], repeat=count - 1):
        for i in range(count):
            told = [*rest[:i], math.nan, *rest[i:]]
            assert math.isnan(found_by(law, told)), told


NUMBERS = st.one_of(
    st.floats(-3, 3), st.sampled_from([0.0, -0.0, math.inf, -math.inf, 1e-300])
)


@every_scalar
@given(values=st.lists(NUMBERS, min_size=2, max_size=5))
def test_of_numbers_it_is_the_smallest_or_the_largest_to_the_bit(found_by, values):
    assert found_by(smallest, values) == sorted(values)[0]
    pair = values[:2]
    assert found_by(smaller, pair) == sorted(pair)[0]
    assert found_by(larger, pair) == sorted(pair)[1]
