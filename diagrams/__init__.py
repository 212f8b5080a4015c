"""How blocks are wired: a module a diagram."""

import textwrap
from typing import Any

from pydrake.systems.framework import Diagram

from drake_mobman.parameters import ParameterError
from drake_mobman.scenario.scenario import AnyScenario, Guided, ScenarioError

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


def check_buildable(scenario: AnyScenario) -> None:
    """Finds out, before anything is run or written, whether the diagram can be built.

    Raises:
        ParameterError: where a block cannot work with its parameters.
        ScenarioError: says in one line what Drake cannot work with.
    """
    try:
        make_diagram(scenario, logged=False)
    except ParameterError:
        raise
    except (RuntimeError, ValueError, ArithmeticError, SystemExit) as error:
        # The latter is what pydrake makes of a condition that Drake takes for granted.
        reason = textwrap.shorten(str(error), 200, placeholder=" ...")
        raise ScenarioError(f"cannot be built; {reason}") from None
