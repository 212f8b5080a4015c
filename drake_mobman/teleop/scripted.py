"""Commands by a script: held for a time, or changed smoothly to a new value."""

import dataclasses as dc
from typing import ClassVar

from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from drake_mobman import signals
from drake_mobman.parameters import Range, checked, within
from drake_mobman.ticks import at_tick

_DURATION = Range(1e-6, 1e6, "s")
"""Of a segment: after hours, times nearer than the least may be one float."""

_SPEED = Range(-100.0, 100.0, "m/s")
_YAW_RATE = Range(-100.0, 100.0, "rad/s")
"""Ten and five times what any guard lets pass: scripts test the guard, too."""


_MOST_SEGMENTS = 100_000
"""In a script with its repeats: all are listed before a run, in some seconds."""


@dc.dataclass
class Held:
    """A constant command."""

    duration: float = 1.0  # How long [s].
    v_c: float = 0.0  # Along the reach [m/s].
    omega_c: float = 0.0  # Turning the reach about z [rad/s].
    v_z: float = 0.0  # Up [m/s].

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        _check_segment(self)


@dc.dataclass
class Smooth:
    """A command that changes from the end of the segment before to a new value.

    By a cubic that starts and ends with slope 0; its largest slope is 1.5 times the
    change over the duration.
    """

    duration: float = 1.0  # How long [s].
    v_c: float = 0.0  # At the end, along the reach [m/s].
    omega_c: float = 0.0  # At the end, turning the reach about z [rad/s].
    v_z: float = 0.0  # At the end, up [m/s].

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        _check_segment(self)


def _check_segment(segment: Held | Smooth) -> None:
    within(segment, _DURATION, "duration")
    within(segment, _SPEED, "v_c", "v_z")
    within(segment, _YAW_RATE, "omega_c")


@dc.dataclass
class Script:
    """Segments one after the other, from time 0 and from rest; after them, rest."""

    fed: ClassVar[bool] = False
    finite: ClassVar[bool] = True

    # One after the other.
    segments: list[Held | Smooth] = dc.field(default_factory=list)
    repeat: int = 1  # How many times the segments are run.

    def check(self) -> None:
        """Raises `ParameterError` unless there are some repeats, and not too many."""
        most = _MOST_SEGMENTS // max(len(self.segments), 1)
        within(self, Range(1, most, f"for {len(self.segments)} segments"), "repeat")

    def script(self) -> "Script":
        """Returns itself; other sources return what they have drawn up."""
        return self

    def build(self, period: float) -> "ScriptedSource":
        """Returns the block, for a control period [s]."""
        return ScriptedSource(self, period)


def script_trajectory(
    script: Script, period: float | None = None
) -> PiecewisePolynomial:
    """Returns the commands (3,) over time [s] that `script` describes.

    At the border of two segments the later one holds. After the last one, and where
    there is none, the command is zero.

    Args:
        script: the segments.
        period: control period at which it is sampled [s]. A border that is meant to be
            at a tick is moved there, where rounding of the durations' sum misses it.
    """
    end, value = 0.0, [0.0, 0.0, 0.0]
    pieces = []
    for segment in script.segments * script.repeat:
        start, end = end, end + segment.duration
        end = end if period is None else at_tick(end, period)
        target = [segment.v_c, segment.omega_c, segment.v_z]
        if isinstance(segment, Smooth):
            knots = [[a, b] for a, b in zip(value, target, strict=True)]
            flat = [[0.0, 0.0]] * 3
            pieces.append(PiecewisePolynomial.CubicHermite([start, end], knots, flat))
        else:
            knots = [[c, c] for c in target]
            pieces.append(PiecewisePolynomial.ZeroOrderHold([start, end], knots))
        value = target
    # A piece of rest comes after the script, so that the value at the script's very end
    # is 0 too.
    pieces.append(PiecewisePolynomial.ZeroOrderHold([end, end + 1.0], [[0.0, 0.0]] * 3))
    trajectory = pieces[0]
    for piece in pieces[1:]:
        trajectory.ConcatenateInTime(piece)
    return trajectory


class ScriptedSource(Diagram):
    """Puts out the commands of a script.

    .. pydrake_system::

        name: ScriptedSource
        output_ports:
        - ee_command

    Args:
        script: the segments.
        period: control period at which it is sampled [s]; see `script_trajectory`.

    Raises:
        ParameterError: where a segment is not valid.
    """

    def __init__(self, script: Script, period: float | None = None) -> None:
        super().__init__()
        builder = DiagramBuilder()
        trajectory = script_trajectory(checked(script), period)
        source = builder.AddNamedSystem("trajectory", TrajectorySource(trajectory))
        builder.ExportOutput(source.get_output_port(), signals.EE_COMMAND)
        builder.BuildInto(self)
