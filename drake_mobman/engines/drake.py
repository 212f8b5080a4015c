"""The engine `drake`: the plant as it is."""

import dataclasses as dc
from typing import Any, ClassVar

from pydrake.systems.framework import DiagramBuilder


@dc.dataclass
class Drake:
    """Drake steps the plant."""

    package: ClassVar[str] = "drake"
    needs_masses: ClassVar[bool] = False

    def add_to(
        self, builder: DiagramBuilder, plant: Any, scene_graph: Any = None
    ) -> Any:
        """Adds the plant to a diagram, and its `SceneGraph` where it has contacts."""
        builder.AddNamedSystem("plant", plant)
        if scene_graph is not None:
            builder.AddNamedSystem("scene_graph", scene_graph)
            poses = scene_graph.get_source_pose_port(plant.get_source_id())
            builder.Connect(plant.get_geometry_pose_output_port(), poses)
            builder.Connect(
                scene_graph.get_query_output_port(),
                plant.get_geometry_query_input_port(),
            )
        return plant
