"""The robot's setup: all that blocks are built from."""

import dataclasses as dc
from typing import Any

from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.arm.limits import JointLimits
from drake_mobman.compiled import compiled
from drake_mobman.engines.drake import Drake
from drake_mobman.engines.engine import EngineParams
from drake_mobman.robot_model.base_limits import BaseLimits
from drake_mobman.robot_model.model import RobotDescription, RobotModel
from drake_mobman.robot_model.reach import Reach
from drake_mobman.robot_model.workspace_limits import WorkspaceLimits


@dc.dataclass(frozen=True)
class RobotSetup:
    """All that blocks need to know of a robot and of its use.

    Parameters of every kind build their block from it: `params.build(setup)`. The
    robot's model is parsed once for all of them. Do not share it between threads: every
    reader of the model overwrites its context.
    """

    robot: RobotDescription
    model: RobotModel
    arm: ArmKinematics
    joint_limits: JointLimits  # Of the arm.
    base_limits: BaseLimits  # Of the smoothed base command.
    reach: Reach
    workspace: WorkspaceLimits
    period: float  # Of control [s].
    inverse: str = "positions"  # An arm in closed form inverts "positions" or "rates".
    compiled: bool = False  # Whether blocks are compiled, where possible.
    engine: EngineParams = dc.field(default_factory=Drake)  # Steps the robot's plant.

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
        engine: EngineParams | None = None,
    ) -> "RobotSetup":
        """Returns the setup of a robot.

        Args:
            robot: its parameters.
            period: of control [s].
            workspace: limits for the arm; Kwon's unless given.
            base_limits: in addition to the platform's own.
            inverse: "positions" or "rates", which an arm in closed form inverts.
            compiled: whether blocks are compiled, where possible.
            engine: that steps the robot's plant; Drake unless given.
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
            engine=engine or Drake(),
        )

    def maybe_compiled(self, block: Any) -> Any:
        """Returns the block, or a compiled one that does the same without Python."""
        return compiled(block) if self.compiled else block
