"""Laws as operations in order: traced once on Expressions, each worked out once.

Such a program has no branches and no loops. It is printed as machine code, as C, or as
Python for arrays; whatever it becomes, the operations and their order are the same.
"""

import dataclasses as dc
from collections.abc import Sequence
from typing import Any, NamedTuple

from pydrake.symbolic import Expression, ExpressionKind, FormulaKind, Variable

from drake_mobman.scalars import Scalar
from drake_mobman.tracing import Trace

FUNCTIONS = {
    getattr(ExpressionKind, name): name.lower()
    for name in (
        *("Sqrt", "Abs", "Floor", "Ceil", "Pow"),
        *("Sin", "Cos", "Tan", "Asin", "Acos", "Atan", "Atan2"),
        *("Sinh", "Cosh", "Tanh", "Exp", "Log"),
    )
}
"""Kinds of operations that are functions of C's library, some by another name there."""

_COMPARISONS = {
    FormulaKind.Eq: "eq",
    FormulaKind.Neq: "ne",
    FormulaKind.Gt: "gt",
    FormulaKind.Geq: "ge",
    FormulaKind.Lt: "lt",
    FormulaKind.Leq: "le",
}
"""As in C: with NaN, all are false but `ne`."""

_CONNECTIVES = {FormulaKind.And: "and", FormulaKind.Or: "or"}

_FOLDED = {
    ExpressionKind.Add: ("add", 0.0),
    ExpressionKind.Mul: ("mul", 1.0),
}
"""Operations on several operands, and the constant that changes nothing."""


@dc.dataclass(frozen=True)
class Input:
    """A number that a law is given, by its place."""

    place: int


@dc.dataclass(frozen=True)
class Step:
    """What an operation gives, by its place."""

    place: int


@dc.dataclass(frozen=True)
class Constant:
    """A number, or whether something holds, that a law knows by itself."""

    value: float | bool


_ARITHMETIC = {*FUNCTIONS, ExpressionKind.Div, ExpressionKind.Min, ExpressionKind.Max}

Operand = Input | Step | Constant


class Operation(NamedTuple):
    """One operation.

    Its kind is `add`, `mul`, `div`, one of `FUNCTIONS`, a comparison (`eq`, `ne`, `gt`,
    `ge`, `lt`, `le`), `and`, `or`, `not`, or `select`: of its three operands the second
    where the first holds, else the third.
    """

    kind: str
    operands: tuple[Operand, ...]

    @property
    def is_truth(self) -> bool:
        """Returns whether it gives no number, but whether something holds."""
        return self.kind in _TRUTHS


_TRUTHS = {*_COMPARISONS.values(), *_CONNECTIVES.values(), "not"}

Law = tuple[Sequence[Variable], Sequence[Scalar]]
"""Variables, and results that depend on them."""


@dc.dataclass(frozen=True)
class Program:
    """A law as operations in order, each in terms of those before it."""

    num_inputs: int
    operations: tuple[Operation, ...]
    results: tuple[Operand, ...]

    def used(self) -> set[int]:
        """Returns the places of the inputs that it uses."""
        every = (*(x for each in self.operations for x in each.operands), *self.results)
        return {x.place for x in every if isinstance(x, Input)}


def programs(trace: Trace, laws: Sequence[Law]) -> list[Program]:
    """Returns laws as programs, each of only those operations that it needs.

    Args:
        trace: what the laws have named.
        laws: for each its variables, in the order in which it takes numbers, and its
            results.

    Raises:
        TypeError: where an expression has an operation that is not known here, or a
            variable that is not its law's.
    """
    code = _Code()
    for name, named in trace.needed([result for _, law in laws for result in law]):
        code.named[name.get_id()] = code.value(named)
    return [code.program(variables, law) for variables, law in laws]


class _Code:
    """Operations in order, each of which no other is like.

    A variable that is not named is its id, until `program` knows its place.
    """

    def __init__(self) -> None:
        self.named: dict[int, Operand] = {}  # What variables stand for, by their ids.
        self._operations: list[Operation] = []
        self._places: dict[str, int] = {}  # By texts: 0 and -0 are equal, not alike.

    def program(self, variables: Sequence[Variable], law: Sequence[Scalar]) -> Program:
        """Returns a law as a program."""
        results = [self.value(x) for x in law]
        needed = {x.place for x in results if isinstance(x, Step)}
        for place in range(len(self._operations) - 1, -1, -1):
            if place in needed:
                operands = self._operations[place].operands
                needed.update(x.place for x in operands if isinstance(x, Step))
        order = sorted(needed)
        places = {place: i for i, place in enumerate(order)}
        inputs = {x.get_id(): i for i, x in enumerate(variables)}

        def moved(x: Operand) -> Operand:
            if isinstance(x, Step):
                return Step(places[x.place])
            if not isinstance(x, Input):
                return x
            if x.place not in inputs:
                raise TypeError("a law uses a variable that it is not given")
            return Input(inputs[x.place])

        return Program(
            len(variables),
            tuple(
                Operation(kind, tuple(map(moved, operands)))
                for kind, operands in map(self._operations.__getitem__, order)
            ),
            tuple(map(moved, results)),
        )

    def value(self, part: Any) -> Operand:
        """Returns the value of an expression, as an operand."""
        if not isinstance(part, Expression):
            return Constant(float(part))
        kind = part.get_kind()
        if kind == ExpressionKind.Var:
            (variable,) = part.GetVariables()
            number = variable.get_id()
            return self.named.get(number, Input(number))
        if kind == ExpressionKind.Constant:
            return Constant(part.Evaluate())
        _, operands = part.Unapply()
        if kind in _FOLDED:
            return self._folded(*_FOLDED[kind], operands)
        return self._of_kind(kind, operands)

    def _of_kind(self, kind: Any, operands: Sequence[Any]) -> Operand:
        if kind == ExpressionKind.IfThenElse:
            condition, *either = operands
            a, b = map(self.value, either)
            return self._operation("select", self._truth(condition), a, b)
        if kind not in _ARITHMETIC:
            raise TypeError(f"{kind.name} is no operation that can be compiled")
        values = [self.value(x) for x in operands]
        if kind in (ExpressionKind.Min, ExpressionKind.Max):
            return self._chosen(kind == ExpressionKind.Min, *values)
        if kind == ExpressionKind.Pow and values[1] == Constant(2.0):
            return self._operation("mul", values[0], values[0])
        return self._operation(FUNCTIONS.get(kind, "div"), *values)

    def _operation(self, kind: str, *operands: Operand) -> Operand:
        operation = Operation(kind, operands)
        text = repr(operation)
        if text not in self._places:
            self._places[text] = len(self._operations)
            self._operations.append(operation)
        return Step(self._places[text])

    def _folded(self, kind: str, neutral: float, operands: Sequence[Any]) -> Operand:
        first, *others = operands
        if float(first) != neutral:
            others.insert(0, first)
        total, *rest = (self.value(x) for x in others)
        for value in rest:
            total = self._operation(kind, total, value)
        return total

    def _chosen(self, smaller: bool, a: Operand, b: Operand) -> Operand:
        """Returns `std::min` or `std::max`, which is `a` where either is NaN."""
        of = (b, a) if smaller else (a, b)
        return self._operation("select", self._operation("lt", *of), b, a)

    def _truth(self, formula: Any) -> Operand:
        """Returns whether a formula holds, as an operand."""
        kind = formula.get_kind()
        if kind in (FormulaKind.True_, FormulaKind.False_):
            return Constant(kind == FormulaKind.True_)
        _, operands = formula.Unapply()
        if kind in _COMPARISONS:
            a, b = map(self.value, operands)
            return self._operation(_COMPARISONS[kind], a, b)
        if kind == FormulaKind.Not:
            return self._operation("not", self._truth(operands[0]))
        if kind not in _CONNECTIVES:
            raise TypeError(f"{kind.name} is no operation that can be compiled")
        total, *rest = map(self._truth, operands)
        for value in rest:
            total = self._operation(_CONNECTIVES[kind], total, value)
        return total
