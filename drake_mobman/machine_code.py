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


Function = Callable[[Sequence[float]], Any]
"""Takes numbers for all variables; returns an array of ctypes, which numpy can read."""


class MachineCode:
    """Laws of some variables, as functions of numbers.

    Args:
        variables: of the laws, in the order in which they take numbers.
        trace: what the laws have named.
        laws: for each, its results.

    Raises:
        TypeError: where an expression has an operation that is not known here.
    """

    def __init__(
        self,
        variables: Sequence[Variable],
        trace: Trace,
        laws: Sequence[Sequence[Scalar]],
    ) -> None:
        self._engine = _loaded(_assembly(variables, trace, laws))
        numbers = ctypes.c_double * len(variables)
        self.laws = [
            self._function(f"law{i}", numbers, ctypes.c_double * len(law))
            for i, law in enumerate(laws)
        ]

    def _function(self, name: str, numbers: Any, results: Any) -> Function:
        kind = ctypes.PYFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)
        call = kind(self._engine.get_function_address(name))

        def law(given: Sequence[float]) -> Any:
            found = results()
            call(numbers(*given), found)
            return found

        return law


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
        self._machine_code = MachineCode(every, trace, [results])
        (self._code,) = self._machine_code.laws
        return self._code


def _assembly(
    variables: Sequence[Variable], trace: Trace, laws: Sequence[Sequence[Scalar]]
) -> str:
    """Returns laws as text in LLVM's assembly language, as functions law0, law1 ..."""
    code = _Code(variables)
    every = [result for law in laws for result in law]
    for name, named in trace.needed(every):
        code.value_of_variable[name.get_id()] = code.value(named)
    values = [list(map(code.value, law)) for law in laws]
    functions = [
        _function(f"law{i}", code, results) for i, results in enumerate(values)
    ]
    return "\n".join([*sorted(code.declared), *functions])


def _function(name: str, code: "_Code", results: Sequence[str]) -> str:
    """Returns a function of those lines that some values need, which it stores."""
    needed, lines = set(results), []
    for value, operation in reversed(code.operations.items()):
        if value in needed:
            needed.update(_VALUE.findall(operation))
            lines.append(f"  {value} = {operation}")
    lines.reverse()
    for i, result in enumerate(results):
        lines.append(f"  %o{i} = getelementptr double, ptr %out, i64 {i}")
        lines.append(f"  store double {result}, ptr %o{i}")
    body = "\n".join(lines)
    return f"define void @{name}(ptr %in, ptr %out) {{\n{body}\n  ret void\n}}\n"


_VALUE = re.compile(r"%v\d+")


class _Code:
    """Operations in order, each of which no other is like, by the value it gives."""

    def __init__(self, variables: Sequence[Variable]) -> None:
        self.operations: dict[str, str] = {}
        self.declared: set[str] = set()
        self.value_of_variable: dict[int, str] = {}
        self._values: dict[str, str] = {}
        for i, variable in enumerate(variables):
            place = self._line(f"getelementptr double, ptr %in, i64 {i}")
            self.value_of_variable[variable.get_id()] = self._line(
                f"load double, ptr {place}"
            )

    def value(self, part: Any) -> str:
        """Returns the value of an expression, as an operand."""
        if not isinstance(part, Expression):
            return _constant(float(part))
        kind = part.get_kind()
        if kind == ExpressionKind.Var:
            (variable,) = part.GetVariables()
            return self.value_of_variable[variable.get_id()]
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
