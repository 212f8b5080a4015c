"""Where the tool is in the world: what the hand that holds it feels."""

from typing import Any

from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.systems.framework import LeafSystem

from drake_mobman import signals


class ToolSensor(LeafSystem):
    """Tells one body's origin and velocity from those of all bodies.

    .. pydrake_system::

        name: ToolSensor
        input_ports:
        - body_poses
        - body_spatial_velocities
        output_ports:
        - tool_position
        - tool_velocity

    Args:
        body: index of the tool's body in the plant.
    """

    def __init__(self, body: Any) -> None:
        super().__init__()
        self.body = int(body)
        self.poses = self.DeclareAbstractInputPort(
            signals.BODY_POSES, Value[list[RigidTransform]]()
        )
        self.velocities = self.DeclareAbstractInputPort(
            signals.BODY_VELOCITIES, Value[list[SpatialVelocity]]()
        )
        self.DeclareVectorOutputPort(signals.TOOL_POSITION, 3, self._calc_position)
        self.DeclareVectorOutputPort(signals.TOOL_VELOCITY, 3, self._calc_velocity)

    def _calc_position(self, context: Any, output: Any) -> None:
        output.SetFromVector(self.poses.Eval(context)[self.body].translation())

    def _calc_velocity(self, context: Any, output: Any) -> None:
        output.SetFromVector(self.velocities.Eval(context)[self.body].translational())
