"""A point of the arm that an operator drags to where he wants it."""

import dataclasses as dc
import math
from typing import NamedTuple

from drake_mobman.parameters import (
    DAMPING,
    FORCE,
    LENGTH,
    SPEED,
    STIFFNESS,
    Range,
    within,
)
from drake_mobman.teleop.guard import GuardStatus


class Dragged(NamedTuple):
    """The signal `drag`, component by component: a point Q of a body B, and whereto.

    Whereto is told from the base's centre on the floor, in W's axes: an operator who
    looks at a robot that stays in the middle of his picture moves along with it.
    """

    body: float = 0.0  # Index of B in the plant; 0, the world, for nothing dragged.
    q_x: float = 0.0  # p_BQ [m].
    q_y: float = 0.0
    q_z: float = 0.0
    to_x: float = 0.0  # Where Q is to be [m].
    to_y: float = 0.0
    to_z: float = 0.0

    @property
    def p_BQ(self) -> tuple[float, float, float]:
        """Returns where the point is in its body [m]."""
        return self.q_x, self.q_y, self.q_z

    @property
    def to(self) -> tuple[float, float, float]:
        """Returns where the point is to be, from the base's centre [m]."""
        return self.to_x, self.to_y, self.to_z


NOTHING = Dragged()
"""While no point is dragged."""


@dc.dataclass
class Drag:
    """How a point of the arm is dragged, and what of a drag is believed."""

    # Softer than a hand at the tool: held by the edge of its hand, the Franka arm
    # gives way to a turn of that as 0.16 kg would.
    stiffness: float = 300.0  # Force per distance from where the point is led [N/m].
    damping: float = 25.0  # Force per velocity from that of the lead [N s/m].
    max_force: float = 60.0  # Largest, in whichever direction [N].
    max_speed: float = 0.4  # Fastest that a point is led to where it is dragged [m/s].
    max_distance: float = 10.0  # Farthest from the base that it may be dragged [m].
    max_offset: float = 1.0  # Farthest that a point may be from its body's origin [m].

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, STIFFNESS, "stiffness")
        within(self, DAMPING, "damping")
        within(self, FORCE, "max_force")
        within(self, SPEED, "max_speed")
        within(self, Range(0.01, 100.0, "m"), "max_distance")
        within(self, LENGTH, "max_offset")


@dc.dataclass(frozen=True)
class Draggable:
    """What may be dragged: nothing, unless bodies are named."""

    bodies: frozenset[int] = frozenset()  # Indices in the plant.
    params: Drag = dc.field(default_factory=Drag)


NO_BODY = Draggable()
"""Nothing may be dragged."""


def drag_status(dragged: Dragged, draggable: Draggable) -> GuardStatus:
    """Returns why a drag may not pass, or OK."""
    if not all(map(math.isfinite, dragged)):
        return GuardStatus.NOT_FINITE
    if dragged == NOTHING:
        return GuardStatus.OK
    params = draggable.params
    in_range = (
        dragged.body in draggable.bodies
        and math.hypot(*dragged.p_BQ) <= params.max_offset
        and math.hypot(*dragged.to) <= params.max_distance
    )
    return GuardStatus.OK if in_range else GuardStatus.OVER_RANGE
