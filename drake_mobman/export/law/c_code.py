"""Programs printed as functions in C99."""

from drake_mobman.operations import Input, Operand, Operation, Program, Step

_OPERATORS = {
    "add": "{} + {}",
    "mul": "{} * {}",
    "div": "{} / {}",
    "select": "{} ? {} : {}",
    "eq": "{} == {}",
    "ne": "{} != {}",
    "gt": "{} > {}",
    "ge": "{} >= {}",
    "lt": "{} < {}",
    "le": "{} <= {}",
    "and": "{} && {}",
    "or": "{} || {}",
    "not": "!{}",
}

_RENAMED = {"abs": "fabs"}
"""Functions that have another name in <math.h>."""

_SPECIAL = {"inf": "INFINITY", "-inf": "-INFINITY", "nan": "NAN"}


def function(name: str, program: Program) -> str:
    """Returns a program as a function in C99, which allocates and keeps nothing.

    Args:
        name: of the function; it takes arrays `in` and `out` of doubles.
        program: to print.
    """
    lines = [
        f"const {'int' if each.is_truth else 'double'} v{i} = {_line(each)};"
        for i, each in enumerate(program.operations)
    ]
    lines += [f"out[{i}] = {_text(x)};" for i, x in enumerate(program.results)]
    if not program.used():
        lines.insert(0, "(void)in;")
    body = "\n  ".join(lines)
    return f"static void {name}(const double *in, double *out)\n{{\n  {body}\n}}\n"


def number(x: float) -> str:
    """Returns a number as C99 writes it, to the last bit."""
    return _SPECIAL.get(repr(x)) or x.hex()


def _line(operation: Operation) -> str:
    values = [_text(x) for x in operation.operands]
    if operation.kind in _OPERATORS:
        return _OPERATORS[operation.kind].format(*values)
    return f"{_RENAMED.get(operation.kind, operation.kind)}({', '.join(values)})"


def _text(operand: Operand) -> str:
    if isinstance(operand, Step):
        return f"v{operand.place}"
    if isinstance(operand, Input):
        return f"in[{operand.place}]"
    x = operand.value
    return str(int(x)) if isinstance(x, bool) else number(x)
