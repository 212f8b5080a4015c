"""Names of a model's joints and frames, and what is near to one that is wrong."""

import difflib
from collections import Counter
from collections.abc import Collection, Iterable
from typing import Any, TypeVar

from drake_mobman.parameters import ParameterError

T = TypeVar("T")

_SHOWN = 8
"""Names in a message, where none is near."""


def named(plant: Any, elements: Iterable[T]) -> dict[str, T]:
    """Returns elements of a plant by name, or `instance::name` if it is not unique."""
    them: list[Any] = list(elements)
    count = Counter(x.name() for x in them)
    return {(x.name() if count[x.name()] == 1 else scoped(plant, x)): x for x in them}


def scoped(plant: Any, element: Any) -> str:
    """Returns the name of an element of a plant with that of its model instance."""
    instance = plant.GetModelInstanceName(element.model_instance())
    return f"{instance}::{element.name()}"


def found(key: str, name: str, known: dict[str, T], what: str) -> T:
    """Returns what has a name.

    Args:
        key: of the parameter that holds the name, for the message.
        name: to find.
        known: all that there are, by name.
        what: they are, for the message.

    Raises:
        ParameterError: where there is none; the message has names that are near.
    """
    if name in known:
        return known[name]
    raise ParameterError(key, name, f"must be {what}; {near(name, known)}")


def near(name: str, known: Collection[str]) -> str:
    """Returns for a message the known names that are like one, or the first ones."""
    if not known:
        return "there are none"
    ambiguous = [x for x in known if x.rpartition("::")[2] == name]
    if ambiguous:
        return f"there are {' and '.join(ambiguous)}"
    alike = difflib.get_close_matches(name, known, 4, 0.4)
    if alike:
        return f"near are {', '.join(alike)}"
    more = ", ..." if len(known) > _SHOWN else ""
    return f"there are {', '.join(list(known)[:_SHOWN])}{more}"
