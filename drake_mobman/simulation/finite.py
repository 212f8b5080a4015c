"""A signal that is not finite ends a run, and the message names it."""

import textwrap
from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram

from drake_mobman.simulation.log import STATE, names_in_order

FAILURES = (Exception, SystemExit)
"""Errors that end a simulation; pydrake turns Drake's assertions into the latter."""


def signal_not_finite(diagram: Diagram, context: Any) -> str:
    """Returns the name of a signal that holds a NaN or an infinity now; "" for none."""
    ports = map(diagram.get_output_port, range(diagram.num_output_ports()))
    by_name = {port.get_name(): port for port in ports}
    for name in names_in_order(by_name):
        try:
            value = by_name[name].Eval(context)
        except FAILURES:
            continue  # It depends on another signal, which is checked too.
        if not np.isfinite(value).all():
            return name
    return ""


def check_state_finite(diagram: Diagram, context: Any) -> None:
    """Raises `ArithmeticError` unless the robot's state is finite.

    Faster than `check_finite`; the log is checked later for all other signals.
    """
    for name in STATE:
        if not np.isfinite(diagram.GetOutputPort(name).Eval(context)).all():
            raise ArithmeticError(not_finite(name))


def check_finite(diagram: Diagram, context: Any) -> None:
    """Raises `ArithmeticError` unless all signals but the operator's are finite."""
    if name := signal_not_finite(diagram, context):
        raise ArithmeticError(not_finite(name))


def death(diagram: Diagram, context: Any, error: BaseException) -> str:
    """Returns when and why an error ended a simulation, in one line."""
    why = reason(error)
    name = signal_not_finite(diagram, context)
    if name and why != not_finite(name):
        why = f"{not_finite(name)}; {why}"
    return died_at(context.get_time(), why)


def died_at(time: float, why: str) -> str:
    """Returns when [s] and why a simulation ended, in one line."""
    return f"died at t = {time:g} s: {why}"


def not_finite(name: str) -> str:
    """Returns the message for a signal that is not finite."""
    return f"{name} is not finite any more"


def reason(error: BaseException) -> str:
    """Returns an error's message, in one line."""
    message = str(error) or type(error).__name__
    return textwrap.shorten(message, 200, placeholder=" ...")
