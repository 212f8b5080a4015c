"""Limits of a mobile base."""

import dataclasses as dc
import math
from typing import Any

from drake_mobman.parameters import ParameterError


@dc.dataclass(frozen=True)
class BaseLimits:
    """Limits of the base; infinite where there is none. `JointLimits` are the arm's."""

    max_speed: float = math.inf  # Forward and back [m/s].
    max_acceleration: float = math.inf  # [m/s^2].
    max_yaw_rate: float = math.inf  # [rad/s].
    max_yaw_acceleration: float = math.inf  # [rad/s^2].
    max_jerk: float = math.inf  # [m/s^3].
    max_yaw_jerk: float = math.inf  # [rad/s^3].

    @property
    def follows_at_once(self) -> bool:
        """Returns whether the base reaches any velocity within its limits at once."""
        return math.isinf(self.max_acceleration) and math.isinf(
            self.max_yaw_acceleration
        )

    def narrowed(self, *narrower: "BaseLimits") -> "BaseLimits":
        """Returns the smallest of several limits, each."""
        return BaseLimits(
            *(
                min(getattr(each, field.name) for each in (self, *narrower))
                for field in dc.fields(self)
            )
        )


def check_base(params: Any, limits: BaseLimits) -> None:
    """Raises `ParameterError` where a parameter is above the base's limit.

    Args:
        params: with some of the fields of `BaseLimits`.
        limits: of the platform.
    """
    for field in dc.fields(limits):
        given, limit = getattr(params, field.name, 0.0), getattr(limits, field.name)
        if not given <= limit:
            valid = f"must be at most {limit:g}, which is what the base can do"
            raise ParameterError(field.name, given, valid)
