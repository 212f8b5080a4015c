"""Laws traced on Expressions: what they name is worked out once.

Drake's expressions are trees: where a law uses a result twice, and that one another
twice, the tree doubles each time. So a law names its results. While it is traced, a
name is a variable of its own; for floats and AutoDiffXd, it is nothing.
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar

from pydrake.symbolic import Expression, ExpressionKind, Variable

from drake_mobman.scalars import Scalar

_LEAVES = ExpressionKind.Var, ExpressionKind.Constant


class Trace:
    """What laws have named, in order: each in terms of those before it."""

    def __init__(self) -> None:
        self.variables: list[Variable] = []
        self.laws: list[Expression] = []

    def name(self, x: Expression) -> Expression:
        """Returns a variable for an expression; a leaf stays as it is."""
        if x.get_kind() in _LEAVES:
            return x
        variable = Variable(f"n{len(self.laws)}")
        self.variables.append(variable)
        self.laws.append(x)
        return Expression(variable)

    def needed(self, results: Sequence[Scalar]) -> list[tuple[Variable, Expression]]:
        """Returns those named that results depend on, in order."""
        needed = {x.get_id() for result in results for x in variables_of(result)}
        found = []
        pairs = zip(reversed(self.variables), reversed(self.laws), strict=True)
        for name, law in pairs:
            if name.get_id() in needed:
                needed |= {x.get_id() for x in law.GetVariables()}
                found.append((name, law))
        return found[::-1]

    def ids(self, results: Sequence[Scalar]) -> set[int]:
        """Returns the ids of all variables that results depend on, named or not."""
        pairs = [*self.needed(results)]
        laws = [*results, *(law for _, law in pairs)]
        return {x.get_id() for law in laws for x in variables_of(law)}


def variables_of(x: Scalar) -> Iterable[Variable]:
    """Returns the variables of an Expression; none of a number."""
    return x.GetVariables() if type(x) is Expression else ()


_trace: ContextVar[Trace | None] = ContextVar("trace", default=None)


@contextmanager
def tracing() -> Iterator[Trace]:
    """Collects what laws name in this thread, until the end of the `with` block."""
    trace = Trace()
    token = _trace.set(trace)
    try:
        yield trace
    finally:
        _trace.reset(token)


def named(x: Scalar) -> Scalar:
    """Returns `x`, which a law uses several times; while traced, a variable for it."""
    if type(x) is not Expression:
        return x
    trace = _trace.get()
    return trace.name(x) if trace else x


def also_named(x: Scalar) -> Scalar:
    """Returns `x`, `named` in a law that has named something before.

    A law that is short else stays whole, for Drake to evaluate without Python.
    """
    trace = _trace.get()
    return trace.name(x) if trace and trace.laws and type(x) is Expression else x


def all_named(xs: Sequence[Scalar]) -> list[Scalar]:
    """Returns several scalars, each `named`."""
    trace = _trace.get()
    if trace is None:
        return list(xs)
    return [trace.name(x) if type(x) is Expression else x for x in xs]
