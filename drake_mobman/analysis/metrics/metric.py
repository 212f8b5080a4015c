"""The interface of a metric."""

import abc
from collections.abc import Mapping
from typing import Any, ClassVar

from drake_mobman import signals
from drake_mobman.analysis.metrics.window import Window
from drake_mobman.simulation.log import Log

COMMANDED = (signals.EE_COMMAND, signals.ARM_COMMAND)
"""Signals of a run whose end effector is commanded, and not guided by a hand."""


class Metric(abc.ABC):
    """One or more numbers of a run, computed from its log window by window."""

    group: ClassVar[str]  # Heading in a table: "end effector", "base", "arm", ...
    units: ClassVar[Mapping[str, str]]  # Of each number, "" without one, by flat name.
    needs: ClassVar[tuple[str, ...]] = ()  # Signals that the metric needs.

    @classmethod
    def applies(cls, log: Log) -> bool:
        """Returns whether the log holds the signals that the metric needs."""
        return all(name in log for name in cls.needs)

    @abc.abstractmethod
    def take(self, window: Window) -> None:
        """Takes the next window of the log into account."""

    @abc.abstractmethod
    def numbers(self) -> dict[str, Any]:
        """Returns the numbers by name; several of one name are in a dict.

        Their flat names, `name.part`, are the keys of `units`.
        """
