"""Checks of parameters; each error names the key, its value and what is valid."""

import dataclasses as dc
import math
import reprlib
from collections.abc import Iterator
from typing import Any, NamedTuple

from drake_mobman.ticks import whole_steps

_SHORT = reprlib.Repr()
"""Shortens values in messages: they may be as long as a file."""
_SHORT.maxstring = _SHORT.maxother = 60
_SHORT.maxlevel = 3

_LONGEST = 200
"""Largest length of a key in a message."""


def quoted(text: str) -> str:
    """Returns text for a message: unchanged if it is short and printable."""
    return text if text.isprintable() and len(text) < _LONGEST else _SHORT.repr(text)


class ParameterError(ValueError):
    """A parameter that its block cannot work with.

    Attributes:
        key: dotted path of the parameter, from the object that is checked.
        value: the one that is not valid.
        valid: what would be valid.
    """

    def __init__(self, key: str, value: object, valid: str) -> None:
        given = _SHORT.repr(value)
        super().__init__(f"{quoted(key)}: {given} is not valid; {valid}")
        self.key = key
        self.value = value
        self.valid = valid

    def below(self, parent: str) -> "ParameterError":
        """Returns the same error with `parent` before its key."""
        dot = "" if self.key[:1] in {"", "["} else "."
        key = f"{parent}{dot}{self.key}"
        return ParameterError(key, self.value, self.valid)


class Range(NamedTuple):
    """The valid range of a quantity, both ends included."""

    low: float
    high: float
    unit: str = ""

    def __str__(self) -> str:
        """Returns it as text for messages, `[0.01, 10] m`."""
        return f"[{self.low:g}, {self.high:g}] {self.unit}".rstrip()


# For robots from 10 cm to 10 m, and for their operators.
LENGTH = Range(0.01, 10.0, "m")
"""Of a link, or of any other part of a robot."""
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
"""Of control: with a longer one, an operator cannot steer."""
PAUSE = Range(0.0, 60.0, "s")
"""Of a stop, or of a transition."""
TIME = Range(0.0, 1e6, "s")
"""In a run; eleven days at most."""
GAIN = Range(0.0, 1e3, "1/s")
"""A rate per distance: not above the sampling rate of the loop."""
STIFFNESS = Range(0.1, 1e6, "N/m")
DAMPING = Range(1e-3, 1e6, "N s/m")
FORCE = Range(1e-3, 1e5, "N")


def within(params: Any, valid: Range, *keys: str) -> None:
    """Raises `ParameterError` unless every named field is in a range."""
    for key in keys:
        value = getattr(params, key)
        if not valid.low <= value <= valid.high:
            raise ParameterError(key, value, f"must be within {valid}")


def check_whole(params: Any, key: str, step: float, name: str) -> None:
    """Raises `ParameterError` unless a time is 0 or whole steps [s].

    Args:
        params: whose field it is.
        key: of the field [s].
        step: that is counted [s].
        name: of such a step, for the message.
    """
    value = getattr(params, key)
    if value and not whole_steps(value, step):
        raise ParameterError(key, value, f"must be whole {name} of {step:g} s")


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
    """Returns a block's `period` [s] if it is valid, or raises `ParameterError`."""
    if not (period > 0 and math.isfinite(period)):
        raise ParameterError("period", period, "must be a finite number above 0")
    return period


def checked(params: Any) -> Any:
    """Returns `params` if all of it is valid.

    Every number in it, at any depth, must be finite; and every dataclass in it that has
    a method `check` must pass it.

    Raises:
        ParameterError: names the first field that is not valid.
    """
    for key, value in _children(params):
        if isinstance(value, float) and not math.isfinite(value):
            raise ParameterError(key, value, "must be a finite number")
        if dc.is_dataclass(value) or isinstance(value, list | dict):
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
    if isinstance(params, dict):
        return iter(params.items())
    return ((f.name, getattr(params, f.name)) for f in dc.fields(params))
