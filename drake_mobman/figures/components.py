"""The components of the end effector's command, and how figures show them."""

import dataclasses as dc

import numpy as np

from drake_mobman import signals
from drake_mobman.figures.style import near
from drake_mobman.simulation.run import Run


@dc.dataclass(frozen=True)
class Component:
    """A component of the command, and the coordinate that it changes."""

    index: int  # In `ee_command`, `ee_cylindrical` and `arm_command`.
    name: str
    rate: str  # Symbol of the velocity.
    rate_unit: str
    coordinate: str  # Symbol of the coordinate.
    unit: str  # Of the coordinate.

    limits: tuple[str, str, str] | None  # Symbol of its limits, and their keys.

    def commanded(self, run: Run) -> bool:
        """Returns whether the end effector is ever commanded in this component."""
        if signals.ARM_COMMAND not in run.log:
            return False
        return bool(np.any(run[signals.EE_COMMAND][:, self.index]))


LINEAR = Component(0, "Linear", "v", "m/s", "l", "m", ("L", "l_min", "l_max"))
ANGULAR = Component(
    1, "Angular", r"\omega", "rad/s", r"\psi", "rad", (r"\Psi", "psi_min", "psi_max")
)
VERTICAL = Component(2, "Vertical", "v_z", "m/s", "z", "m", None)


def limits_of(run: Run, part: Component) -> dict[str, float]:
    """Returns the limits to draw for a coordinate, by their symbols.

    There are none of z, and none where a base controller drives: it knows no workspace.
    """
    if part.limits is None or run.scenario.base_controller is not None:
        return {}
    symbol, *keys = part.limits
    low, high = (getattr(run.scenario.workspace, key) for key in keys)
    limits = {rf"{symbol}_\mathrm{{min}}": low, rf"{symbol}_\mathrm{{max}}": high}
    return near(limits, run[signals.EE_CYLINDRICAL][:, part.index])
