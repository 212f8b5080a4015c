"""What is not finite in a run ends it, and is named."""

import textwrap
from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram

from drake_mobman.runs.log import Log, first_not_finite, names_in_order

FAILURES = (RuntimeError, ArithmeticError, ValueError)
"""What blocks raise of numbers that they cannot work with."""


def signal_not_finite(diagram: Diagram, context: Any) -> str:
    """Returns the name of a signal that holds a NaN or an infinity now; "" for none."""
    ports = map(diagram.get_output_port, range(diagram.num_output_ports()))
    by_name = {port.get_name(): port for port in ports}
    for name in names_in_order(by_name):
        try:
            value = by_name[name].Eval(context)
        except (*FAILURES, SystemExit):  # Drake's assertions are the latter.
            continue  # It follows from another.
        if not np.isfinite(value).all():
            return name
    return ""


def check_finite(diagram: Diagram, context: Any) -> None:
    """Raises `ArithmeticError` unless all signals but the operator's are finite."""
    if name := signal_not_finite(diagram, context):
        raise ArithmeticError(_why(name))


def death(diagram: Diagram, context: Any, error: BaseException) -> str:
    """Returns when and why a simulation ended by an error, in one line."""
    reason = textwrap.shorten(str(error), 200, placeholder=" ...")
    name = signal_not_finite(diagram, context)
    if name and reason != _why(name):
        reason = f"{_why(name)}; {reason}"
    return f"died at t = {context.get_time():g} s: {reason}"


def death_by_log(log: Log, died: str) -> str:
    """Returns why a run ended: `died`, unless the log knows of a signal before that.

    A signal may not have been finite for a tick at which nobody looked.
    """
    found = first_not_finite(log)
    if found is None:
        return died
    tick, name = found
    at = f"died at t = {log['time'][tick]:g} s: {_why(name)}"
    return died if died.startswith(at) else at


def _why(name: str) -> str:
    return f"{name} is not finite any more"
