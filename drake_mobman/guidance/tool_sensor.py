"""Where the tool is in the world, and how fast it moves."""

from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import Demultiplexer

from drake_mobman import signals
from drake_mobman.frames import body
from drake_mobman.robot_model import RobotModel


class ToolSensor(Diagram):
    """Measures the tool's position and velocity, from the state of base and arm.

    .. pydrake_system::

        name: ToolSensor
        input_ports:
        - robot_state
        output_ports:
        - tool_position
        - tool_velocity

    Args:
        model: of the robot.
    """

    def __init__(self, model: RobotModel) -> None:
        super().__init__()
        builder = DiagramBuilder()
        motion = builder.AddSystem(_ToolMotion(model))
        split = builder.AddSystem(Demultiplexer([3, 3]))
        builder.Connect(motion.get_output_port(), split.get_input_port())
        builder.ExportInput(motion.get_input_port(), signals.ROBOT_STATE)
        builder.ExportOutput(split.get_output_port(0), signals.TOOL_POSITION)
        builder.ExportOutput(split.get_output_port(1), signals.TOOL_VELOCITY)
        builder.BuildInto(self)


class _ToolMotion(LeafSystem):
    """Position and velocity in one output: the model computes both at once."""

    def __init__(self, model: RobotModel) -> None:
        super().__init__()
        self.model = model
        self.tool = body(model.plant, "tool")
        plant = model.plant
        size = plant.num_positions() + plant.num_velocities()
        self.state = self.DeclareVectorInputPort(signals.ROBOT_STATE, size)
        needs = {self.all_input_ports_ticket()}
        self.DeclareVectorOutputPort(
            "motion", 6, self._calc_motion, prerequisites_of_calc=needs
        )

    def _calc_motion(self, context: Any, output: Any) -> None:
        p_WE, v_WE = self.model.motion_W(self.tool, self.state.Eval(context))
        output.SetFromVector(np.concatenate((p_WE, v_WE)))
