"""What pages may say: every message is checked for size, shape and rate."""

import dataclasses as dc
import json
import math
import time
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple, NoReturn

from drake_mobman.console.allowance import Allowance
from drake_mobman.console.mailbox import OperatorInput
from drake_mobman.teleop.drag import NOTHING, Dragged

LARGEST = 512
"""Most bytes that a message may have."""

RATE = 120.0
"""Most messages a second that a page may send; ours sends two thirds of that."""

BURST = 120.0
"""Messages that may come at once, as after a hitch of the link."""

_LARGEST_COUNT = 2**53
"""Up to where a browser counts without rounding."""


class MessageError(ValueError):
    """A message that no page of ours sends; it ends the connection.

    Args:
        reason: in a few words.
        code: by which the socket is closed.
    """

    TOO_BIG = 1009
    NOT_OURS = 1008

    def __init__(self, reason: str, code: int = NOT_OURS) -> None:
        super().__init__(reason)
        self.code = code


@dc.dataclass(frozen=True)
class Ask:
    """Something asked for by a button."""

    what: str  # One of `ASKS`.
    choice: str = ""  # Where a decomposer or field is chosen.


class Message(NamedTuple):
    """What a page says, and when, for `Lateness`."""

    said: OperatorInput | Ask
    sent: float  # By the page's own monotonic clock [s].
    ahead: float | None  # Our clock less the page's, at least [s]; None if unheard.


ASKS = ("stop", "take", "hand_over", "reset", "record", "end_record", "choose")


def parsed(
    message: str | bytes,
    largest: tuple[float, float, float],
    bodies: Mapping[str, int] = MappingProxyType({}),
) -> Message:
    """Returns what a page says.

    Commands come as shares of the largest. Their numbers may be anything, as the gate
    is there to say why one does not pass; that they are numbers is checked here.

    Args:
        message: a JSON object.
        largest: magnitudes of v_c, v_z [m/s] and omega_c [rad/s] at a full stick.
        bodies: indices in the plant, by name, of those that may be dragged.

    Raises:
        MessageError: if no page of ours says such a thing.
    """
    if not isinstance(message, str):
        raise MessageError("not text")
    if len(message.encode(errors="replace")) > LARGEST:
        raise MessageError("too long", MessageError.TOO_BIG)
    try:
        # Values are turned into what they are to be below, or not at all.
        said = json.loads(
            message, parse_constant=_no_constant, object_pairs_hook=_each_once
        )
    except (ValueError, RecursionError):
        raise MessageError("not JSON") from None
    if not isinstance(said, dict):
        raise MessageError("not an object")
    sent, ahead = said.pop("sent", None), said.pop("ahead", None)
    times = _number(sent), None if ahead is None else _number(ahead)
    if not all(math.isfinite(time_) for time_ in times if time_ is not None):
        raise MessageError("not a time")
    if "ask" in said:
        return Message(_ask(said), *times)
    return Message(_input(said, largest, bodies), *times)


def _ask(said: dict[str, Any]) -> Ask:
    choice = said.get("choice", "")
    known = said["ask"] in ASKS and isinstance(choice, str)
    if not (known and said.keys() <= {"ask", "choice"}):
        raise MessageError("not something to ask for")
    return Ask(said["ask"], choice)


def _input(
    said: dict[str, Any],
    largest: tuple[float, float, float],
    bodies: Mapping[str, int],
) -> OperatorInput:
    names = {"sequence", "v_c", "omega_c", "v_z", "dead_man"}
    if said.keys() - {"drag"} != names or not isinstance(said["dead_man"], bool):
        raise MessageError("not an input")
    sequence = said["sequence"]
    if not (type(sequence) is int and 0 <= sequence <= _LARGEST_COUNT):
        raise MessageError("not an input")
    shares = (_number(said[name]) for name in ("v_c", "omega_c", "v_z"))
    v_c, omega_c, v_z = (x * most for x, most in zip(shares, largest, strict=True))
    dragged = _dragged(said.get("drag"), bodies)
    return OperatorInput(sequence, v_c, omega_c, v_z, said["dead_man"], dragged)


def _dragged(said: Any, bodies: Mapping[str, int]) -> Dragged:
    """Returns what a page says of a drag, or None where it drags nothing."""
    if said is None:
        return NOTHING
    if not isinstance(said, dict) or said.keys() != {"body", "point", "to"}:
        raise MessageError("not a drag")
    body, *places = said["body"], said["point"], said["to"]
    known = isinstance(body, str) and body in bodies
    if not (known and all(isinstance(x, list) and len(x) == 3 for x in places)):
        raise MessageError("not a drag")
    return Dragged(bodies[body], *(_number(x) for place in places for x in place))


def _number(value: Any) -> float:
    if type(value) not in (int, float):
        raise MessageError("not a number")
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _each_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Returns an object, of which nobody can say what it says where a key is repeated.

    Raises:
        ValueError: where it is.
    """
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a key twice")
    return found


def _no_constant(name: str) -> NoReturn:
    raise ValueError(name)  # NaN and Infinity are not JSON.


class Rate:
    """Counts messages: so many may come at once, and so many a second.

    Args:
        clock: the wall's [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._allowance = Allowance(RATE, BURST, clock)

    def count(self) -> None:
        """Counts a message.

        Raises:
            MessageError: where it is one too many.
        """
        if not self._allowance.takes():
            raise MessageError("too many messages")
