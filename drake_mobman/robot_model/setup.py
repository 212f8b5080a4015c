"""A robot as blocks are built for it."""

import dataclasses as dc
from typing import Any

from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.arm.limits import JointLimits
from drake_mobman.compiled import compiled
from drake_mobman.robot_model.base_limits import BaseLimits
from drake_mobman.robot_model.model import RobotDescription, RobotModel
from drake_mobman.robot_model.reach import Reach
from drake_mobman.robot_model.workspace_limits import WorkspaceLimits


@dc.dataclass(frozen=True)
class RobotSetup:
    """All that blocks need of a robot and of how it is used.

    Parameters of every kind build their block from it: `params.build(setup)`. The
    robot's model is parsed once for all of them. It is not for two threads: whatever
    reads the model overwrites its context.
    """

    robot: RobotDescription
    model: RobotModel
    arm: ArmKinematics
    joint_limits: JointLimits  # Of the arm.
    base_limits: BaseLimits  # Of the base as it is used, after its smoother.
    reach: Reach
    workspace: WorkspaceLimits
    period: float  # Of control [s].
    inverse: str = "positions"  # What of an arm in closed form is inverted.
    compiled: bool = False  # Whether blocks run without Python where that goes.

    @classmethod
    def of(
        cls,
        robot: RobotDescription,
        period: float,
        *,
        workspace: WorkspaceLimits | None = None,
        base_limits: BaseLimits | None = None,
        inverse: str = "positions",
        compiled: bool = False,
    ) -> "RobotSetup":
        """Returns the setup of a robot.

        Args:
            robot: which one.
            period: of control [s].
            workspace: that the arm is to keep, Kwon's unless given.
            base_limits: to keep besides the platform's own.
            inverse: what of an arm in closed form is inverted.
            compiled: whether blocks are compiled.
        """
        model = RobotModel(robot)
        return cls(
            robot=robot,
            model=model,
            arm=robot.arm(model.plant),
            joint_limits=model.joint_limits,
            base_limits=model.base_limits.narrowed(base_limits or BaseLimits()),
            reach=robot.reach(model.plant),
            workspace=workspace or WorkspaceLimits(),
            period=period,
            inverse=inverse,
            compiled=compiled,
        )

    def maybe_compiled(self, block: Any) -> Any:
        """Returns the block, or what does the same without Python."""
        return compiled(block) if self.compiled else block
