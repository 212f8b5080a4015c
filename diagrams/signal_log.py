"""Logging of all signals of a diagram, each under its name."""

from collections.abc import Mapping
from typing import Any

from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, Selector

from drake_mobman.parts import selection

LOG = "log"
"""Name of the logger in a diagram; its input is `log.signals`."""


class _Signals(Selector):
    """All signals in one vector: one logger is faster than one for each signal.

    Faster than a `Multiplexer`, whose output is taken to depend on time.
    """

    def __init__(self, ports: Mapping[str, Any]) -> None:
        self.sizes = {name: port.size() for name, port in ports.items()}
        sizes = [*self.sizes.values()]
        every = [(i, place) for i, size in enumerate(sizes) for place in range(size)]
        super().__init__(selection(sizes, {"signals": every}))


def log_signals(
    builder: DiagramBuilder, ports: Mapping[str, Any], period: float
) -> None:
    """Logs each output port under its name, every `period` [s]."""
    mux = builder.AddNamedSystem(f"{LOG}.signals", _Signals(ports))
    for i, port in enumerate(ports.values()):
        builder.Connect(port, mux.get_input_port(i))
    LogVectorOutput(mux.get_output_port(), builder, period).set_name(LOG)


def signal_sizes(diagram: Any) -> dict[str, int]:
    """Returns the sizes of the signals that a diagram logs, in their order."""
    sizes: dict[str, int] = diagram.GetSubsystemByName(f"{LOG}.signals").sizes
    return sizes
