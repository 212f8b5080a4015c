"""Scenarios fitted to a robot: a stick's profile and a hand's path, scaled to it."""

import dataclasses as dc
import math

from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.guidance.guiding_hand import Waypoint
from drake_mobman.guidance.planned import Planned
from drake_mobman.robot_model import RobotDescription
from drake_mobman.robots.servo import Servo
from drake_mobman.scenario.guided import Guided
from drake_mobman.scenario.teleop import Teleop
from drake_mobman.teleop.scripted import Held, Script, Smooth

_OF_BASE = 0.4
"""Speed of the end effector as a share of the base's: the base can catch up."""

_OF_FORWARD, _OF_RETREAT = 0.5, 0.8
"""Of the base's speeds where its forward and retreat zones end, what a hand makes."""

_PEAK = 1.5
"""Of a hand's mean speed between two rests, its largest."""

_CROSSING = 0.9
"""Least time in which the end effector crosses its workspace [s]."""

_RISE = 0.25
"""Speed up and down as a share of that along the reach."""


def fitted_teleop(robot: RobotDescription) -> Teleop:
    """Returns a stick's profile that leads a robot through all of its workspace.

    Out past the largest reach and on with the base, left while driving, back in past
    the least reach, right while rising and sinking, and out again.

    Raises:
        ParameterError: where the robot cannot be used.
    """
    plain = Teleop(robot=robot, fidelity=Servo())
    workspace, limits, guard = plain.workspace, plain.smoother.limits(), plain.guard
    width = workspace.l_max - workspace.l_min
    angle = workspace.psi_max - workspace.psi_min
    v = _round(min(_OF_BASE * limits.max_speed, width / _CROSSING, guard.max_v_c))
    w = _round(min(0.3 * limits.max_yaw_rate, guard.max_omega_c))
    rise = _round(min(_RISE * v, guard.max_v_z))
    slow, turn = _round(0.75 * v), _round(w / 3)
    out, back = (_seconds(2.0 + width / each) for each in (v, slow))  # And on.
    aside = _seconds(1.0 + angle / w)
    segments: list[Held | Smooth] = [
        Held(duration=1.0),
        Smooth(duration=1.0, v_c=v),
        Held(duration=out + 2.0, v_c=v),
        Smooth(duration=1.0, v_c=slow, omega_c=w),
        Held(duration=aside, v_c=slow, omega_c=w),
        Smooth(duration=1.0),
        Smooth(duration=1.0, v_c=-slow),
        Held(duration=back + 2.0, v_c=-slow),
        Smooth(duration=1.0),
        Smooth(duration=1.0, omega_c=-w, v_z=rise),
        Held(duration=aside + 1.0, omega_c=-w),
        Smooth(duration=1.0, v_z=-rise),
        Held(duration=2.0, v_z=-rise),
        Smooth(duration=1.0, v_c=v, omega_c=turn),
        Held(duration=out, v_c=v, omega_c=turn),
        Smooth(duration=1.0),
    ]
    return dc.replace(
        plain,
        description="The stick out, left, back in, right, up, down and out again.",
        duration=sum(segment.duration for segment in segments) + 1.0,
        source=Script(segments=segments),
    )


def fitted_guided(robot: RobotDescription) -> Guided:
    """Returns a path of a hand that leads a robot, no faster than its base follows.

    Ahead, through a quarter of a circle to the left, back towards the body, which gives
    way, and up and down while going ahead.

    Raises:
        ParameterError: where the robot cannot be used.
    """
    plain = Guided(robot=robot, fidelity=Servo())
    reach, speed = robot.reach(), _OF_BASE * plain.smoother.limits().max_speed
    if isinstance(plain.field, VelocityField):
        speed = min(speed, _followed(plain.field) / _PEAK)
    path = Path(plain.hand.path[0], speed, reach.r_f)
    low = max(-0.25 * reach.r_f, 0.1 - path.end.z)
    path.rest().go(x=4.0)
    path.rest().arc(2.0)
    path.rest().go(y=-1.4)
    path.rest().go(y=0.6, z=0.3 * reach.r_f)
    path.rest().go(y=0.6, z=low)
    path.rest()
    hand = dc.replace(plain.hand, path=path.points)
    return dc.replace(
        plain,
        description="The arm pulled ahead, aside, back to the body, up and down.",
        duration=path.end.time,
        source=Planned(),
        hand=hand,
    )


def _followed(field: VelocityField) -> float:
    """Returns the speed [m/s] at which the base follows well inside of its zones.

    Beyond, a short arm is stretched or folded before its base is as fast as the hand.
    """
    ahead, back = field.K_f * field.Delta_f, field.K_r * field.Delta_r
    return min(_OF_FORWARD * ahead, _OF_RETREAT * back)


class Path:
    """Waypoints of a hand, one after the other.

    Args:
        first: the first one.
        speed: of the hand [m/s].
        unit: length that distances are given in [m].
    """

    def __init__(self, first: Waypoint, speed: float, unit: float) -> None:
        self.points = [first]
        self._first, self._speed, self._unit = first, speed, unit

    @property
    def end(self) -> Waypoint:
        """Returns the last waypoint."""
        return self.points[-1]

    def rest(self) -> "Path":
        """Stays for a second."""
        self.points.append(dc.replace(self.end, time=self.end.time + 1.0))
        return self

    def go(self, x: float = 0.0, y: float = 0.0, z: float | None = None) -> None:
        """Goes straight on.

        Args:
            x: ahead [units].
            y: to the left [units].
            z: height to go to, above that of the first waypoint [m].
        """
        dx, dy = self._unit * x, self._unit * y
        height = self.end.z if z is None else self._first.z + z
        far = math.hypot(dx, dy, height - self.end.z)
        self._add(far, self.end.x + dx, self.end.y + dy, height)

    def arc(self, radius: float, pieces: int = 8) -> None:
        """Goes through a quarter of a circle to the left, from ahead.

        Args:
            radius: of the circle [units].
            pieces: between waypoints.
        """
        r, start = self._unit * radius, self.end
        step = math.pi / 2 / pieces
        for i in range(1, pieces + 1):
            x, y = r * math.sin(i * step), r * (1.0 - math.cos(i * step))
            self._add(r * step, start.x + x, start.y + y, start.z)

    def _add(self, far: float, x: float, y: float, z: float) -> None:
        time = self.end.time + math.ceil(far / self._speed * 10) / 10
        place = (round(each, 4) for each in (x, y, z))
        self.points.append(Waypoint(round(time, 1), *place))


def _round(x: float) -> float:
    """Returns a number of two digits, not larger."""
    scale = 10.0 ** (1 - math.floor(math.log10(x)))
    return math.floor(x * scale + 1e-9) / scale


def _seconds(x: float) -> float:
    """Returns a time in halves of a second, not shorter."""
    return math.ceil(2.0 * x) / 2.0
