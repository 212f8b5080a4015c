"""The ranges of an arm's joints, as far as they have ends."""

import math
from typing import Any, NamedTuple

import numpy as np

from drake_mobman.robot_model.model import BASE_JOINTS
from drake_mobman.scalars import Matrix

_TURN = math.pi
"""How far a joint without ends may turn from zero [rad]."""


class Ranges(NamedTuple):
    """The ranges of n joints."""

    low: Matrix  # (n,) [rad], [m].
    high: Matrix  # (n,) [rad], [m].
    ended: Matrix  # (n,): whether the joint has two ends; else it may turn by pi.

    @property
    def middle(self) -> Matrix:
        """Returns the middle of each (n,) [rad], [m]."""
        return (self.low + self.high) / 2

    def margin(self, q: Matrix) -> float:
        """Returns the least distance from an end, as a share of the joint's range."""
        room = np.minimum(q - self.low, self.high - q) / (self.high - self.low)
        return float(np.min(room[self.ended], initial=0.5))


def arm_ranges(plant: Any) -> Ranges:
    """Returns the ranges of the arm's joints of a finalized plant."""
    low = plant.GetPositionLowerLimits()[BASE_JOINTS:]
    high = plant.GetPositionUpperLimits()[BASE_JOINTS:]
    ended = np.isfinite(low) & np.isfinite(high)
    return Ranges(np.where(ended, low, -_TURN), np.where(ended, high, _TURN), ended)
