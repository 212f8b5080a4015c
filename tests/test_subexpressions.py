"""Common subexpressions are named, and nothing else changes."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.symbolic import Expression, Variable, atan2, cos, if_then_else, sin
from pydrake.symbolic import max as larger

from drake_mobman.subexpressions import eliminate_common_subexpressions

X, Y = Variable("x"), Variable("y")


def tree(depth):
    """Returns an expression that takes itself twice, `depth` times over."""
    e = 1 * X
    for k in range(depth):
        e = sin(e) * cos(e) + atan2(e, 2.0 + k) + if_then_else(e > Y, e, 0.5 * e)
    return e


def value(names, law, x, y):
    """Returns what a law is, worked out name by name."""
    env = {X: x, Y: y}
    for named in names:
        env[named.variable] = named.law.Evaluate(env)
    return law.Evaluate(env)


@given(x=st.floats(-2, 2), y=st.floats(-2, 2), worth=st.sampled_from([2, 10, 1000]))
def test_values_stay_the_same_to_the_last_bit(x, y, worth):
    laws = [tree(3), tree(4) * Y, Expression(7.0), 1 * Y]
    names, rewritten = eliminate_common_subexpressions(laws, worth)
    for law, other in zip(laws, rewritten, strict=True):
        assert value(names, other, x, y) == law.Evaluate({X: x, Y: y})


def test_an_expression_that_doubles_each_time_is_told_in_a_line_each():
    depth = 6
    names, (law,) = eliminate_common_subexpressions([tree(depth)])
    assert len(str(tree(depth))) > 100_000
    assert len(str(law)) + sum(len(str(n.law)) for n in names) < 5_000


def test_levels_say_what_is_built_on_what():
    names, _ = eliminate_common_subexpressions([tree(5)])
    levels = {n.variable.get_id(): n.level for n in names}
    for named in names:
        below = [levels.get(v.get_id(), -1) for v in named.law.GetVariables()]
        assert named.level == max(below) + 1


def test_what_is_used_once_gets_no_name():
    assert eliminate_common_subexpressions([sin(X) + cos(Y), 3 * X], worth=1)[0] == []


def test_constants_are_not_taken_for_variables_that_are_numbered_alike():
    number = float(X.get_id())
    law = number * X + sin(number * Y) + larger(number + 0 * X, Y)
    _, (rewritten,) = (
        eliminate_common_subexpressions([law, law], worth=1)[0],
        eliminate_common_subexpressions([law])[1],
    )
    at = {X: 0.3, Y: 0.7}
    assert rewritten.Evaluate(at) == pytest.approx(
        number * 0.3 + math.sin(number * 0.7) + max(number, 0.7)
    )
    assert np.isfinite(rewritten.Evaluate(at))
