"""What several expressions have in common, worked out once.

An `Expression` is evaluated as a tree: what it uses twice, it works out twice. Here the
largest of that get names of their own.
"""

import dataclasses as dc
from collections.abc import Sequence
from typing import Any

from pydrake.symbolic import Expression, ExpressionKind, Formula, Variable

_WORTH = 150
"""Operations that a name must save: a name may take a system of its own, and that costs
at every step of a diagram as much as so many, asked or not."""


@dc.dataclass(frozen=True)
class Named:
    """A subexpression with a name, made of variables and of names of lower levels."""

    variable: Variable
    law: Expression
    level: int


def eliminate_common_subexpressions(
    laws: Sequence[Expression], worth: int = _WORTH
) -> tuple[list[Named], list[Expression]]:
    """Returns named subexpressions, and the laws in terms of them.

    Each time that one is named which saves most, while that is `worth` operations.

    Args:
        laws: the expressions; their values stay the same to the last bit.
        worth: operations that a name must save.
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
    """Expressions taken apart: each distinct part once, after those it is made of."""

    def __init__(self) -> None:
        self._numbers: dict[Any, int] = {}
        self._seen: dict[str, list[tuple[Any, int]]] = {}
        self._parts: list[Any] = []
        self._made_of: list[tuple[int, ...]] = []

    def number(self, part: Any) -> int:
        """Returns the number of an expression, a formula or a constant."""
        if not isinstance(part, Expression | Formula):
            return self._numbered(part)
        # To take apart again what has been costs as much as the whole tree of it.
        alike = self._seen.setdefault(str(part), [])
        for other, number in alike:
            if other.EqualTo(part):
                return number
        number = self._numbered(part)
        alike.append((part, number))
        return number

    def _numbered(self, part: Any) -> int:
        call, arguments = _taken_apart(part)
        made_of = tuple(map(self.number, arguments))
        key = call, made_of
        if key not in self._numbers:
            self._numbers[key] = len(self._parts)
            self._parts.append((call, part))
            self._made_of.append(made_of)
        return self._numbers[key]

    def all_parts(self) -> range:
        """Returns all numbers."""
        return range(len(self._parts))

    def most_saving(
        self, roots: Sequence[int], named: set[int], worth: int
    ) -> int | None:
        """Returns which expression saves most operations if named, if any is worth it.

        Args:
            roots: the laws.
            named: what has a name already.
            worth: the least to be saved.
        """
        count = len(self._parts)
        size, times = [0] * count, [0] * count
        for n in range(count):
            size[n] = 1 + sum(1 if m in named else size[m] for m in self._made_of[n])
        for root in roots:
            times[root] += 1
        for n in reversed(range(count)):
            for m in self._made_of[n]:
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
        """Returns a part made anew of rewritten ones, and the level that it needs."""
        call, part = self._parts[number]
        if not self._made_of[number]:
            return part, 0
        arguments, levels = zip(
            *(rewritten[m] for m in self._made_of[number]), strict=True
        )
        return call(*arguments), max(levels)


def _taken_apart(part: Any) -> tuple[Any, Sequence[Any]]:
    """Returns what makes a part of its arguments, or what tells a leaf from others."""
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
