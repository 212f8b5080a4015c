"""A hand holds the tool and leads it along a path (Petric & Zlajpah, fig. 4).

The paper's operator, as a spring and a damper of bounded force.
"""

import dataclasses as dc
import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.systems.framework import LeafSystem
from pydrake.trajectories import PiecewisePolynomial

from drake_mobman import signals
from drake_mobman.parameters import ParameterError, checked, positive


@dc.dataclass
class Waypoint:
    """Where the hand is to be when, in W."""

    time: float = 0.0  # [s].
    x: float = 0.58  # [m].
    y: float = 0.0  # [m].
    z: float = 0.52  # Above the floor [m].


@dc.dataclass
class Release:
    """The hand lets go, and takes hold again."""

    start: float = 0.0  # [s].
    end: float = 1.0  # [s].

    def check(self) -> None:
        """Raises `ParameterError` unless it ends after it starts."""
        if not self.end > self.start:
            valid = f"must be above start = {self.start!r}"
            raise ParameterError("end", self.end, valid)


@dc.dataclass
class Hand:
    """How the hand holds the tool, and where it leads it.

    Through its waypoints, at rest at the first and the last one and before and after.
    Each coordinate goes from point to point by a cubic that does not overshoot. Between
    rest and rest the largest speed is 1.5 times the distance over the time.
    """

    stiffness: float = 600.0  # Force per distance of the tool from the hand [N/m].
    # Renewed every 10 ms, it does not shake a tool that weighs 0.24 kg or more; that of
    # the Franka arm weighs 0.43 kg at least, in any posture and direction.
    damping: float = 80.0  # Force per velocity of the tool from the hand's [Ns/m].
    max_force: float = 60.0  # Largest, in whichever direction [N].
    path: list[Waypoint] = dc.field(default_factory=lambda: [Waypoint()])
    releases: list[Release] = dc.field(default_factory=list)

    def check(self) -> None:
        """Raises `ParameterError` unless it can pull, and times are in order."""
        positive(self, "stiffness", "damping", "max_force")
        if not self.path:
            raise ParameterError("path", self.path, "must hold one waypoint or more")
        for i, (a, b) in enumerate(itertools.pairwise(self.path)):
            if not b.time > a.time:
                valid = f"must be above path[{i}].time = {a.time!r}"
                raise ParameterError(f"path[{i + 1}].time", b.time, valid)
        for i, (c, d) in enumerate(itertools.pairwise(self.releases)):
            if not d.start >= c.end:
                valid = f"must be releases[{i}].end = {c.end!r} or above"
                raise ParameterError(f"releases[{i + 1}].start", d.start, valid)


def hand_force(p_WE: Any, v_WE: Any, p_WH: Any, v_WH: Any, params: Hand) -> list[float]:
    """Returns the force (3,) in W [N] on a tool E that a hand H holds.

    f = stiffness (p_WH - p_WE) + damping (v_WH - v_WE); where that is more than
    `max_force`, its direction stays.

    Args:
        p_WE: position (3,) of the tool [m].
        v_WE: its velocity (3,) [m/s].
        p_WH: position (3,) of the hand [m].
        v_WH: its velocity (3,) [m/s].
        params: of the hand.

    Raises:
        RuntimeError: the force is not finite, as any of these is not or is absurd.
    """
    # Python's own floats, which take half the time of numpy's and overflow silently.
    state = {"p_WE": p_WE, "v_WE": v_WE, "p_WH": p_WH, "v_WH": v_WH}
    state = {key: np.asarray(x, dtype=float).tolist() for key, x in state.items()}
    force = [
        params.stiffness * (H - E) + params.damping * (H_dot - E_dot)
        for E, E_dot, H, H_dot in zip(*state.values(), strict=True)
    ]
    norm = math.hypot(*force)
    if not math.isfinite(norm):
        given = ", ".join(f"{key} = {x}" for key, x in state.items())
        raise RuntimeError(f"the hand's force is not finite: {given}")
    if norm <= params.max_force:
        return force
    return [f / norm * params.max_force for f in force]


def path_trajectory(params: Hand) -> PiecewisePolynomial:
    """Returns p_WH (3,) [m] over time [s]; before and after its points it rests."""
    times = [point.time for point in params.path]
    points = np.array([(point.x, point.y, point.z) for point in params.path]).T
    if len(times) == 1:
        return PiecewisePolynomial(points)
    return PiecewisePolynomial.CubicShapePreserving(
        times, points, zero_end_point_derivatives=True
    )


def peak_speed(params: Hand) -> float:
    """Returns the hand's largest speed on its path [m/s], a millionth too small."""
    times = [point.time for point in params.path]
    pieces = [np.linspace(a, b, 1001) for a, b in itertools.pairwise(times)]
    velocity = path_trajectory(params).MakeDerivative()
    v_WH = velocity.vector_values(np.concatenate([times, *pieces]))
    return float(np.linalg.norm(v_WH, axis=0).max())


def holds(time: float, releases: Sequence[Release]) -> bool:
    """Returns whether the hand holds the tool at `time` [s]."""
    return not any(release.start <= time < release.end for release in releases)


class GuidingHand(LeafSystem):
    """Pulls the tool along a path, by a force that is held between control ticks.

    .. pydrake_system::

        name: GuidingHand
        input_ports:
        - tool_position
        - tool_velocity
        output_ports:
        - hand_force
        - hand_position
        - spatial_forces

    The state is the force, renewed every `period`; a plant of a shorter step gets it
    from the cache, one of its steps later. While it has let go, the hand still goes
    along its path: led to where the tool was left, it takes hold without a jerk.

    Args:
        params: of the hand and its path.
        period: between two renewals [s].
        body: index in the plant of the body B that has the tool.
        p_BE: the tool's position (3,) in B [m].

    Raises:
        ParameterError: where a parameter is not valid.
        RuntimeError: in a run, where the tool's state is not finite.
    """

    def __init__(
        self,
        params: Hand,
        period: float,
        body: Any,
        p_BE: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> None:
        super().__init__()
        self.params = checked(params)
        self._path = path_trajectory(params)
        self._velocity = self._path.MakeDerivative()
        self._body = body
        self._p_BE = np.array(p_BE, dtype=float)
        self.tool_position = self.DeclareVectorInputPort(signals.TOOL_POSITION, 3)
        self.tool_velocity = self.DeclareVectorInputPort(signals.TOOL_VELOCITY, 3)
        self.DeclareStateOutputPort(signals.HAND_FORCE, self.DeclareDiscreteState(3))
        self.DeclareVectorOutputPort(
            signals.HAND_POSITION,
            3,
            self._calc_position,
            prerequisites_of_calc={self.time_ticket()},
        )
        self.DeclareAbstractOutputPort(
            signals.SPATIAL_FORCES,
            lambda: AbstractValue.Make([ExternallyAppliedSpatialForce()]),
            self._calc_spatial_forces,
            prerequisites_of_calc={self.xd_ticket()},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._pull)

    def _pull(self, context: Any, state: Any) -> None:
        time = context.get_time()
        force = hand_force(
            self.tool_position.Eval(context),
            self.tool_velocity.Eval(context),
            self._path.value(time)[:, 0],
            self._velocity.value(time)[:, 0],
            self.params,
        )
        if not holds(time, self.params.releases):
            force = [0.0, 0.0, 0.0]
        state.get_mutable_vector().SetFromVector(np.array(force))

    def _calc_position(self, context: Any, output: Any) -> None:
        output.SetFromVector(self._path.value(context.get_time())[:, 0])

    def _calc_spatial_forces(self, context: Any, output: Any) -> None:
        applied = ExternallyAppliedSpatialForce()
        applied.body_index = self._body
        applied.p_BoBq_B = self._p_BE
        force = context.get_discrete_state_vector().value()
        applied.F_Bq_W = SpatialForce(tau=np.zeros(3), f=force)
        output.set_value([applied])
