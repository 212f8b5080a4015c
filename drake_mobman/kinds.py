"""Kinds, such as decomposers: one import registers a new member."""

import dataclasses as dc
import functools
import operator
from collections.abc import Mapping
from typing import Any


def unions_of(namespace: Mapping[str, Any], *protocols: Any) -> tuple[Any, ...]:
    """Returns for each protocol the union of the dataclasses that implement it.

    A package's `__init__` imports each dataclass of its kind. Nothing more is needed to
    have it in scenarios, on the command line and in the console.

    Args:
        namespace: the `globals()` of that `__init__`.
        protocols: one for each kind.

    Raises:
        TypeError: where a dataclass implements none of them; names what it lacks.
    """
    found: dict[Any, list[Any]] = {protocol: [] for protocol in protocols}
    for name, x in namespace.items():
        # By its own name: an alias is another kind's union, of one member.
        if not (isinstance(x, type) and dc.is_dataclass(x) and x.__name__ == name):
            continue
        lacking = {protocol: _lacking(x, protocol) for protocol in protocols}
        nearest = min(protocols, key=lambda protocol: len(lacking[protocol]))
        if lacking[nearest]:
            names = ", ".join(lacking[nearest])
            raise TypeError(f"{x.__name__} lacks {names} of {nearest.__name__}")
        found[nearest].append(x)
    return tuple(functools.reduce(operator.or_, each) for each in found.values())


def _lacking(kind: type, protocol: Any) -> list[str]:
    """Returns what of a protocol a class does not have."""
    required = {**vars(protocol), **vars(protocol).get("__annotations__", {})}
    names = [name for name in required if not name.startswith("_")]
    return [name for name in names if not hasattr(kind, name)]
