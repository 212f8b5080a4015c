"""NiceGUI's own socket, on which nothing is heard but that a page is there.

NiceGUI lays out the page; nothing on it is done by way of NiceGUI. What else may be
said to it, in the protocol of Socket.IO, would be taken in without being checked.
"""

import json
import re
from typing import Any
from urllib.parse import parse_qs

from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

_PLACE = "/_nicegui_ws/"

_NAME = re.compile(r"[\w-]{1,64}", re.ASCII)
_COUNT = re.compile(r"-?\d{1,9}", re.ASCII)

_KEYS = {
    "client_id": _NAME,
    "document_id": _NAME,
    "tab_id": _NAME,
    "next_message_id": _COUNT,
}
"""What a page says of itself when it comes."""

_ACK = {"client_id": _NAME, "next_message_id": _COUNT}
"""The same, of what it has heard."""

_QUIET = {"3", "40", "41"}
"""It is still there, it comes, it leaves."""

_EVENT = re.compile(r'42\d{0,9}\["(ack|handshake)",(.*)\]', re.ASCII)


class Deaf:
    """Passes on to NiceGUI what its pages say, and closes the socket on anything else.

    Args:
        app: that NiceGUI is a part of.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Passes on, or refuses."""
        if not scope.get("path", "").startswith(_PLACE):
            await self.app(scope, receive, send)
        elif scope["type"] == "http":  # To ask again and again, as without sockets.
            await PlainTextResponse("only by WebSocket\n", 404)(scope, receive, send)
        elif _is_page(scope["query_string"].decode("latin-1")):
            await self.app(scope, _heard(receive, send), send)
        else:
            await send({"type": "websocket.close", "code": 1008})


def _heard(receive: Receive, send: Send) -> Receive:
    """Returns `receive` that ends the socket where what comes is not for NiceGUI."""

    async def receiving() -> Message:
        message = await receive()
        said = message.get("text") if message["type"] == "websocket.receive" else "3"
        if _is_quiet(said):
            return message
        await send({"type": "websocket.close", "code": 1008})
        return {"type": "websocket.disconnect", "code": 1008}

    return receiving


def _is_page(query: str) -> bool:
    """Returns whether a page says who it is, in the way that NiceGUI looks for."""
    asked = {key: values[-1] for key, values in parse_qs(query).items()}
    way = [asked.get(key) for key in ("EIO", "transport", "sid")]
    return way == ["4", "websocket", None] and _has(asked, _KEYS)


def _is_quiet(said: str | None) -> bool:
    if said is None or said in _QUIET:
        return said is not None
    event = _EVENT.fullmatch(said)
    if not event:
        return False
    try:
        told = json.loads(event[2])
    except (ValueError, RecursionError):
        return False
    flat = isinstance(told, dict) and not any(
        isinstance(x, list | dict) for x in told.values()
    )
    return flat and _has(told, _ACK if event[1] == "ack" else _KEYS)


def _has(told: dict[str, Any], keys: dict[str, re.Pattern[str]]) -> bool:
    return all(
        key in told and pattern.fullmatch(str(told[key]))
        for key, pattern in keys.items()
    )
