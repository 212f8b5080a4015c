"""What every engine has, so that one can replace another."""

from typing import Any, ClassVar, Protocol

from pydrake.systems.framework import DiagramBuilder


class EngineParams(Protocol):
    """Parameters of what steps a robot's plant.

    Whatever its engine, a robot is built as a finalized `MultibodyPlant`.
    """

    package: ClassVar[str]  # That steps it, whose version goes with the results.
    needs_masses: ClassVar[bool]  # Whether it can only step a plant.

    def add_to(
        self, builder: DiagramBuilder, plant: Any, scene_graph: Any = None
    ) -> Any:
        """Adds what steps a plant to a diagram, as `plant`, and returns it.

        It has the ports of a `MultibodyPlant` that robots use, under the same names.

        Args:
            builder: of the diagram.
            plant: discrete and finalized; its default positions are the start.
            scene_graph: that the plant is registered with, where it has contacts.
        """
