"""How blocks are wired: one module for each diagram."""

from typing import Any

from pydrake.systems.framework import Diagram

from drake_mobman.robot_model import RobotSetup
from drake_mobman.scenario import AnyScenario, Guided, Teleop

from .guided import make_guided_diagram
from .teleop import make_teleop_diagram

DIAGRAMS: dict[type, Any] = {
    Teleop: make_teleop_diagram,
    Guided: make_guided_diagram,
}
"""The function that makes the diagram of each kind of scenario."""


def make_diagram(
    scenario: AnyScenario, setup: RobotSetup | None = None, **options: Any
) -> Diagram:
    """Returns the diagram of a scenario, whichever its kind.

    Args:
        scenario: checked, as `load_scenario` returns it.
        setup: of its robot, `scenario.setup()` unless given.
        options: as of `make_teleop_diagram` or `make_guided_diagram`: `logged`, and of
            the former `decomposer`.

    Raises:
        ParameterError: where a block cannot work with its parameters.
        ValueError: if a decomposer is given where there is none to replace.
    """
    if options.get("decomposer") is None:
        options.pop("decomposer", None)
    elif not hasattr(scenario, "decomposer"):
        raise ValueError("a guided scenario has no decomposer to replace")
    diagram: Diagram = DIAGRAMS[type(scenario)](scenario, setup, **options)
    return diagram
