"""Recorded inputs of a decomposer, the same for all that are timed."""

from typing import NamedTuple

import numpy as np

from drake_mobman.simulation.run import Run


class Tick(NamedTuple):
    """The inputs of a decomposer in a control period, by the names of its ports."""

    ee_command: np.ndarray  # (3,)
    ee_cylindrical: np.ndarray  # (3,)
    arm_position: np.ndarray  # (n,)
    base_command_smoothed: np.ndarray  # (2,)
    base_estimate: np.ndarray  # (3,)


def recorded_ticks(run: Run) -> list[Tick]:
    """Returns the inputs of the decomposer in each control period of a run."""
    return list(map(Tick, *(run[name] for name in Tick._fields)))
