"""Checks of whether a scenario fits its robot."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import RobotModel, RobotSetup, WorkspaceLimits
from drake_mobman.robots.defaults import Start

T = TypeVar("T")

REACHED = 1e-9
"""Largest distance from a desired position that counts as reached [m], [rad]."""


def check_joints(q: Any, key: str, model: RobotModel) -> None:
    """Raises `ParameterError` where a joint angle is out of its limits.

    Args:
        q: joint angles (n,) [rad].
        key: of the parameter that needs these angles, for the message.
        model: of the robot.
    """
    for name, angle, low, high in zip(
        model.arm_joints,
        q,
        model.joint_limits.lower,
        model.joint_limits.upper,
        strict=True,
    ):
        if not low <= angle <= high:
            valid = f"must keep joint {name} within [{low:g}, {high:g}] rad"
            raise ParameterError(key, f"{name} = {angle:.4g} rad", valid)


def check_workspace(
    workspace: WorkspaceLimits, start: Start, setup: RobotSetup
) -> None:
    """Raises `ParameterError` where the arm does not reach its workspace limits.

    Authority would then never pass to the base. Each limit is checked as near to the
    start as the other limits allow.
    """
    inside = (
        min(max(start.l, workspace.l_min), workspace.l_max),
        min(max(start.psi, workspace.psi_min), workspace.psi_max),
    )
    ends = {"l_min": 0, "l_max": 0, "psi_min": 1, "psi_max": 1}
    for name, i in ends.items():
        place = [*inside, start.z]
        place[i] = limit = getattr(workspace, name)
        q = setup.arm.inverse(place)
        nearest = setup.arm.ee_cylindrical(q)
        if max(abs(a - b) for a, b in zip(nearest, place, strict=True)) > REACHED:
            l, psi, z = (round(x, 4) + 0.0 for x in nearest)
            valid = f"out of reach; the nearest is l = {l}, psi = {psi}, z = {z}"
            raise ParameterError(f"workspace.{name}", limit, valid)
        check_joints(q, f"workspace.{name}", setup.model)


def keyed(key: str, controllers: Sequence[T]) -> Iterator[tuple[str, T]]:
    """Yields controllers with their keys: the first at `key`, then alternatives."""
    keys = [key, *(f"alternatives[{i}]" for i in range(len(controllers) - 1))]
    return zip(keys, controllers, strict=True)


@contextmanager
def below(key: str) -> Iterator[None]:
    """Puts `key` before the key of a `ParameterError` raised inside."""
    try:
        yield
    except ParameterError as error:
        raise error.below(key) from None
