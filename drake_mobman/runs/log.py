"""Signals logged: an array over time for each, under its name."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, Multiplexer

from drake_mobman import signals

Log = dict[str, np.ndarray]
"""`time` (N,) [s], and an array (N, size) for each signal."""

_STATE = (signals.BASE_POSE, signals.ARM_POSITION)
"""What all other signals follow from."""

_NAME = "log"


class _Signals(Multiplexer):
    """All signals in one vector: one logger costs less than one for each."""

    def __init__(self, ports: Mapping[str, Any]) -> None:
        self.sizes = {name: port.size() for name, port in ports.items()}
        super().__init__(list(self.sizes.values()))


def log_signals(
    builder: DiagramBuilder, ports: Mapping[str, Any], period: float
) -> None:
    """Logs each output port under its name, every `period` [s]."""
    mux = builder.AddNamedSystem(f"{_NAME}.signals", _Signals(ports))
    for i, port in enumerate(ports.values()):
        builder.Connect(port, mux.get_input_port(i))
    LogVectorOutput(mux.get_output_port(), builder, period).set_name(_NAME)


def read_log(diagram: Diagram, context: Any) -> Log:
    """Returns what `log_signals` in `diagram` has logged so far."""
    sizes = diagram.GetSubsystemByName(f"{_NAME}.signals").sizes
    log = diagram.GetSubsystemByName(_NAME).FindLog(context)
    borders = np.cumsum(list(sizes.values()))[:-1]
    columns = np.split(log.data().T, borders, axis=1)
    values = map(np.ascontiguousarray, columns)
    return {"time": np.array(log.sample_times())} | dict(
        zip(sizes, values, strict=True)
    )


def drained_log(diagram: Diagram, context: Any) -> Log:
    """Returns what has been logged since the last call, and forgets it."""
    log = {name: x.copy() for name, x in read_log(diagram, context).items()}
    diagram.GetSubsystemByName(_NAME).FindMutableLog(context).Clear()
    return log


def until_not_finite(log: Log) -> Log:
    """Returns the log up to its first sample that holds a NaN or an infinity."""
    found = first_not_finite(log)
    return {name: x[: found[0]] for name, x in log.items()} if found else log


def first_not_finite(log: Log) -> tuple[int, str] | None:
    """Returns the first sample that holds a NaN or an infinity, and which signal does.

    Of several signals, one that others follow from. None where all are finite, but for
    `operator_input`, which holds whatever the operator's device says.
    """
    firsts = {}
    for name in names_in_order(log):
        finite = np.isfinite(log[name]).reshape(len(log[name]), -1).all(1)
        if not finite.all():
            firsts[name] = int(np.argmin(finite))
    name = min(firsts, key=firsts.__getitem__, default="")
    return (firsts[name], name) if firsts else None


def names_in_order(named: Mapping[str, Any]) -> list[str]:
    """Returns the names of signals to be finite, the robot's state before the rest."""
    names = [name for name in named if name != signals.OPERATOR_INPUT]
    return sorted(names, key=lambda name: name not in _STATE)
