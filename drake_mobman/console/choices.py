"""What an operator may choose from while driving."""

import dataclasses as dc
import typing
from collections.abc import Iterator
from typing import Any

from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.decomposers import Decomposer
from drake_mobman.diagrams import make_diagram
from drake_mobman.parameters import ParameterError, checked
from drake_mobman.robots.defaults import default_of
from drake_mobman.scenario import AnyScenario, Guided
from drake_mobman.teleop.live import Operator


def live(scenario: AnyScenario) -> AnyScenario:
    """Returns a scenario for a live operator, who may choose all that works with it.

    Beside what the scenario names: each other decomposer as it fits the robot, and the
    field by either law. Alternatives that the scenario names itself stay as they are.

    Raises:
        ParameterError: where the scenario cannot be driven.
    """
    driven: Any = dc.replace(scenario, source=Operator())
    if driven.alternatives:
        return checked(driven)
    works = []
    for candidate in _candidates(driven):
        try:
            alone = checked(dc.replace(driven, alternatives=[candidate]))
            make_diagram(alone, logged=False)
        except ParameterError:
            continue  # Not with this robot.
        works.append(candidate)
    return dc.replace(driven, alternatives=works)


def choices(scenario: AnyScenario) -> list[str]:
    """Returns the names of what may be chosen, in the order of the signal `choice`."""
    return [name_of(params) for params in scenario.controllers]


def name_of(params: Any) -> str:
    """Returns what a decomposer is called in scenarios; of a field, its law too."""
    if isinstance(params, VelocityField):
        return f"field, {params.law}"
    return type(params).__name__.lower()


def _candidates(scenario: AnyScenario) -> Iterator[Any]:
    """Yields one of each kind but the scenario's own, and the field by each law."""
    own = scenario.controllers[0]
    field = own
    if not isinstance(own, VelocityField):
        field = default_of(scenario.robot, VelocityField)
    fields = [dc.replace(field, law=law) for law in ("projected", "printed")]
    if not isinstance(scenario, Guided):
        for kind in typing.get_args(Decomposer):
            if kind is not VelocityField and not isinstance(own, kind):
                yield default_of(scenario.robot, kind)
    yield from (one for one in fields if name_of(one) != name_of(own))
