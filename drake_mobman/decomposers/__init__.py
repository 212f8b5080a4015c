"""Who moves, base or arm: one file a decomposer, and the laws they share."""

from typing import Any

from drake_mobman.base import BaseController, VelocityField
from drake_mobman.decomposers.blending import Blending
from drake_mobman.decomposers.diff_ik import DiffIk
from drake_mobman.decomposers.exact import Exact
from drake_mobman.decomposers.field import FieldDecomposer
from drake_mobman.decomposers.limiter import Limiter
from drake_mobman.decomposers.qp import Qp
from drake_mobman.decomposers.switching import Switching
from drake_mobman.robot_model import RobotSetup

Decomposer = Exact | Blending | Switching | VelocityField | Qp | DiffIk
"""Whatever splits the end effector's command between base and arm.

Each is a dataclass with `build(setup)`, its block; a base controller is one too.
"""


def build_decomposer(params: Decomposer, setup: RobotSetup) -> Any:
    """Returns the block; with a base controller, the arm does the rest.

    Raises:
        ParameterError: where a parameter is not valid for the robot.
    """
    if isinstance(params, BaseController):
        s = setup
        limiter = Limiter(s.arm, s.joint_limits, s.base_limits, None, s.period)
        return FieldDecomposer(params, s.reach, s.arm, limiter)
    return params.build(setup)


__all__ = [
    "Blending",
    "Decomposer",
    "DiffIk",
    "Exact",
    "Qp",
    "Switching",
    "VelocityField",
    "build_decomposer",
]
