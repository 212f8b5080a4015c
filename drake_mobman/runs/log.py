"""Signals logged: an array over time for each, under its name."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, VectorLogSink

Log = dict[str, np.ndarray]
"""`time` (N,) [s], and an array (N, size) for each signal."""

_PREFIX = "log."


def log_signals(
    builder: DiagramBuilder, ports: Mapping[str, Any], period: float
) -> None:
    """Logs each output port under its name, every `period` [s]."""
    for name, port in ports.items():
        LogVectorOutput(port, builder, period).set_name(f"{_PREFIX}{name}")


def read_log(diagram: Diagram, context: Any) -> Log:
    """Returns what `log_signals` in `diagram` has logged so far.

    A run that dies may have logged only some of its last sample's signals; that sample
    is left out.
    """
    sinks = {
        system.get_name().removeprefix(_PREFIX): system.FindLog(context)
        for system in diagram.GetSystems()
        if isinstance(system, VectorLogSink)
    }
    complete = min(sink.num_samples() for sink in sinks.values())
    log = {name: sink.data()[:, :complete].T for name, sink in sinks.items()}
    time = next(iter(sinks.values())).sample_times()[:complete]
    return {"time": np.array(time)} | {key: np.array(x) for key, x in log.items()}


def until_not_finite(log: Log) -> Log:
    """Returns the log up to its first sample that holds a NaN or an infinity."""
    finite = np.all(
        [np.isfinite(x.T).T.reshape(len(x), -1).all(1) for x in log.values()], 0
    )
    complete = len(finite) if finite.all() else int(np.argmin(finite))
    return {name: x[:complete] for name, x in log.items()}
