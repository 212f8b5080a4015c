"""Messages from pages to the server: each is checked for size, shape and rate."""

import dataclasses as dc
import json
import math
import time
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple, NoReturn

from drake_mobman.console.mailbox import OperatorInput
from drake_mobman.console.token_bucket import TokenBucket
from drake_mobman.teleop.drag import NOTHING, Dragged

MAX_SIZE = 512
"""Most bytes of a message."""

RATE = 120.0
"""Most messages a second from a page; ours sends two thirds of that."""

BURST = 120.0
"""Most messages at once, as after a hitch of the link."""

_MAX_COUNT = 2**53
"""Largest number up to which a browser counts without rounding."""


class MessageError(ValueError):
    """A message that no page of ours sends; it closes the connection.

    Args:
        reason: in a few words.
        code: with which the socket is closed.
    """

    TOO_BIG = 1009
    NOT_OURS = 1008

    def __init__(self, reason: str, code: int = NOT_OURS) -> None:
        super().__init__(reason)
        self.code = code


@dc.dataclass(frozen=True)
class ButtonPress:
    """A press of a button on the page."""

    action: str  # One of `ACTIONS`.
    choice: str = ""  # Name of the controller, for the action "choose".


class Message(NamedTuple):
    """A page's message, with the times that `LatencyBound` needs."""

    content: OperatorInput | ButtonPress
    sent: float  # By the page's own monotonic clock [s].
    offset: float | None  # Our clock less the page's, at least [s]; None if not known.


ACTIONS = ("stop", "take", "hand_over", "reset", "record", "end_record", "choose")


def parse_message(
    message: str | bytes,
    largest: tuple[float, float, float],
    bodies: Mapping[str, int] = MappingProxyType({}),
) -> Message:
    """Returns what a page sends.

    Commands come as shares of the largest. That they are numbers is checked here; the
    gate checks their range, and says why one does not pass.

    Args:
        message: a JSON object.
        largest: magnitudes of v_c, v_z [m/s] and omega_c [rad/s] at a full stick.
        bodies: indices in the plant, by name, of the bodies that may be dragged.

    Raises:
        MessageError: if no page of ours sends such a message.
    """
    if not isinstance(message, str):
        raise MessageError("not text")
    if len(message.encode(errors="replace")) > MAX_SIZE:
        raise MessageError("too long", MessageError.TOO_BIG)
    try:
        data = json.loads(
            message, parse_constant=_no_constant, object_pairs_hook=_unique_keys
        )
    except (ValueError, RecursionError):
        raise MessageError("not JSON") from None
    if not isinstance(data, dict):
        raise MessageError("not an object")
    sent, offset = data.pop("sent", None), data.pop("ahead", None)
    times = _number(sent), None if offset is None else _number(offset)
    if not all(math.isfinite(time_) for time_ in times if time_ is not None):
        raise MessageError("not a time")
    if "ask" in data:
        return Message(_button_press(data), *times)
    return Message(_operator_input(data, largest, bodies), *times)


def _button_press(data: dict[str, Any]) -> ButtonPress:
    choice = data.get("choice", "")
    known = data["ask"] in ACTIONS and isinstance(choice, str)
    if not (known and data.keys() <= {"ask", "choice"}):
        raise MessageError("not a button of the page")
    return ButtonPress(data["ask"], choice)


def _operator_input(
    data: dict[str, Any],
    largest: tuple[float, float, float],
    bodies: Mapping[str, int],
) -> OperatorInput:
    names = {"sequence", "v_c", "omega_c", "v_z", "dead_man"}
    if data.keys() - {"drag"} != names or not isinstance(data["dead_man"], bool):
        raise MessageError("not an input")
    sequence = data["sequence"]
    if not (type(sequence) is int and 0 <= sequence <= _MAX_COUNT):
        raise MessageError("not an input")
    shares = (_number(data[name]) for name in ("v_c", "omega_c", "v_z"))
    v_c, omega_c, v_z = (x * most for x, most in zip(shares, largest, strict=True))
    dragged = _dragged(data.get("drag"), bodies)
    return OperatorInput(sequence, v_c, omega_c, v_z, data["dead_man"], dragged)


def _dragged(data: Any, bodies: Mapping[str, int]) -> Dragged:
    """Returns what a page drags, or `NOTHING`."""
    if data is None:
        return NOTHING
    if not isinstance(data, dict) or data.keys() != {"body", "point", "to"}:
        raise MessageError("not a drag")
    body, *points = data["body"], data["point"], data["to"]
    known = isinstance(body, str) and body in bodies
    if not (known and all(isinstance(x, list) and len(x) == 3 for x in points)):
        raise MessageError("not a drag")
    return Dragged(bodies[body], *(_number(x) for point in points for x in point))


def _number(value: Any) -> float:
    if type(value) not in (int, float):
        raise MessageError("not a number")
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _unique_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Returns an object; one with a repeated key has no clear meaning.

    Raises:
        ValueError: where a key is repeated.
    """
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a key twice")
    return found


def _no_constant(name: str) -> NoReturn:
    raise ValueError(name)  # NaN and Infinity are not JSON.


class MessageRateLimit:
    """Limits the rate of a page's messages, and how many may come at once.

    Args:
        clock: monotonic wall clock [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._bucket = TokenBucket(RATE, BURST, clock)

    def count(self) -> None:
        """Counts a message.

        Raises:
            MessageError: where it is one too many.
        """
        if not self._bucket.take():
            raise MessageError("too many messages")
