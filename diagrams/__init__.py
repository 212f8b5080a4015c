"""How blocks are wired: a module a diagram."""

from typing import Any

from pydrake.systems.framework import Diagram

from drake_mobman.runs.scenario import AnyScenario, Guided

from .guided import make_guided_diagram
from .teleop import make_teleop_diagram


def make_diagram(
    scenario: AnyScenario, *, decomposer: Any = None, logged: bool = True
) -> Diagram:
    """Returns the diagram of a scenario, whichever it is.

    Raises:
        ValueError: if a decomposer is given where nobody commands the hand.
    """
    if isinstance(scenario, Guided):
        if decomposer is not None:
            raise ValueError("a guided scenario has no decomposer to replace")
        return make_guided_diagram(scenario, logged=logged)
    return make_teleop_diagram(scenario, decomposer=decomposer, logged=logged)
