"""All signals of a diagram in one logger, which costs less than one for each."""

from collections.abc import Mapping
from typing import Any

from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, Multiplexer

LOGGER = "log"
"""The logger's name in the diagram."""

LOGGED = f"{LOGGER}.signals"
"""The name of the block before it, whose `sizes` are those of the signals, by name."""


class LoggedSignals(Multiplexer):
    """All signals in one vector."""

    def __init__(self, ports: Mapping[str, Any]) -> None:
        self.sizes = {name: port.size() for name, port in ports.items()}
        super().__init__(list(self.sizes.values()))


def log_signals(
    builder: DiagramBuilder, ports: Mapping[str, Any], period: float
) -> None:
    """Logs each output port under its name, every `period` [s]."""
    signals = builder.AddNamedSystem(LOGGED, LoggedSignals(ports))
    for i, port in enumerate(ports.values()):
        builder.Connect(port, signals.get_input_port(i))
    LogVectorOutput(signals.get_output_port(), builder, period).set_name(LOGGER)
