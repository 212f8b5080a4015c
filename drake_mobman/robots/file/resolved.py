"""All that blocks need of a robot from a file: as given, or derived from its model."""

import math
from typing import Any

import numpy as np

from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.pseudo_inverse import Damping
from drake_mobman.decomposers.blending import Blending
from drake_mobman.decomposers.exact import Exact
from drake_mobman.frames import frame
from drake_mobman.guidance.guiding_hand import Hand, Waypoint
from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import BASE_JOINTS, Reach, WorkspaceLimits
from drake_mobman.robots.defaults import Start
from drake_mobman.robots.file.described import Described

_HALF_WIDTH = 0.09
"""Of the workspace, where it is not given [m]."""


def arm_of(robot: Described, plant: Any) -> JacobianArm:
    """Returns the arm's kinematics, by its Jacobian.

    Args:
        robot: the file.
        plant: finalized, of the robot.
    """
    posture = robot.contents.arm.posture
    if not posture:
        raise ParameterError("arm.posture", posture, "must be given")
    context = plant.CreateDefaultContext()
    X_TE = frame(plant, "tool").CalcPose(context, frame(plant, "tee"))
    length = max(float(np.linalg.norm(X_TE.translation())), 0.05)
    return JacobianArm(plant, posture, Damping(length=length))


def reach_of(robot: Described, plant: Any) -> Reach:
    """Returns shoulder and reach for a base controller; arguments as `arm_of`."""
    d, e, l_0 = arm_of(robot, plant).p_BS
    context = plant.CreateDefaultContext()
    base, tee = (frame(plant, name) for name in ("base", "tee"))
    low, high = plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits()
    low, high = (x[BASE_JOINTS:].clip(-np.pi, np.pi) for x in (low, high))
    r_f = 0.0
    for q in np.random.default_rng(0).uniform(low, high, (2000, len(low))):
        plant.SetPositions(context, [*[0.0] * BASE_JOINTS, *q])
        p_BT = tee.CalcPose(context, base).translation()
        r_f = max(r_f, float(np.linalg.norm(p_BT - [d, e, l_0])))
    return Reach(l_0, r_f, d, e)


def defaults_of(robot: Described, plant: Any) -> list[Any]:
    """Returns parameters that fit the robot; arguments as `arm_of`."""
    arm, given = arm_of(robot, plant), robot.contents.workspace
    l, psi, z = map(float, arm.ee_cylindrical(arm.posture))
    limits = {
        "l_min": l - _HALF_WIDTH,
        "l_max": l + _HALF_WIDTH,
        "psi_min": psi - 0.5,
        "psi_max": psi + 0.5,
    }
    told = {k: x for k, x in vars(given).items() if x is not None}
    d, e, l_0 = arm.p_BS
    ahead, aside = l * math.cos(psi), l * math.sin(psi)
    return [
        Start(l=l, psi=psi, z=z),
        WorkspaceLimits(**limits | told),
        Exact(alpha=60.0),
        Blending(alpha=60.0),
        Hand(path=[Waypoint(x=d + ahead, y=e + aside, z=l_0 + z)]),
    ]
