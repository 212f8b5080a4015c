"""What a scenario asks of its robot: refused where it cannot fit."""

from typing import Any

from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.base.smoother import Smoother
from drake_mobman.base.velocity_field import VelocityField, check_zones
from drake_mobman.decomposers.diff_ik import DiffIk
from drake_mobman.decomposers.share import WorkspaceLimits
from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import Robot, RobotModel
from drake_mobman.robots.defaults import Start

REACHED = 1e-9
"""How far from where it is to be the hand counts as there [m], [rad]."""


def check_joints(q: Any, key: str, model: RobotModel) -> None:
    """Raises `ParameterError` where what stands at `key` takes a joint too far.

    Args:
        q: joint angles (n,) that it leads to [rad].
        key: of what leads there.
        model: of the robot.
    """
    for name, angle, low, high in zip(
        model.arm_joints, q, model.limits.lower, model.limits.upper, strict=True
    ):
        if not low <= angle <= high:
            valid = f"must keep joint {name} within [{low:g}, {high:g}] rad"
            raise ParameterError(key, f"{name} = {angle:.4g} rad", valid)


def check_workspace(
    workspace: WorkspaceLimits, start: Start, arm: ArmKinematics, model: RobotModel
) -> None:
    """Raises `ParameterError` where the arm does not fill its workspace.

    Authority would never pass to the base, as the arm ends before. Each end is looked
    at from where in the workspace is nearest to the start.
    """
    inside = (
        min(max(start.l, workspace.l_min), workspace.l_max),
        min(max(start.psi, workspace.psi_min), workspace.psi_max),
    )
    ends = {"l_min": 0, "l_max": 0, "psi_min": 1, "psi_max": 1}
    for name, i in ends.items():
        hand = [*inside, start.z]
        hand[i] = given = getattr(workspace, name)
        q = arm.inverse(hand)
        nearest = arm.ee_cylindrical(q)
        if max(abs(a - b) for a, b in zip(nearest, hand, strict=True)) > REACHED:
            l, psi, z = (round(x, 4) + 0.0 for x in nearest)
            valid = f"out of reach; the nearest is l = {l}, psi = {psi}, z = {z}"
            raise ParameterError(f"workspace.{name}", given, valid)
        check_joints(q, f"workspace.{name}", model)


def check_base(params: Smoother | DiffIk, key: str, model: RobotModel) -> None:
    """Raises `ParameterError` where the robot's base is asked for more than it can do.

    What is asked for stands at `key`.
    """
    plant = model.plant
    ahead, turn = plant.GetJointByName("x"), plant.GetJointByName("theta")
    most = {
        "max_speed": ahead.velocity_upper_limits(),
        "max_acceleration": ahead.acceleration_upper_limits(),
        "max_yaw_rate": turn.velocity_upper_limits(),
        "max_yaw_acceleration": turn.acceleration_upper_limits(),
    }
    for name, (limit,) in most.items():
        if not getattr(params, name) <= limit:
            valid = f"must be at most {limit:g}, which is what the base can do"
            raise ParameterError(f"{key}.{name}", getattr(params, name), valid)


def check_controllers(controllers: list[Any], key: str, robot: Robot) -> None:
    """Raises `ParameterError` where one asks for more than arm or base can do.

    The first stands at `key`, the others among the alternatives.
    """
    keys = [key, *(f"alternatives[{i}]" for i in range(len(controllers) - 1))]
    for at, params in zip(keys, controllers, strict=True):
        if isinstance(params, VelocityField):
            try:
                check_zones(params, robot.reach())
            except ParameterError as error:
                raise error.below(at) from None
        if isinstance(params, DiffIk):
            check_base(params, at, RobotModel(robot))
