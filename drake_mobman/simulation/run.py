"""The result of a simulation: signals over time, and how it ended."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

from drake_mobman.robot_model import RobotModel, RobotSetup
from drake_mobman.scenario import AnyScenario
from drake_mobman.simulation.log import Log, head


def _not_timed() -> np.ndarray:
    return np.zeros(0)


@dc.dataclass
class Run:
    """A simulated scenario.

    `run["ee_command"]` is a signal at N samples (N, size), `run.time` their times (N,).
    """

    scenario: AnyScenario
    log: Log  # Of the whole run, or up to where it died.
    wall_time: float  # Of the simulation, logging included [s].
    tick_times: np.ndarray = dc.field(default_factory=_not_timed)  # (K,) [s].
    died: str = ""  # When and why, in one line; empty if it did not.
    interrupted: bool = False  # Whether the user ended it.
    built_with: RobotSetup | None = dc.field(default=None, repr=False)  # See `setup`.

    def __getitem__(self, signal: str) -> np.ndarray:
        """Returns a signal over time (N, size); see `drake_mobman.signals` for units.

        Raises:
            KeyError: if it was not logged; the message lists the valid names.
        """
        if signal not in self.signals:
            valid = ", ".join(self.signals)
            raise KeyError(f"no signal {signal!r}; valid names are {valid}")
        return self.log[signal]

    @property
    def time(self) -> np.ndarray:
        """Returns the times of the samples (N,) [s]."""
        return self.log["time"]

    @property
    def signals(self) -> Sequence[str]:
        """Returns the names of the signals that were logged."""
        return [name for name in self.log if name != "time"]

    @property
    def setup(self) -> RobotSetup:
        """Returns the robot's setup, made once for the run and its parts."""
        if self.built_with is None:
            self.built_with = self.scenario.setup()
        return self.built_with

    @property
    def model(self) -> RobotModel:
        """Returns the robot's model."""
        return self.setup.model

    def with_log(self, log: Log) -> "Run":
        """Returns the run with another log, such as a part of its own."""
        return dc.replace(self, log=log, built_with=self.setup)

    def first(self, samples: int) -> "Run":
        """Returns the run with only its first samples, in memory."""
        return self.with_log(head(self.log, samples))
