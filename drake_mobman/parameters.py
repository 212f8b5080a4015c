"""Checks of parameters: each names the key, its value and what is valid."""

import dataclasses as dc
import math
import reprlib
from collections.abc import Iterator
from typing import Any, NamedTuple

_SHORT = reprlib.Repr()
"""Shortens what messages quote: a whole file may have been given for a number."""
_SHORT.maxstring = _SHORT.maxother = 60
_SHORT.maxlevel = 3

_LONGEST = 200
"""Of a key that messages name; a path into the longest scenario is a fifth of it."""


def quoted(text: str) -> str:
    """Returns text for a line of a message: as it is, unless that would spoil it."""
    return text if text.isprintable() and len(text) < _LONGEST else _SHORT.repr(text)


class ParameterError(ValueError):
    """A parameter that its block cannot work with.

    Attributes:
        key: where it stands, as a dotted path below the object checked.
        value: what was given.
        valid: what would be valid.
    """

    def __init__(self, key: str, value: object, valid: str) -> None:
        given = _SHORT.repr(value)
        super().__init__(f"{quoted(key)}: {given} is not valid; {valid}")
        self.key = key
        self.value = value
        self.valid = valid

    def below(self, parent: str) -> "ParameterError":
        """Returns the same error as seen from the object that holds `parent`."""
        dot = "" if self.key[:1] in {"", "["} else "."
        key = f"{parent}{dot}{self.key}"
        return ParameterError(key, self.value, self.valid)


class Range(NamedTuple):
    """What makes sense for a quantity, both ends included."""

    low: float
    high: float
    unit: str = ""

    def __str__(self) -> str:
        """Returns it as a message says it, `[0.01, 10] m`."""
        return f"[{self.low:g}, {self.high:g}] {self.unit}".rstrip()


# For robots from 10 cm to 10 m, and for whoever leads them.
LENGTH = Range(0.01, 10.0, "m")
"""Of a link, or of whatever else a robot has one of."""
OFFSET = Range(-10.0, 10.0, "m")
"""Of one part of a robot from another."""
REACH = Range(0.0, 20.0, "m")
"""Of two links."""
PLACE = Range(-1e4, 1e4, "m")
"""Of a robot or a hand in the world."""
ANGLE = Range(-100.0, 100.0, "rad")
"""Of a joint, or a heading: it counts whole turns."""
SPEED = Range(1e-3, 10.0, "m/s")
YAW_RATE = Range(1e-3, 20.0, "rad/s")
ACCELERATION = Range(1e-3, 100.0, "m/s^2")
YAW_ACCELERATION = Range(1e-3, 1e3, "rad/s^2")
JERK = Range(1e-2, 1e4, "m/s^3")
YAW_JERK = Range(1e-2, 1e5, "rad/s^3")
PERIOD = Range(1e-4, 0.2, "s")
"""Of control: slower, nobody steers by it."""
PAUSE = Range(0.0, 60.0, "s")
"""Until something has stopped, or changed hands."""
TIME = Range(0.0, 1e6, "s")
"""In a run; eleven days at most."""
GAIN = Range(0.0, 1e3, "1/s")
"""Of a rate by a distance: some of these loops are not sampled any faster."""
STIFFNESS = Range(0.1, 1e6, "N/m")
DAMPING = Range(1e-3, 1e6, "N s/m")
FORCE = Range(1e-3, 1e5, "N")


def within(params: Any, valid: Range, *keys: str) -> None:
    """Raises `ParameterError` unless every named field is in a range."""
    for key in keys:
        value = getattr(params, key)
        if not valid.low <= value <= valid.high:
            raise ParameterError(key, value, f"must be within {valid}")


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
