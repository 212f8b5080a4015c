"""A hand holds the tool and moves it along a path (Petric & Zlajpah, fig. 4).

The paper's operator, as a spring and a damper with a bounded force.
"""

import dataclasses as dc
import itertools
import math
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np
from pydrake.math import sqrt
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from drake_mobman import signals
from drake_mobman.blocks import scalar_block
from drake_mobman.guidance.applied_force import add_fixed_point_force
from drake_mobman.parameters import (
    DAMPING,
    FORCE,
    PLACE,
    STIFFNESS,
    TIME,
    ParameterError,
    checked,
    checked_period,
    within,
)
from drake_mobman.scalars import Scalar, Vector, larger, where
from drake_mobman.ticks import at_tick


@dc.dataclass
class Waypoint:
    """A point of the hand's path in W, and when the hand is there."""

    time: float = 0.0  # [s].
    x: float = 0.58  # [m].
    y: float = 0.0  # [m].
    z: float = 0.52  # Above the floor [m].

    def check(self) -> None:
        """Raises `ParameterError` unless time and place are in range."""
        within(self, TIME, "time")
        within(self, PLACE, "x", "y", "z")


@dc.dataclass
class Release:
    """A time in which the hand lets go of the tool."""

    start: float = 0.0  # [s].
    end: float = 1.0  # [s].

    def check(self) -> None:
        """Raises `ParameterError` unless it ends after it starts."""
        within(self, TIME, "start", "end")
        if not self.end > self.start:
            valid = f"must be above start = {self.start!r}"
            raise ParameterError("end", self.end, valid)


@dc.dataclass
class Hand:
    """How the hand holds the tool, and the path along which it moves.

    The path goes through all waypoints. The hand is at rest at the first and the last
    one, and before and after. Between waypoints, each coordinate is a cubic that does
    not overshoot. Between two waypoints at rest, the largest speed is 1.5 times the
    distance over the time.
    """

    stiffness: float = 600.0  # Force per distance of the tool from the hand [N/m].
    # Renewed every 10 ms, it does not shake a tool of 0.24 kg effective mass or more;
    # that of the Franka arm is 0.43 kg at least, in any posture and direction.
    damping: float = 80.0  # Force per velocity of the tool from the hand's [Ns/m].
    max_force: float = 60.0  # Largest norm of the force [N].
    # Where the hand is, and when.
    path: list[Waypoint] = dc.field(default_factory=lambda: [Waypoint()])
    releases: list[Release] = dc.field(default_factory=list)  # When it lets go.

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range, and times in order."""
        within(self, STIFFNESS, "stiffness")
        within(self, DAMPING, "damping")
        within(self, FORCE, "max_force")
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


class Spring(Protocol):
    """A spring and a damper with a bounded force."""

    stiffness: float  # [N/m].
    damping: float  # [N s/m].
    max_force: float  # [N].


def hand_force(
    p_WE: Vector, v_WE: Vector, p_WH: Vector, v_WH: Vector, params: Spring
) -> list[Scalar]:
    """Returns the force (3,) in W [N] on a tool E that a hand H holds.

    f = stiffness (p_WH - p_WE) + damping (v_WH - v_WE), scaled down to `max_force`
    where its norm is larger.

    Args:
        p_WE: position (3,) of the tool [m].
        v_WE: its velocity (3,) [m/s].
        p_WH: position (3,) of the hand [m].
        v_WH: its velocity (3,) [m/s].
        params: of the hand.

    Raises:
        RuntimeError: where the force, of floats, is not finite, because an argument is
            not finite or far too large.
    """
    force = [
        params.stiffness * (H - E) + params.damping * (H_dot - E_dot)
        for E, E_dot, H, H_dot in zip(p_WE, v_WE, p_WH, v_WH, strict=True)
    ]
    parts = [f / params.max_force for f in force]
    excess = sqrt(sum(part * part for part in parts))
    if isinstance(excess, float) and not math.isfinite(excess):
        state = {"p_WE": p_WE, "v_WE": v_WE, "p_WH": p_WH, "v_WH": v_WH}
        given = ", ".join(f"{key} = {list(map(float, x))}" for key, x in state.items())
        raise RuntimeError(f"the hand's force is not finite: {given}")
    return [f / larger(excess, 1.0) for f in force]


def path_trajectory(params: Hand) -> PiecewisePolynomial:
    """Returns p_WH (3,) [m] over time [s]; it is constant before and after the path."""
    times = [point.time for point in params.path]
    points = np.array([(point.x, point.y, point.z) for point in params.path]).T
    if len(times) == 1:
        return PiecewisePolynomial(points)
    return PiecewisePolynomial.CubicShapePreserving(
        times, points, zero_end_point_derivatives=True
    )


def peak_speed(params: Hand) -> float:
    """Returns the hand's largest speed on its path [m/s], to one part in a million."""
    times = [point.time for point in params.path]
    pieces = [np.linspace(a, b, 1001) for a, b in itertools.pairwise(times)]
    velocity = path_trajectory(params).MakeDerivative()
    v_WH = velocity.vector_values(np.concatenate([times, *pieces]))
    return float(np.linalg.norm(v_WH, axis=0).max())


def grip(time: Scalar, releases: Sequence[Release]) -> Scalar:
    """Returns 1 where the hand holds the tool at `time` [s], else 0."""
    held = 1.0
    for release in releases:
        let_go = where(time < release.end, 0.0, held)
        held = where(time >= release.start, let_go, held)
    return held


def holds(time: float, releases: Sequence[Release]) -> bool:
    """Returns whether the hand holds the tool at `time` [s]."""
    return bool(grip(time, releases))


_HAND_VELOCITY = "hand_velocity"
"""3: v_WH [m/s] in W, a signal inside `GuidingHand`."""


@scalar_block
class GraspForce(LeafSystem):
    """Computes the force of a hand on the tool, and holds it between ticks.

    .. pydrake_system::

        name: GraspForce
        input_ports:
        - tool_position
        - tool_velocity
        - hand_position
        - hand_velocity
        output_ports:
        - hand_force

    The state is the force, renewed at each tick.

    Args:
        params: of the hand.
        period: between two ticks [s].

    Raises:
        ParameterError: where a parameter is not valid.
        RuntimeError: in a run, where the tool's state is not finite.
    """

    def __init__(self, params: Hand, period: float) -> None:
        self.params = checked(params)
        self.period = checked_period(period)
        # The force is renewed at the ticks only.
        self._releases = [
            Release(at_tick(release.start, period), at_tick(release.end, period))
            for release in params.releases
        ]
        self.motion = [
            self.DeclareVectorInputPort(name, 3)
            for name in (
                signals.TOOL_POSITION,
                signals.TOOL_VELOCITY,
                signals.HAND_POSITION,
                _HAND_VELOCITY,
            )
        ]
        force = self.DeclareDiscreteState(3)
        self.DeclareStateOutputPort(signals.HAND_FORCE, force)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._renew)

    def _renew(self, context: Any, state: Any) -> None:
        p_WE, v_WE, p_WH, v_WH = (
            # Python's own floats, which take half the time of numpy's.
            port.Eval(context).tolist()
            for port in self.motion
        )
        force = hand_force(p_WE, v_WE, p_WH, v_WH, self.params)
        held = grip(context.get_time(), self._releases)
        force = [held * f for f in force]
        state.get_mutable_vector().SetFromVector(np.array(force))


GraspForce_ = GraspForce.template


class GuidingHand(Diagram):
    """Pulls the tool along a path, by a force that is constant between control ticks.

    .. pydrake_system::

        name: GuidingHand
        input_ports:
        - tool_position
        - tool_velocity
        output_ports:
        - hand_force
        - hand_position
        - spatial_forces

    While it has let go, the hand still moves along its path: if the path ends where
    the tool was left, the hand takes hold again without a jerk.

    Args:
        params: of the hand and its path.
        period: control period [s].
        body: index in the plant of the tool's body B.
        p_BE: the tool's position (3,) in B [m].
        maybe_compiled: returns a block, or the same compiled.

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
        *,
        maybe_compiled: Callable[[Any], Any] = lambda block: block,
    ) -> None:
        super().__init__()
        builder = DiagramBuilder()
        grasp = maybe_compiled(GraspForce(params, period))
        builder.AddNamedSystem("grasp", grasp)
        path = path_trajectory(params)
        position = builder.AddNamedSystem("path", TrajectorySource(path))
        velocity = builder.AddSystem(TrajectorySource(path.MakeDerivative()))
        sources = {signals.HAND_POSITION: position, _HAND_VELOCITY: velocity}
        for name, source in sources.items():
            builder.Connect(source.get_output_port(), grasp.GetInputPort(name))
        force = grasp.GetOutputPort(signals.HAND_FORCE)
        for name in (signals.TOOL_POSITION, signals.TOOL_VELOCITY):
            builder.ExportInput(grasp.GetInputPort(name), name)
        builder.ExportOutput(force, signals.HAND_FORCE)
        builder.ExportOutput(position.get_output_port(), signals.HAND_POSITION)
        forces = add_fixed_point_force(builder, force, body, p_BE)
        builder.ExportOutput(forces, signals.SPATIAL_FORCES)
        builder.BuildInto(self)
        self.tool_position = self.GetInputPort(signals.TOOL_POSITION)
        self.tool_velocity = self.GetInputPort(signals.TOOL_VELOCITY)
