"""A filter in front of NiceGUI's own WebSocket: only what its pages send gets through.

NiceGUI lays out the page; no button on the page works through NiceGUI. Its socket takes
other messages of the Socket.IO protocol without checking them, so they stop here.
"""

import json
import re
from typing import Any
from urllib.parse import parse_qs

from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

_PATH = "/_nicegui_ws/"

_NAME = re.compile(r"[\w-]{1,64}", re.ASCII)
_COUNT = re.compile(r"-?\d{1,9}", re.ASCII)

_HANDSHAKE = {
    "client_id": _NAME,
    "document_id": _NAME,
    "tab_id": _NAME,
    "next_message_id": _COUNT,
}
"""What a page sends of itself when it connects."""

_ACK = {"client_id": _NAME, "next_message_id": _COUNT}
"""What a page sends when it has received something."""

_CONTROL = {"3", "40", "41"}
"""Socket.IO's packets pong, connect and disconnect."""

_EVENT = re.compile(r'42\d{0,9}\["(ack|handshake)",(.*)\]', re.ASCII)


class NiceguiFilter:
    """Passes on to NiceGUI what its pages send, and closes the socket on anything else.

    Args:
        app: application that NiceGUI is a part of.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Passes a request on, or refuses it."""
        if not scope.get("path", "").startswith(_PATH):
            await self.app(scope, receive, send)
        elif scope["type"] == "http":  # Socket.IO's polling, used without WebSockets.
            await PlainTextResponse("only by WebSocket\n", 404)(scope, receive, send)
        elif _is_page(scope["query_string"].decode("latin-1")):
            await self.app(scope, _filtered(receive, send), send)
        else:
            await send({"type": "websocket.close", "code": 1008})


def _filtered(receive: Receive, send: Send) -> Receive:
    """Returns `receive` that closes the socket on a message that is not allowed."""

    async def receiving() -> Message:
        message = await receive()
        if message["type"] != "websocket.receive" or _is_allowed(message.get("text")):
            return message
        await send({"type": "websocket.close", "code": 1008})
        return {"type": "websocket.disconnect", "code": 1008}

    return receiving


def _is_page(query: str) -> bool:
    """Returns whether a query is the one by which NiceGUI's pages connect."""
    given = {key: values[-1] for key, values in parse_qs(query).items()}
    transport = [given.get(key) for key in ("EIO", "transport", "sid")]
    return transport == ["4", "websocket", None] and _has(given, _HANDSHAKE)


def _is_allowed(text: str | None) -> bool:
    if text is None or text in _CONTROL:
        return text is not None
    event = _EVENT.fullmatch(text)
    if not event:
        return False
    try:
        data = json.loads(event[2])
    except (ValueError, RecursionError):
        return False
    flat = isinstance(data, dict) and not any(
        isinstance(x, list | dict) for x in data.values()
    )
    return flat and _has(data, _ACK if event[1] == "ack" else _HANDSHAKE)


def _has(data: dict[str, Any], keys: dict[str, re.Pattern[str]]) -> bool:
    return all(
        key in data and pattern.fullmatch(str(data[key]))
        for key, pattern in keys.items()
    )
