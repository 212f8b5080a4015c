"""The door: who may ask the server for anything at all.

Authentication by a token, and checks of `Host` and `Origin`.
"""

import hmac
import ipaddress
from urllib.parse import parse_qs, urlsplit

from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

COOKIE = "mobman_token"

POLICY = (
    "default-src 'self' 'unsafe-inline' 'unsafe-eval' data: blob:; "
    "frame-ancestors 'self'"
)
"""Nothing from elsewhere on our pages, and no page of ours inside one of elsewhere: a
click meant for another site must not drive a robot."""


def is_loopback(host: str) -> bool:
    """Returns whether a name or address is this machine, seen by itself alone."""
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host.lower() == "localhost"


class Door:
    """Lets in who has the token, and no other site's pages.

    Any site that is open in the same browser may send requests here. It cannot hide
    where it comes from: `Origin` says so. Nor can it, by a name of its own that leads
    here, hide that this is not its server: `Host` says so, where only this machine is
    let in; elsewhere it lacks the token.

    Args:
        app: behind the door.
        token: to be shown once, as `?token=`; a cookie remembers it. Where it is None,
            only this machine is let in.
    """

    def __init__(self, app: ASGIApp, token: str | None = None) -> None:
        self.app = app
        self._token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Passes a request on, or refuses it."""
        if scope["type"] not in {"http", "websocket"}:
            await self.app(scope, receive, send)
            return
        asked = HTTPConnection(scope)
        why = self._why_not(asked)
        shown = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        if not why and self._token and not self._is_token(_remembered(asked)):
            if scope["type"] == "http" and self._is_token(shown):
                # The token leaves the address bar, and so the history.
                welcome = RedirectResponse(scope["path"], status_code=303)
                # Not strict: after a link in a mail or chat the browser would hold the
                # cookie back. Sockets ask for `Origin`, and no GET acts.
                welcome.set_cookie(COOKIE, shown, httponly=True, samesite="lax")
                await welcome(scope, receive, send)
                return
            why = "the token is missing or wrong; open the address printed at the start"
        if not why:
            await self.app(scope, receive, _with_policy(send))
        elif scope["type"] == "http":
            await PlainTextResponse(f"{why}\n", 403)(scope, receive, send)
        else:
            await send({"type": "websocket.close", "code": 1008, "reason": why})

    def _why_not(self, asked: HTTPConnection) -> str:
        """Returns why nobody with such a request is let in, or nothing."""
        host = asked.headers.get("host", "")
        origin = asked.headers.get("origin")
        try:
            name = urlsplit(f"//{host}").hostname or ""
            site = urlsplit(origin or "").netloc
        except ValueError:
            return "a host or origin that is none"
        if self._token is None and not is_loopback(name):
            return "this server is for the machine that it runs on"
        if origin is None:
            # Browsers always say where a socket is opened from.
            return "no origin" if asked.scope["type"] == "websocket" else ""
        return "" if site == host else "a foreign origin"

    def _is_token(self, given: str) -> bool:
        return hmac.compare_digest(given.encode(), (self._token or "").encode())


def _remembered(asked: HTTPConnection) -> str:
    """Returns the token that the browser remembers, or nothing."""
    return asked.cookies.get(COOKIE, "")


def _with_policy(send: Send) -> Send:
    """Returns `send` that adds what our pages may load."""

    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            policy = (b"content-security-policy", POLICY.encode())
            message["headers"] = [*message.get("headers", []), policy]
        await send(message)

    return sending
