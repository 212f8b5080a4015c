"""All that blocks need of a robot from a file: as given, or derived from its model."""

import dataclasses as dc
import functools
import math
from typing import Any

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from drake_mobman.arm.chain import chain_of
from drake_mobman.arm.jacobian_arm import LEVEL, JacobianArm
from drake_mobman.arm.pseudo_inverse import Damping
from drake_mobman.arm.shoulder import shoulder_of
from drake_mobman.base.smoother import Smoother
from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.decomposers.blending import Blending
from drake_mobman.decomposers.exact import Exact
from drake_mobman.guidance.guiding_hand import Hand
from drake_mobman.robot_model import Reach, WorkspaceLimits
from drake_mobman.robot_model.model import BASE_JOINTS, base_limits, joint_limits
from drake_mobman.robots.defaults import Start
from drake_mobman.robots.derive import Derived
from drake_mobman.robots.derive.damping import damping
from drake_mobman.robots.derive.field import field
from drake_mobman.robots.derive.hand import hand
from drake_mobman.robots.derive.posture import posture
from drake_mobman.robots.derive.ranges import arm_ranges
from drake_mobman.robots.derive.reach import farthest
from drake_mobman.robots.derive.speeds import guard, smoother
from drake_mobman.robots.derive.workspace import Reached, reached, workspace
from drake_mobman.robots.file.described import Described
from drake_mobman.robots.file.placement import GIVEN
from drake_mobman.robots.file.rolling import acting_track, footing
from drake_mobman.robots.wheels.tip_limits import centres_of_mass, upright_limits
from drake_mobman.teleop.guard import Guard

_TRANSITION = 0.28
"""Width of the transition of authority, as a share of the workspace's; Franka's."""

_SMOOTHSTEP = 3.0
"""Width of a transition times its sharpness alpha."""


@dc.dataclass(frozen=True)
class Resolved:
    """What is known of a robot, each with where it is from."""

    plant: Any  # Finalized, for kinematics.
    orientation: Derived[str]  # Of the end effector.
    posture: Derived[np.ndarray]  # (n,) [rad], [m].
    damping: Derived[Damping]
    arm: JacobianArm
    reach: Derived[Reach]
    reached: Derived[Reached]  # How far E goes from the posture.
    workspace: Derived[WorkspaceLimits]
    body_radius: Derived[float]  # [m].
    track: Derived[float] | None  # By which the base turns [m]; of one with wheels.
    smoother: Derived[Smoother]
    guard: Derived[Guard]
    field: Derived[VelocityField]
    hand: Derived[Hand]

    def defaults(self) -> list[Any]:
        """Returns parameters that fit the robot, for what a scenario leaves out."""
        l, psi, z = map(float, self.arm.ee_cylindrical(self.arm.posture))
        limits = self.workspace.value
        sharpness = _SMOOTHSTEP / (_TRANSITION * (limits.l_max - limits.l_min))
        sharpness = min(sharpness, 1e3)
        return [
            Start(l=l, psi=psi, z=z),
            limits,
            self.smoother.value,
            self.guard.value,
            Exact(alpha=sharpness, phi_min=0.15, phi_max=0.5),
            Blending(alpha=sharpness),
            self.field.value,
            self.hand.value,
        ]


@functools.lru_cache(maxsize=16)
def resolve(robot: Described) -> Resolved:
    """Returns all that is known of a robot.

    Raises:
        ParameterError: where something is neither given nor to be derived.
    """
    given = robot.contents
    plant = MultibodyPlant(0.0)
    robot.assembly.add_to(plant)
    plant.Finalize()
    chain, ranges = chain_of(plant), arm_ranges(plant)
    r_f = farthest(chain, ranges)
    middle = chain.at(ranges.middle.tolist())
    scaled = damping(r_f.value, math.dist(middle.X_BE.p, middle.p_BT))
    turned = _orientation(given.arm.orientation, chain.num_joints)
    level = turned.value != "free"
    if given.arm.posture:
        at = Derived(np.array(given.arm.posture), GIVEN)
    else:
        p_BS = shoulder_of(chain, ranges.middle).p_BS
        at = posture(plant, p_BS, r_f.value, scaled.value.length, level=level)
    arm = JacobianArm(plant, at.value, scaled.value, level=level)
    d, e, l_0 = arm.p_BS
    reach = Derived(Reach(l_0, r_f.value, d, e), r_f.source)
    limits, base = joint_limits(plant), smoother(base_limits(plant))
    most = guard(arm, limits, base.value)
    far = reached(arm, limits, ranges, most.value, r_f.value)
    radius = robot.placement.body_radius
    nearest = _nearest(arm, far.value.l[0])
    within = _given(workspace(arm, far.value), given.workspace)
    base = _upright(robot, arm, plant, within.value, base)
    return Resolved(
        plant=plant,
        orientation=turned,
        posture=at,
        damping=scaled,
        arm=arm,
        reach=reach,
        reached=far,
        workspace=within,
        body_radius=radius,
        track=_track(robot, plant, at.value),
        smoother=base,
        guard=guard(arm, limits, base.value),
        field=field(reach.value, radius.value, nearest, _height(arm), base.value),
        hand=hand(plant, at.value, _place(arm)),
    )


def _upright(
    robot: Described,
    arm: JacobianArm,
    plant: Any,
    workspace: WorkspaceLimits,
    base: Derived[Smoother],
) -> Derived[Smoother]:
    """Returns limits of the base's command by which a robot on wheels does not tip."""
    if not robot.layout.wheels:
        return base
    known = robot.contents, robot.loose, robot.layout, robot.placement
    z = float(arm.ee_cylindrical(arm.posture)[2])
    centres = centres_of_mass(arm, plant, workspace, workspace.l_max, z)
    limits = base.value.limits()
    narrow = upright_limits(centres, limits, footing(*known))
    if narrow == limits:
        return base
    changes = {
        key: math.floor(1e3 * getattr(narrow, key)) / 1e3
        for key in ("max_acceleration", "max_yaw_rate", "max_yaw_acceleration")
    }
    source = f"{base.source}; accelerations such that it does not tip over"
    return Derived(dc.replace(base.value, **changes), source)


def _track(robot: Described, plant: Any, posture: np.ndarray) -> Derived[float] | None:
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, np.append(np.zeros(BASE_JOINTS), posture))
    centre = plant.CalcCenterOfMassPositionInWorld(context)[:2]
    known = robot.contents, robot.loose, robot.layout, robot.placement
    return acting_track(*known, centre)


def _orientation(given: str, joints: int) -> Derived[str]:
    if given:
        return Derived(given, GIVEN)
    if joints < LEVEL:
        return Derived("free", f"{joints} joints place E and do not turn it")
    return Derived("turning", f"{joints} joints place E and turn it")


def _given(found: Derived[Any], given: Any) -> Derived[Any]:
    """Returns what was derived, with what the robot file has in its place."""
    told = {k: x for k, x in vars(given).items() if x is not None}
    if not told:
        return found
    rest = "" if len(told) == len(vars(given)) else f"; else {found.source}"
    value = dc.replace(found.value, **told)
    return Derived(value, f"{', '.join(told)} {GIVEN}{rest}")


def _nearest(arm: JacobianArm, l: float) -> float:
    """Returns how far T is from the shoulder's axis where E is nearest to it [m]."""
    _, psi, z = arm.ee_cylindrical(arm.posture)
    x, y, _ = np.subtract(arm.p_BT(arm.inverse((l, psi, z))), arm.p_BS)
    return math.hypot(x, y)


def _height(arm: JacobianArm) -> float:
    """Returns how far T is above the shoulder at the posture [m]."""
    return float(arm.p_BT(arm.posture)[2] - arm.p_BS[2])


def _place(arm: JacobianArm) -> np.ndarray:
    """Returns where E is at the posture (3,) [m]."""
    l, psi, z = arm.ee_cylindrical(arm.posture)
    return np.add(arm.p_BS, (l * math.cos(psi), l * math.sin(psi), z))
