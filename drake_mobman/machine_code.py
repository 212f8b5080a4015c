"""Laws as machine code: traced once on Expressions, then compiled by LLVM.

Drake evaluates an `Expression` as a tree of objects, at about 0.1 us an operation; the
kinematics of an arm with seven joints take 2000. As machine code, they take a few us.
The order of the operations is the Expression's, so results differ from it by nothing.
"""

import ctypes
import re
import struct
from collections.abc import Callable, Sequence
from typing import Any

import llvmlite.binding as llvm
from pydrake.symbolic import Expression, ExpressionKind, FormulaKind, Variable

from drake_mobman.scalars import Scalar, Vector
from drake_mobman.tracing import Trace, tracing

_FUNCTIONS = {
    ExpressionKind.Sqrt: "llvm.sqrt.f64",
    ExpressionKind.Abs: "llvm.fabs.f64",
    ExpressionKind.Floor: "llvm.floor.f64",
    ExpressionKind.Ceil: "llvm.ceil.f64",
    ExpressionKind.Pow: "pow",
    **{
        getattr(ExpressionKind, name): name.lower()
        for name in (
            *("Sin", "Cos", "Tan", "Asin", "Acos", "Atan", "Atan2"),
            *("Sinh", "Cosh", "Tanh", "Exp", "Log"),
        )
    },
}
"""Names in C's library, or of LLVM's own."""

_COMPARISONS = {
    FormulaKind.Eq: "oeq",
    FormulaKind.Neq: "une",
    FormulaKind.Gt: "ogt",
    FormulaKind.Geq: "oge",
    FormulaKind.Lt: "olt",
    FormulaKind.Leq: "ole",
}
"""As in C: with NaN, all are false but `!=`."""

_CONNECTIVES = {FormulaKind.And: "and", FormulaKind.Or: "or"}

_FOLDED = {
    ExpressionKind.Add: ("fadd", 0.0),
    ExpressionKind.Mul: ("fmul", 1.0),
}
"""Operations on several operands, and the constant that changes nothing."""


Law = tuple[Sequence[Variable], Sequence[Scalar]]
"""Variables, and results that depend on them."""


class Function:
    """A law as machine code.

    Args:
        engine: has the machine code.
        name: of the function in it.
        num_inputs: numbers that it takes.
        num_outputs: numbers that it returns.
    """

    def __init__(
        self, engine: Any, name: str, num_inputs: int, num_outputs: int
    ) -> None:
        self._engine = engine  # Else the code would be freed.
        kind = ctypes.PYFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)
        self._call = kind(engine.get_function_address(name))
        self._numbers = ctypes.c_double * num_inputs
        self._results = ctypes.c_double * num_outputs

    def __call__(self, numbers: Sequence[float]) -> Any:
        """Returns an array of ctypes, which numpy can read."""
        results = self._results()
        self._call(self._numbers(*numbers), results)
        return results


def machine_code(trace: Trace, laws: Sequence[Law]) -> list[Function]:
    """Returns laws as functions of numbers.

    Args:
        trace: what the laws have named.
        laws: for each its variables, in the order in which it takes numbers, and its
            results.

    Raises:
        TypeError: where an expression has an operation that is not known here.
    """
    engine = _loaded(_assembly(trace, laws))
    return [
        Function(engine, f"law{i}", len(variables), len(results))
        for i, (variables, results) in enumerate(laws)
    ]


class FastLaw:
    """A law that floats pass through as machine code, and other scalars as it is.

    ::

        squared = FastLaw(lambda v: [v[0] * v[0] + v[1] * v[1]], 2)
        squared([3.0, 4.0])  # [25.0]

    It is compiled when the first floats come.

    Args:
        law: takes vectors of scalars; returns a list of them.
        sizes: of the vectors.
    """

    def __init__(self, law: Callable[..., list[Scalar]], *sizes: int) -> None:
        self._law, self._sizes = law, sizes
        self._code: Function | None = None

    def __call__(self, *vectors: Vector) -> list[Scalar]:
        """Returns the results of the law."""
        numbers = [x for vector in vectors for x in vector]
        try:
            return (self._code or self._compiled())(numbers)[:]
        except TypeError:  # Not floats.
            return self._law(*vectors)

    def _compiled(self) -> Function:
        variables = [
            [Variable(f"u{i}_{j}") for j in range(size)]
            for i, size in enumerate(self._sizes)
        ]
        with tracing() as trace:
            results = self._law(*([Expression(x) for x in v] for v in variables))
        every = [x for vector in variables for x in vector]
        (self._code,) = machine_code(trace, [(every, results)])
        return self._code


def _assembly(trace: Trace, laws: Sequence[Law]) -> str:
    """Returns laws as text in LLVM's assembly language, as functions law0, law1 ..."""
    code = _Code()
    for name, named in trace.needed([result for _, law in laws for result in law]):
        code.named[name.get_id()] = code.value(named)
    functions = [
        _function(f"law{i}", code, [x.get_id() for x in variables], law)
        for i, (variables, law) in enumerate(laws)
    ]
    return "\n".join([*sorted(code.declared), *functions])


def _function(
    name: str, code: "_Code", variables: Sequence[int], law: Sequence[Scalar]
) -> str:
    """Returns a function of those operations that a law needs.

    Args:
        name: of the function.
        code: has the operations.
        variables: their ids, in the order in which the law takes numbers.
        law: results, which it stores.
    """
    results = list(map(code.value, law))
    needed, operations = set(results), []
    for value, operation in reversed(code.operations.items()):
        if value in needed:
            needed.update(_VALUE.findall(operation))
            operations.append(f"{value} = {operation}")
    loads = [
        line
        for i, variable in enumerate(variables)
        if f"%u{variable}" in needed
        for line in (
            f"%i{i} = getelementptr double, ptr %in, i64 {i}",
            f"%u{variable} = load double, ptr %i{i}",
        )
    ]
    stores = [
        line
        for i, result in enumerate(results)
        for line in (
            f"%o{i} = getelementptr double, ptr %out, i64 {i}",
            f"store double {result}, ptr %o{i}",
        )
    ]
    body = "\n  ".join([*loads, *reversed(operations), *stores])
    return f"define void @{name}(ptr %in, ptr %out) {{\n  {body}\n  ret void\n}}\n"


_VALUE = re.compile(r"%[uv]\d+")


class _Code:
    """Operations in order, each of which no other is like, by the value it gives."""

    def __init__(self) -> None:
        self.operations: dict[str, str] = {}
        self.declared: set[str] = set()
        self.named: dict[int, str] = {}  # Values of variables, by their ids.
        self._values: dict[str, str] = {}

    def value(self, part: Any) -> str:
        """Returns the value of an expression, as an operand."""
        if not isinstance(part, Expression):
            return _constant(float(part))
        kind = part.get_kind()
        if kind == ExpressionKind.Var:
            (variable,) = part.GetVariables()
            number = variable.get_id()
            return self.named.get(number, f"%u{number}")
        if kind == ExpressionKind.Constant:
            return _constant(part.Evaluate())
        _, operands = part.Unapply()
        if kind in _FOLDED:
            return self._folded(*_FOLDED[kind], operands)
        return self._operation(kind, operands)

    def _operation(self, kind: Any, operands: Sequence[Any]) -> str:
        if kind == ExpressionKind.IfThenElse:
            condition, *either = operands
            a, b = map(self.value, either)
            return self._select(self._truth(condition), a, b)
        values = [self.value(x) for x in operands]
        if kind == ExpressionKind.Div:
            return self._line(f"fdiv double {', '.join(values)}")
        if kind in (ExpressionKind.Min, ExpressionKind.Max):
            return self._chosen(kind == ExpressionKind.Min, *values)
        if kind == ExpressionKind.Pow and values[1] == _constant(2.0):
            return self._line(f"fmul double {values[0]}, {values[0]}")
        return self._called(kind, values)

    def _line(self, operation: str) -> str:
        if operation not in self._values:
            value = self._values[operation] = f"%v{len(self._values)}"
            self.operations[value] = operation
        return self._values[operation]

    def _folded(self, operation: str, neutral: float, operands: Sequence[Any]) -> str:
        first, *others = operands
        if float(first) != neutral:
            others.insert(0, first)
        total, *rest = (self.value(x) for x in others)
        for value in rest:
            total = self._line(f"{operation} double {total}, {value}")
        return total

    def _select(self, condition: str, a: str, b: str) -> str:
        return self._line(f"select i1 {condition}, double {a}, double {b}")

    def _chosen(self, smaller: bool, a: str, b: str) -> str:
        """Returns `std::min` or `std::max`, which is `a` where either is NaN."""
        of = (b, a) if smaller else (a, b)
        return self._select(self._line(f"fcmp olt double {of[0]}, {of[1]}"), b, a)

    def _called(self, kind: Any, values: Sequence[str]) -> str:
        if kind not in _FUNCTIONS:
            raise TypeError(f"{kind.name} has no machine code")
        function = f"double @{_FUNCTIONS[kind]}"
        self.declared.add(f"declare {function}({', '.join(['double'] * len(values))})")
        arguments = ", ".join(f"double {value}" for value in values)
        return self._line(f"call {function}({arguments})")

    def _truth(self, formula: Any) -> str:
        """Returns whether a formula holds, as an operand."""
        kind = formula.get_kind()
        if kind in (FormulaKind.True_, FormulaKind.False_):
            return "true" if kind == FormulaKind.True_ else "false"
        _, operands = formula.Unapply()
        if kind in _COMPARISONS:
            a, b = map(self.value, operands)
            return self._line(f"fcmp {_COMPARISONS[kind]} double {a}, {b}")
        if kind == FormulaKind.Not:
            return self._line(f"xor i1 {self._truth(operands[0])}, true")
        if kind not in _CONNECTIVES:
            raise TypeError(f"{kind.name} has no machine code")
        total, *rest = map(self._truth, operands)
        for value in rest:
            total = self._line(f"{_CONNECTIVES[kind]} i1 {total}, {value}")
        return total


def _constant(x: float) -> str:
    """Returns a number as LLVM writes it, to the last bit."""
    return f"0x{struct.pack('>d', x).hex()}"


def _loaded(text: str) -> Any:
    """Returns an engine that has the machine code of a module."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine(opt=2)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(text), machine)
    engine.finalize_object()
    return engine
