"""Common-subexpression elimination: what expressions share is evaluated once.

Drake evaluates an `Expression` as a tree: a part that occurs twice is evaluated twice.
Here, the parts that save the most get variables of their own.
"""

import dataclasses as dc
from collections.abc import Sequence
from typing import Any

from pydrake.symbolic import Expression, ExpressionKind, Formula, Variable

_WORTH = 150
"""Least operations that a variable must save. It may need a system of its own, and that
costs about as much at every step of a diagram, evaluated or not."""


@dc.dataclass(frozen=True)
class Named:
    """A subexpression with a variable of its own."""

    variable: Variable
    law: Expression  # In terms of other variables, and of named ones of lower levels.
    level: int


def eliminate_common_subexpressions(
    laws: Sequence[Expression], worth: int = _WORTH
) -> tuple[list[Named], list[Expression]]:
    """Returns named subexpressions, and the laws in terms of their variables.

    Names the subexpression that saves most operations, again and again, while it saves
    at least `worth`. The values of the laws stay the same to the last bit.

    Args:
        laws: the expressions.
        worth: least operations that a name must save.
    """
    graph = _Graph()
    roots = [graph.number(law) for law in laws]
    named: set[int] = set()
    while (best := graph.most_saving(roots, named, worth)) is not None:
        named.add(best)
    rewritten: dict[int, tuple[Any, int]] = {}
    names: list[Named] = []
    for number in graph.all_parts():
        part, level = graph.rebuilt(number, rewritten)
        if number in named:
            variable = Variable(f"t{len(names)}")
            names.append(Named(variable, part, level))
            part, level = 1 * variable, level + 1
        rewritten[number] = part, level
    return names, [rewritten[root][0] for root in roots]


class _Graph:
    """Expressions as a graph: each distinct part once, after its operands."""

    def __init__(self) -> None:
        self._numbers: dict[Any, int] = {}
        self._seen: dict[str, list[tuple[Any, int]]] = {}
        self._parts: list[Any] = []
        self._operands: list[tuple[int, ...]] = []

    def number(self, part: Any) -> int:
        """Returns the number of an expression, a formula or a constant."""
        if not isinstance(part, Expression | Formula):
            return self._numbered(part)
        # Looked up first: taking a known part apart again costs as much as its tree.
        alike = self._seen.setdefault(str(part), [])
        for other, number in alike:
            if other.EqualTo(part):
                return number
        number = self._numbered(part)
        alike.append((part, number))
        return number

    def _numbered(self, part: Any) -> int:
        call, arguments = _unapplied(part)
        operands = tuple(map(self.number, arguments))
        key = call, operands
        if key not in self._numbers:
            self._numbers[key] = len(self._parts)
            self._parts.append((call, part))
            self._operands.append(operands)
        return self._numbers[key]

    def all_parts(self) -> range:
        """Returns all numbers."""
        return range(len(self._parts))

    def most_saving(
        self, roots: Sequence[int], named: set[int], worth: int
    ) -> int | None:
        """Returns the expression that saves most operations if named, or None.

        Args:
            roots: the laws.
            named: numbers of those that are named already.
            worth: least operations to be saved.
        """
        count = len(self._parts)
        size, times = [0] * count, [0] * count
        for n in range(count):
            size[n] = 1 + sum(1 if m in named else size[m] for m in self._operands[n])
        for root in roots:
            times[root] += 1
        for n in reversed(range(count)):
            for m in self._operands[n]:
                times[m] += 1 if n in named else times[n]
        best, saved = None, worth
        for n in range(count):
            saves = (times[n] - 1) * (size[n] - 1)
            if n not in named and saves >= saved and self._is_expression(n):
                best, saved = n, saves
        return best

    def _is_expression(self, number: int) -> bool:
        return isinstance(self._parts[number][1], Expression)

    def rebuilt(
        self, number: int, rewritten: dict[int, tuple[Any, int]]
    ) -> tuple[Any, int]:
        """Returns a part rebuilt from rewritten operands, and its level."""
        call, part = self._parts[number]
        if not self._operands[number]:
            return part, 0
        arguments, levels = zip(
            *(rewritten[m] for m in self._operands[number]), strict=True
        )
        return call(*arguments), max(levels)


def _unapplied(part: Any) -> tuple[Any, Sequence[Any]]:
    """Returns a part's function and operands; a leaf has a key for a function."""
    if isinstance(part, Formula):
        return part.Unapply()
    if not isinstance(part, Expression):
        return ("number", part), ()
    kind = part.get_kind()
    if kind == ExpressionKind.Var:
        (variable,) = part.GetVariables()
        return ("variable", variable.get_id()), ()
    if kind == ExpressionKind.Constant:
        return ("constant", part.Evaluate()), ()
    return part.Unapply()
