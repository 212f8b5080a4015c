"""Programs do what their laws do, to the last bit."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.math import atan2, sin, sqrt
from pydrake.symbolic import (
    Expression,
    Variable,
    if_then_else,
    logical_and,
    logical_not,
    logical_or,
    uninterpreted_function,
)
from pydrake.symbolic import max as symbolic_max
from pydrake.symbolic import min as symbolic_min

from drake_mobman.machine_code import machine_code
from drake_mobman.operations import Constant, Input, Step, programs
from drake_mobman.tracing import tracing

X, Y = Variable("x"), Variable("y")

LAWS = {
    "sums": lambda x, y: 2 * x - 3 * y + x * y + 1,
    "quotients": lambda x, y: (x + 1) / (y + 2),
    "powers": lambda x, _: sqrt(x * x) + x**2,
    "functions": lambda x, y: atan2(sin(x), y),
    "choices": lambda x, y: if_then_else(x < y, x, 2 * y),
    "logic": lambda x, y: if_then_else(
        logical_or(logical_and(x < y, logical_not(x > 0)), y == x), x, y
    ),
    "extremes": lambda x, y: symbolic_min(x, 1 * y) + symbolic_max(x, 1 * y),
}

floats = st.floats(-1e3, 1e3) | st.sampled_from([0.0, -0.0, 1.0])


def program(*results, inputs=(X, Y)):
    with tracing() as trace:
        (found,) = programs(trace, [(inputs, results)])
    return found


@pytest.mark.parametrize("name", LAWS)
@given(x=floats, y=floats)
def test_a_program_gives_what_drake_makes_of_the_expression(name, x, y):
    law = LAWS[name](Expression(X), Expression(Y))
    with tracing() as trace:
        (function,) = machine_code(trace, [((X, Y), [law])])
    (found,) = function([x, y])
    try:
        expected = law.Evaluate({X: x, Y: y})
    except RuntimeError:  # Drake refuses NaN; a program has it.
        assert math.isnan(found)
    else:
        assert found == expected


def test_each_operation_is_worked_out_once():
    wave = sin(Expression(X))
    kinds = [each.kind for each in program(wave * wave + wave, wave / 2).operations]
    assert kinds.count("sin") == 1


def test_what_no_result_needs_is_left_out():
    with tracing() as trace:
        first, second = programs(
            trace, [((X,), [sin(Expression(X))]), ((X,), [1 * X + 1])]
        )
    assert [each.kind for each in first.operations] == ["sin"]
    assert [each.kind for each in second.operations] == ["add"]


def test_zero_and_minus_zero_are_not_the_same_operand():
    """They are equal, but atan2 tells them apart where the other number is negative."""
    found = program(atan2(Expression(0.0), 1 * X), atan2(Expression(-0.0), 1 * X))
    assert len(found.operations) == 2


def test_places_of_different_kinds_are_not_the_same_operand():
    assert len({Input(1), Step(1), Constant(1.0)}) == 3


def test_a_law_that_uses_a_variable_it_is_not_given_is_refused():
    with pytest.raises(TypeError, match="not given"):
        program(Expression(Y), inputs=(X,))


def test_an_operation_that_is_not_known_is_refused():
    with pytest.raises(TypeError, match="no operation that can be compiled"):
        program(uninterpreted_function("f", [1 * X]))


def test_inputs_that_are_used_are_told():
    assert program(1 * Y).used() == {1}
