"""What a robot file holds: a model, and what of it is base, arm and tool."""

import dataclasses as dc
import math

from drake_mobman.arm.oriented_inverse import ORIENTATIONS
from drake_mobman.parameters import (
    ACCELERATION,
    ANGLE,
    LENGTH,
    OFFSET,
    REACH,
    SPEED,
    YAW_ACCELERATION,
    YAW_RATE,
    ParameterError,
    Range,
    one_of,
    within,
)
from drake_mobman.schema import ALL

ORIENTED = (*ORIENTATIONS, "free")
"""What the end effector's orientation may do; free takes fewer than six joints."""

_RADIUS = Range(0.005, 2.0, "m")


@dc.dataclass
class Part:
    """Another model, welded onto what is there."""

    model: str = ""  # Its file: a path or a package:// URI.
    frame: str = ""  # Link or frame that its root is welded to.
    xyz: list[float] = dc.field(default_factory=lambda: [0.0] * 3)  # Of its root [m].
    # The same: roll, pitch, yaw [rad].
    rpy: list[float] = dc.field(default_factory=lambda: [0.0] * 3)

    def check(self) -> None:
        """Raises `ParameterError` unless the part can be placed."""
        _given(self, "model", "frame")
        _of_three(self, OFFSET, "xyz")
        _of_three(self, ANGLE, "rpy")


@dc.dataclass
class DrivenWheels:
    """Joints of the wheels that drive, on each side."""

    left: list[str] = dc.field(default_factory=list)  # Joints.
    right: list[str] = dc.field(default_factory=list)  # Joints.

    def check(self) -> None:
        """Raises `ParameterError` unless there is a wheel on each side, each once."""
        for side in ("left", "right"):
            if not getattr(self, side):
                raise ParameterError(side, [], "must name one joint or more")
        names = [*self.left, *self.right]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            side = "right" if twice in self.right else "left"
            raise ParameterError(side, twice, "must name each wheel once")


@dc.dataclass
class Caster:
    """A wheel that turns freely, where it touches the floor."""

    x: float = 0.0  # In B [m].
    y: float = 0.0  # In B [m].
    radius: float = 0.03  # [m].

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, OFFSET, "x", "y")
        within(self, _RADIUS, "radius")


@dc.dataclass
class PlatformLimits:
    """What the base can do."""

    speed: float = 1.0  # Forward and back [m/s].
    yaw_rate: float = 2.0  # [rad/s].
    acceleration: float = 1.0  # [m/s^2].
    yaw_acceleration: float = 2.0  # [rad/s^2].

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, SPEED, "speed")
        within(self, YAW_RATE, "yaw_rate")
        within(self, ACCELERATION, "acceleration")
        within(self, YAW_ACCELERATION, "yaw_acceleration")


@dc.dataclass
class Platform:
    """The base: where it is in the model, its wheels, and what it can do."""

    frame: str = ""  # Link or frame with x ahead and z up; derived: the model's root.
    wheels: DrivenWheels | None = None  # None where the model has no wheels that drive.
    wheel_radius: float | None = None  # [m]; derived.
    track: float | None = None  # Between the wheels on both sides [m]; derived.
    body_radius: float | None = None  # b_d, of a circle around the base [m]; derived.
    casters: list[Caster] = dc.field(default_factory=list)  # Derived.
    limits: PlatformLimits = dc.field(default_factory=PlatformLimits)  # Of its drive.

    def check(self) -> None:
        """Raises `ParameterError` unless all that is given is in range."""
        _within_if_given(self, _RADIUS, "wheel_radius")
        _within_if_given(self, LENGTH, "track", "body_radius")


@dc.dataclass
class Arm:
    """The arm: its tool, and how it is used. Its joints are those on the way there."""

    tool: str = ""  # Link or frame of the end effector E.
    # Of E: `turning`, `held`, `reach`, or `free` for fewer than six joints; derived.
    orientation: str = ""
    posture: list[float] = dc.field(default_factory=list)  # [rad], [m]; derived.
    tee: str = ""  # Link or frame at T; derived: where the wrist's axes meet.

    def check(self) -> None:
        """Raises `ParameterError` unless there is a tool, and a valid orientation."""
        _given(self, "tool")
        if self.orientation:
            one_of(self, "orientation", ORIENTED)


@dc.dataclass
class ArmLimits:
    """Limits of the arm's joints that the model lacks, or by name in place of its own.

    A number is for all joints whose limit the model lacks.
    """

    # [rad/s^2], [m/s^2].
    joint_acceleration: dict[str, float] = dc.field(default_factory=lambda: {ALL: 10.0})
    # [rad/s], [m/s].
    joint_velocity: dict[str, float] = dc.field(default_factory=lambda: {ALL: 2.0})

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        for key in ("joint_acceleration", "joint_velocity"):
            for name, limit in getattr(self, key).items():
                if not 1e-3 <= limit <= 1e4:
                    valid = "must be within [0.001, 10000]"
                    raise ParameterError(f"{key}.{name}", limit, valid)


@dc.dataclass
class Gripper:
    """The joints of a gripper, where it is open and where it is closed."""

    joints: list[str] = dc.field(default_factory=list)  # Those that follow no other.
    open: float = 0.0  # Of each joint [rad], [m].
    closed: float = 0.0  # Of each joint [rad], [m].

    def check(self) -> None:
        """Raises `ParameterError` unless it has joints that move."""
        if not self.joints:
            raise ParameterError("joints", [], "must name one joint or more")
        if self.open == self.closed:
            raise ParameterError("closed", self.closed, "must differ from open")


@dc.dataclass
class Workspace:
    """Limits of the end effector, which a scenario may narrow; derived."""

    l_min: float | None = None  # [m].
    l_max: float | None = None  # [m].
    psi_min: float | None = None  # [rad].
    psi_max: float | None = None  # [rad].

    def check(self) -> None:
        """Raises `ParameterError` unless all that is given is in range and in order."""
        _within_if_given(self, REACH, "l_min", "l_max")
        _within_if_given(self, Range(-10.0, 10.0, "rad"), "psi_min", "psi_max")
        for low, high in (("l_min", "l_max"), ("psi_min", "psi_max")):
            least, most = getattr(self, low), getattr(self, high)
            if None not in {least, most} and not least < most:
                raise ParameterError(low, least, f"must be below {high} = {most!r}")


@dc.dataclass
class RobotFile:
    """The contents of a robot file. What is not given is derived from the model."""

    model: str = ""  # URDF, SDFormat, MJCF or .dmd.yaml: a path or a package:// URI.
    packages: dict[str, str] = dc.field(default_factory=dict)  # Folders by name.
    parts: list[Part] = dc.field(default_factory=list)  # Welded on, in this order.
    base: Platform = dc.field(default_factory=Platform)  # What drives, and carries.
    # Joints that are kept where they are [rad], [m]; others that are neither of the arm
    # nor wheels are at 0, or the nearest in range.
    held: dict[str, float] = dc.field(default_factory=dict)
    arm: Arm = dc.field(default_factory=Arm)  # What places the end effector.
    limits: ArmLimits = dc.field(default_factory=ArmLimits)  # Of the arm's joints.
    gripper: Gripper | None = None  # None where there is none that is to be moved.
    workspace: Workspace = dc.field(default_factory=Workspace)  # Of the end effector.
    driver: dict[str, str] = dc.field(default_factory=dict)  # On hardware.

    def check(self) -> None:
        """Raises `ParameterError` unless there is a model."""
        _given(self, "model")
        if ALL in self.held:
            valid = "must name joints, each with its own value"
            raise ParameterError("held", self.held[ALL], valid)


def limit_of(limits: dict[str, float], joint: str, own: float) -> float:
    """Returns a joint's limit: by name, else the model's own, else that for all.

    Args:
        limits: by the names of joints; `*` for all where the model has none.
        joint: its name.
        own: the model's; 0 or infinite where it has none.
    """
    if joint in limits:
        return limits[joint]
    return own if 0 < own < math.inf else limits.get(ALL, math.inf)


def _given(params: object, *keys: str) -> None:
    for key in keys:
        if not getattr(params, key).strip():
            raise ParameterError(key, getattr(params, key), "must be given")


def _within_if_given(params: object, valid: Range, *keys: str) -> None:
    within(params, valid, *(key for key in keys if getattr(params, key) is not None))


def _of_three(params: object, valid: Range, key: str) -> None:
    values = getattr(params, key)
    if len(values) != 3 or not all(valid.low <= x <= valid.high for x in values):
        raise ParameterError(key, values, f"must be three numbers within {valid}")
