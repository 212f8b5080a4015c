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
    scenario: AnyScenario,
    setup: RobotSetup | None = None,
    *,
    decomposer: Any = None,
    logged: bool = True,
) -> Diagram:
    """Returns the diagram of a scenario of any kind.

    Args:
        scenario: checked, as `load_scenario` returns it.
        setup: of its robot, `scenario.setup()` unless given.
        decomposer: a block to use instead of the scenario's, with the same ports.
        logged: whether every signal is logged each period, for `simulation.log`.

    Raises:
        ParameterError: where a block cannot work with its parameters.
        ValueError: if a decomposer is given where there is none to replace.
    """
    options = {} if decomposer is None else {"decomposer": decomposer}
    if options and not hasattr(scenario, "decomposer"):
        raise ValueError("a guided scenario has no decomposer to replace")
    make = DIAGRAMS[type(scenario)]
    diagram: Diagram = make(scenario, setup, logged=logged, **options)
    return diagram
