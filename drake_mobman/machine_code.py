"""Laws as machine code: traced once on Expressions, then compiled by LLVM.

Drake evaluates an `Expression` as a tree of objects, at about 0.1 us an operation; the
kinematics of an arm with seven joints take 2000. As machine code, they take a few us.
The order of the operations is the Expression's, so results differ from it by nothing.
"""

import ctypes
import struct
from collections.abc import Callable, Sequence
from typing import Any

import llvmlite.binding as llvm
from pydrake.symbolic import Expression, Variable

from drake_mobman.operations import (
    Input,
    Law,
    Operand,
    Operation,
    Program,
    Step,
    programs,
)
from drake_mobman.scalars import Scalar, Vector
from drake_mobman.tracing import Trace, tracing

_OWN = {"sqrt": "sqrt", "abs": "fabs", "floor": "floor", "ceil": "ceil"}
"""Functions that are LLVM's own, by their names there; others are C's library's."""

_INSTRUCTIONS = {
    "add": "fadd double {}, {}",
    "mul": "fmul double {}, {}",
    "div": "fdiv double {}, {}",
    "select": "select i1 {}, double {}, double {}",
    "eq": "fcmp oeq double {}, {}",
    "ne": "fcmp une double {}, {}",
    "gt": "fcmp ogt double {}, {}",
    "ge": "fcmp oge double {}, {}",
    "lt": "fcmp olt double {}, {}",
    "le": "fcmp ole double {}, {}",
    "and": "and i1 {}, {}",
    "or": "or i1 {}, {}",
    "not": "xor i1 {}, true",
}


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
    engine = loaded(assembly(programs(trace, laws)))
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


def assembly(laws: Sequence[Program]) -> str:
    """Returns programs as text in LLVM's assembly language: functions law0, law1 ..."""
    declared = {
        f"declare double @{_function(each.kind)}"
        f"({', '.join(['double'] * len(each.operands))})"
        for law in laws
        for each in law.operations
        if each.kind not in _INSTRUCTIONS
    }
    functions = [_defined(f"law{i}", law) for i, law in enumerate(laws)]
    return "\n".join([*sorted(declared), *functions])


def _defined(name: str, law: Program) -> str:
    """Returns a program as a function that loads its inputs and stores its results."""
    loads = [
        line
        for i in sorted(law.used())
        for line in (
            f"%i{i} = getelementptr double, ptr %in, i64 {i}",
            f"%u{i} = load double, ptr %i{i}",
        )
    ]
    operations = [f"%v{i} = {_line(each)}" for i, each in enumerate(law.operations)]
    stores = [
        line
        for i, result in enumerate(law.results)
        for line in (
            f"%o{i} = getelementptr double, ptr %out, i64 {i}",
            f"store double {_text(result)}, ptr %o{i}",
        )
    ]
    body = "\n  ".join([*loads, *operations, *stores])
    return f"define void @{name}(ptr %in, ptr %out) {{\n  {body}\n  ret void\n}}\n"


def _line(operation: Operation) -> str:
    values = [_text(x) for x in operation.operands]
    if operation.kind in _INSTRUCTIONS:
        return _INSTRUCTIONS[operation.kind].format(*values)
    arguments = ", ".join(f"double {value}" for value in values)
    return f"call double @{_function(operation.kind)}({arguments})"


def _function(kind: str) -> str:
    """Returns the name of a function, in C's library or of LLVM's own."""
    return f"llvm.{_OWN[kind]}.f64" if kind in _OWN else kind


def _text(operand: Operand) -> str:
    """Returns an operand as LLVM writes it; a number to the last bit."""
    if isinstance(operand, Step):
        return f"%v{operand.place}"
    if isinstance(operand, Input):
        return f"%u{operand.place}"
    if isinstance(operand.value, bool):
        return "true" if operand.value else "false"
    return f"0x{struct.pack('>d', operand.value).hex()}"


def loaded(text: str) -> Any:
    """Returns an engine that has the machine code of a module."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine(opt=2)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(text), machine)
    engine.finalize_object()
    return engine
