"""What blocks and diagrams need of a robot: its model, its limits, its setup."""

from drake_mobman.robot_model.base_limits import BaseLimits
from drake_mobman.robot_model.model import BASE_JOINTS, RobotDescription, RobotModel
from drake_mobman.robot_model.reach import Reach
from drake_mobman.robot_model.setup import RobotSetup
from drake_mobman.robot_model.workspace_limits import WorkspaceLimits

__all__ = [
    "BASE_JOINTS",
    "BaseLimits",
    "Reach",
    "RobotDescription",
    "RobotModel",
    "RobotSetup",
    "WorkspaceLimits",
]
