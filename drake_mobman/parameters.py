"""Checks of parameters: each names the key, its value and what is valid."""

import dataclasses as dc
import math
import reprlib
from collections.abc import Iterator
from typing import Any

_SHORT = reprlib.Repr()
"""Shortens what messages quote: a whole file may have been given for a number."""
_SHORT.maxstring = _SHORT.maxother = 60


class ParameterError(ValueError):
    """A parameter that its block cannot work with.

    Attributes:
        key: where it stands, as a dotted path below the object checked.
        value: what was given.
        valid: what would be valid.
    """

    def __init__(self, key: str, value: object, valid: str) -> None:
        super().__init__(f"{key}: {_SHORT.repr(value)} is not valid; {valid}")
        self.key = key
        self.value = value
        self.valid = valid

    def below(self, parent: str) -> "ParameterError":
        """Returns the same error as seen from the object that holds `parent`."""
        key = f"{parent}{self.key}" if self.key[:1] == "[" else f"{parent}.{self.key}"
        return ParameterError(key, self.value, self.valid)


def positive(params: Any, *keys: str) -> None:
    """Raises `ParameterError` unless every named field is above zero."""
    for key in keys:
        if not getattr(params, key) > 0:
            raise ParameterError(key, getattr(params, key), "must be above 0")


def not_negative(params: Any, *keys: str) -> None:
    """Raises `ParameterError` unless every named field is zero or above."""
    for key in keys:
        if not getattr(params, key) >= 0:
            raise ParameterError(key, getattr(params, key), "must be 0 or above")


def in_order(params: Any, lower: str, upper: str) -> None:
    """Raises `ParameterError` unless the field `lower` is below `upper`."""
    low, high = getattr(params, lower), getattr(params, upper)
    if not low < high:
        raise ParameterError(lower, low, f"must be below {upper} = {high!r}")


def one_of(params: Any, key: str, names: tuple[str, ...]) -> None:
    """Raises `ParameterError` unless the field holds one of `names`."""
    if getattr(params, key) not in names:
        valid = f"must be one of {', '.join(names)}"
        raise ParameterError(key, getattr(params, key), valid)


def checked_period(period: float) -> float:
    """Returns a block's `period` [s] if it is one, or raises `ParameterError`."""
    if not (period > 0 and math.isfinite(period)):
        raise ParameterError("period", period, "must be a finite number above 0")
    return period


def checked(params: Any) -> Any:
    """Returns `params` if all of it is valid.

    Every number in it, however deep, must be finite; and every dataclass in it that
    has a method `check` must pass that.

    Raises:
        ParameterError: names the first field that is not valid.
    """
    for key, value in _children(params):
        if isinstance(value, float) and not math.isfinite(value):
            raise ParameterError(key, value, "must be a finite number")
        if dc.is_dataclass(value) or isinstance(value, list):
            try:
                checked(value)
            except ParameterError as error:
                raise error.below(key) from None
    if hasattr(params, "check"):
        params.check()
    return params


def _children(params: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(params, list):
        return ((f"[{i}]", item) for i, item in enumerate(params))
    return ((f.name, getattr(params, f.name)) for f in dc.fields(params))
