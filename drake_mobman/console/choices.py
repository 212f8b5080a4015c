"""The controllers that an operator may choose from while driving."""

import dataclasses as dc
import typing
from collections.abc import Iterator
from typing import Any

from drake_mobman.parameters import ParameterError, checked
from drake_mobman.robots.defaults import default_of
from drake_mobman.scenario import AnyScenario
from drake_mobman.teleop.live import Operator


def live_scenario(scenario: AnyScenario) -> AnyScenario:
    """Returns a scenario for a live operator, who may choose all that works with it.

    If the scenario names no alternatives, it gets every other controller of its union
    that works with the robot, with the robot's own parameters.

    Raises:
        ParameterError: where the scenario cannot be driven.
    """
    driven: Any = dc.replace(scenario, source=Operator())
    if driven.alternatives:
        return checked(driven)
    works = []
    for candidate in _candidates(driven):
        try:
            checked(dc.replace(driven, alternatives=[candidate]))
        except ParameterError:
            continue  # Not with this robot.
        works.append(candidate)
    return dc.replace(driven, alternatives=works)


def choice_names(scenario: AnyScenario) -> list[str]:
    """Returns the names of the controllers, in the order of the signal `choice`."""
    return [name_of(params) for params in scenario.controllers]


def name_of(params: Any) -> str:
    """Returns a controller's own `label`, or its kind as scenarios name it."""
    label: str = getattr(params, "label", type(params).__name__.lower())
    return label


def _candidates(scenario: AnyScenario) -> Iterator[Any]:
    """Yields each kind of controller in each of its `variants`, but not the first."""
    first = scenario.controllers[0]
    for kind in _kinds(scenario):
        params = first if type(first) is kind else default_of(scenario.robot, kind)
        variants = params.variants() if hasattr(params, "variants") else [params]
        yield from (one for one in variants if name_of(one) != name_of(first))


def _kinds(scenario: AnyScenario) -> tuple[type, ...]:
    """Returns the union of which the scenario's `alternatives` are a list."""
    (item,) = typing.get_args(typing.get_type_hints(type(scenario))["alternatives"])
    return typing.get_args(item) or (item,)
