"""Where the tool is in the world, and how fast it moves."""

from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import Demultiplexer

from drake_mobman import signals
from drake_mobman.frames import body
from drake_mobman.robot_model.plant_motion import PlantMotion


class ToolSensor(Diagram):
    """Measures the tool's position and velocity, from the state of its plant.

    .. pydrake_system::

        name: ToolSensor
        input_ports:
        - robot_state
        output_ports:
        - tool_position
        - tool_velocity

    Args:
        motion: of the plant that is simulated.
    """

    def __init__(self, motion: PlantMotion) -> None:
        super().__init__()
        builder = DiagramBuilder()
        tool = builder.AddSystem(_ToolMotion(motion))
        split = builder.AddSystem(Demultiplexer([3, 3]))
        builder.Connect(tool.get_output_port(), split.get_input_port())
        builder.ExportInput(tool.get_input_port(), signals.ROBOT_STATE)
        builder.ExportOutput(split.get_output_port(0), signals.TOOL_POSITION)
        builder.ExportOutput(split.get_output_port(1), signals.TOOL_VELOCITY)
        builder.BuildInto(self)


class _ToolMotion(LeafSystem):
    """Position and velocity in one output: the model computes both at once."""

    def __init__(self, motion: PlantMotion) -> None:
        super().__init__()
        self.motion = motion
        self.tool = body(motion.plant, "tool")
        plant = motion.plant
        size = plant.num_positions() + plant.num_velocities()
        self.state = self.DeclareVectorInputPort(signals.ROBOT_STATE, size)
        needs = {self.all_input_ports_ticket()}
        self.DeclareVectorOutputPort(
            "motion", 6, self._calc_motion, prerequisites_of_calc=needs
        )

    def _calc_motion(self, context: Any, output: Any) -> None:
        p_WE, v_WE = self.motion.motion_W(self.tool, self.state.Eval(context))
        output.SetFromVector(np.concatenate((p_WE, v_WE)))
