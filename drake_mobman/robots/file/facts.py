"""What is known of a robot from a file, as text: each value, and where it is from."""

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from drake_mobman.robot_model.model import BASE_JOINTS
from drake_mobman.robots.derive import Derived
from drake_mobman.robots.file.contents import PlatformLimits
from drake_mobman.robots.file.described import Described
from drake_mobman.robots.file.file import File
from drake_mobman.robots.file.placement import GIVEN
from drake_mobman.robots.file.resolved import Resolved

USUAL = "usual, as the file gives none"
"""Source of what neither file nor model has."""


class Fact(NamedTuple):
    """A value that is known of a robot."""

    group: str  # What it is of.
    name: str
    value: str  # With its unit.
    source: str  # Given, or what it is derived from.


def facts(robot: File) -> list[Fact]:
    """Returns all that is known of a robot.

    Raises:
        ParameterError: where it cannot be used.
    """
    it, known = robot.described(), robot.resolved()
    return [*_base(it, known), *_arm(it, known), *_joints(it, known), *_use(known)]


def _base(it: Described, known: Resolved) -> Iterator[Fact]:
    placed, limits = it.placement, it.contents.base.limits
    origin = placed.X_FB.value.translation()
    at = f"{_numbers(origin)} m in {it.layout.base}"
    yield Fact("base", "B", at, placed.X_FB.source)
    if placed.wheel_radius and placed.track:
        wheels = f"{len(it.layout.left)} left, {len(it.layout.right)} right"
        yield Fact("base", "wheels", wheels, GIVEN)
        yield _length("base", "wheel_radius", placed.wheel_radius)
        yield _length("base", "track", placed.track)
        if known.track and known.track.value != placed.track.value:
            yield _length("base", "turns as with a track of", known.track)
    yield _length("base", "body_radius", known.body_radius)
    linear = f"{limits.speed:g} m/s, {limits.acceleration:g} m/s^2"
    turning = f"{limits.yaw_rate:g} rad/s, {limits.yaw_acceleration:g} rad/s^2"
    source = USUAL if limits == PlatformLimits() else GIVEN
    yield Fact("base", "limits", f"{linear}; {turning}", source)
    mass = known.plant.CalcTotalMass(known.plant.CreateDefaultContext())
    yield Fact("base", "mass", f"{mass:.4g} kg", "all links of the model")


def _arm(it: Described, known: Resolved) -> Iterator[Fact]:
    joints, reach = it.layout.arm, known.reach.value
    way = f"on the way from {it.layout.base} to {it.layout.tool}"
    yield Fact("arm", "joints", f"{len(joints)}: {', '.join(joints)}", way)
    for name, at in it.contents.held.items():
        yield Fact("arm", f"held.{name}", f"{at:g}", GIVEN)
    S = reach.ahead, reach.aside, reach.l_0
    turn = known.arm.turn
    about = f"axis of {joints[turn.joint]}" if turn else "vertical, of no joint"
    yield Fact("arm", "S", f"{_numbers(S)} m in B", about)
    tee = it.placement.tee
    yield Fact("arm", "T", f"fixed to {tee.value}", tee.source)
    yield Fact("arm", "r_f", f"{reach.r_f:.4g} m", known.reach.source)
    yield Fact("arm", "orientation", *known.orientation)
    posture = known.posture
    yield Fact("arm", "posture", _numbers(posture.value), posture.source)
    damping = known.damping
    value = f"{damping.value.length:.3g} m, {damping.value.threshold:.3g}"
    yield Fact("arm", "damping", value, damping.source)


def _joints(it: Described, known: Resolved) -> Iterator[Fact]:
    plant, n = known.plant, BASE_JOINTS
    limits = it.contents.limits
    for key, unit, most, given in (
        ("velocity", "rad/s", plant.GetVelocityUpperLimits(), limits.joint_velocity),
        (
            "acceleration",
            "rad/s^2",
            plant.GetAccelerationUpperLimits(),
            limits.joint_acceleration,
        ),
    ):
        own = {name: _own(it, name, key) for name in it.layout.arm}
        lacking = [name for name, x in own.items() if not 0 < x < np.inf]
        source = "the model's"
        if len(lacking) == len(own):
            source = "the file's or usual, as the model has none"
        elif lacking:
            source = f"the model's, but of {', '.join(lacking)}"
        if any(name in given for name in it.layout.arm):
            source = f"{source}; some {GIVEN}"
        yield Fact("limits", f"joint_{key}", f"{_numbers(most[n:])} {unit}", source)


def _use(known: Resolved) -> Iterator[Fact]:
    limits, far = known.workspace.value, known.reached.value
    l = f"{limits.l_min:.4g} to {limits.l_max:.4g} m"
    psi = f"{limits.psi_min:.4g} to {limits.psi_max:.4g} rad"
    yield Fact("workspace", "l", l, known.workspace.source)
    yield Fact("workspace", "psi", psi, known.workspace.source)
    z = f"{far.z[0]:.4g} to {far.z[1]:.4g} m above S"
    yield Fact("workspace", "z", z, known.reached.source)
    most = known.guard.value
    command = (
        f"{most.max_v_c:.3g} m/s, {most.max_omega_c:.3g} rad/s, {most.max_v_z:.3g} m/s"
    )
    yield Fact("use", "largest command", command, known.guard.source)
    base = known.smoother.value
    speeds = f"{base.max_speed:.3g} m/s, {base.max_yaw_rate:.3g} rad/s"
    yield Fact("use", "base command", speeds, known.smoother.source)
    field = known.field.value
    widths = f"Delta_f {field.Delta_f:.3g}, Delta_r {field.Delta_r:.3g}"
    zones = f"{widths}, b_d {field.b_d:.3g} m"
    yield Fact("use", "field", zones, known.field.source)
    hand = known.hand.value
    pull = f"{hand.stiffness:.3g} N/m, {hand.damping:.3g} N s/m"
    yield Fact("use", "hand", pull, known.hand.source)


def _own(it: Described, name: str, key: str) -> float:
    """Returns the model's own limit of a joint; 0 or infinite where it has none."""
    joint = it.loose.parsed.joints[name]
    limits: Any = getattr(joint, f"{key}_upper_limits")()
    return float(limits[0])


def _length(group: str, name: str, found: Derived[float]) -> Fact:
    return Fact(group, name, f"{found.value:.4g} m", found.source)


def _numbers(values: Iterable[float]) -> str:
    return ", ".join(f"{round(float(x), 4) + 0.0:g}" for x in values)
