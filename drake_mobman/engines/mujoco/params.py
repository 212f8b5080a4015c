"""The engine `mujoco`: MuJoCo steps the same robot."""

import dataclasses as dc
from importlib.util import find_spec
from typing import Any, ClassVar

from pydrake.systems.framework import DiagramBuilder

from drake_mobman.parameters import ParameterError, Range, within


@dc.dataclass
class Mujoco:
    """MuJoCo steps the plant: the same bodies, joints, servos, contacts and friction.

    Needs the extra `mujoco`.
    """

    substeps: int = 4  # Steps of MuJoCo in one of the plant.
    impratio: float = 100.0  # Friction's impedance over that of the normal force.

    package: ClassVar[str] = "mujoco"
    needs_masses: ClassVar[bool] = True

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range, and MuJoCo is there."""
        within(self, Range(1, 1000), "substeps")
        within(self, Range(1.0, 1e4), "impratio")
        if not find_spec("mujoco"):
            valid = "needs MuJoCo: pip install 'drake_mobman[mujoco]'"
            raise ParameterError("", "!Mujoco", valid)

    def add_to(
        self, builder: DiagramBuilder, plant: Any, scene_graph: Any = None
    ) -> Any:
        """Adds a system with the plant's ports to a diagram, and returns it.

        Raises:
            ParameterError: where the plant has what MuJoCo cannot step.
        """
        # Imported when it is used: MuJoCo may not be there.
        from drake_mobman.engines.mujoco.model import make_model  # noqa: PLC0415
        from drake_mobman.engines.mujoco.plant import MujocoPlant  # noqa: PLC0415

        model, mapping = make_model(
            plant, scene_graph, substeps=self.substeps, impratio=self.impratio
        )
        system = MujocoPlant(plant, model, mapping, self.substeps)
        return builder.AddNamedSystem("plant", system)
