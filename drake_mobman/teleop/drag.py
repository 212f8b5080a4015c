"""A point of the arm that an operator drags to a target."""

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
    """The signal `drag`, component by component: a point Q of a body B, and its target.

    The target is relative to the base's centre on the floor, in W's axes: on the
    operator's screen, the robot stays in the middle, and the target moves with it.
    """

    body: float = 0.0  # Index of B in the plant; 0 while nothing is dragged.
    q_x: float = 0.0  # p_BQ [m].
    q_y: float = 0.0
    q_z: float = 0.0
    to_x: float = 0.0  # Target of Q [m].
    to_y: float = 0.0
    to_z: float = 0.0

    @property
    def p_BQ(self) -> tuple[float, float, float]:
        """Returns the position of the point in its body [m]."""
        return self.q_x, self.q_y, self.q_z

    @property
    def to(self) -> tuple[float, float, float]:
        """Returns the target of the point, from the base's centre [m]."""
        return self.to_x, self.to_y, self.to_z


NOTHING = Dragged()
"""While no point is dragged."""


@dc.dataclass
class Drag:
    """How a point of the arm is dragged, and which drags are valid."""

    # Softer than a hand at the tool: at the edge of its gripper, the effective mass of
    # the Franka arm is as low as 0.16 kg.
    stiffness: float = 300.0  # Force per distance of the point from the hand [N/m].
    damping: float = 25.0  # Force per velocity of the point from the hand's [N s/m].
    max_force: float = 60.0  # Largest norm of the force [N].
    max_speed: float = 0.4  # Of the hand on its way to the target [m/s].
    max_distance: float = 10.0  # Of a target from the base [m].
    max_offset: float = 1.0  # Of a point from its body's origin [m].

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
    """Which bodies may be dragged, none by default, and how."""

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
