"""The door: who may ask the server for anything at all.

Authentication by a token, and checks of `Host`, `Origin` and `Sec-Fetch-Site`. What is
refused is refused here, at once and without a word in the terminal.
"""

import asyncio
import contextlib
import hmac
import ipaddress
import logging
import re
from collections.abc import Iterator
from typing import NamedTuple
from urllib.parse import parse_qs, urlsplit

from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketDisconnect

from drake_mobman.console.allowance import Allowance

COOKIE = "mobman_token"
"""What the cookie's name begins with; the port follows, as a browser keeps one cookie
of a name for all ports of a machine."""

HEADERS = {
    # Nothing from elsewhere on our pages, and no page of ours inside one of elsewhere:
    # a click meant for another site must not drive a robot.
    "content-security-policy": "default-src 'self' 'unsafe-inline' 'unsafe-eval' data: "
    "blob:; frame-ancestors 'self'",
    # Nor is any of it read there, by whatever way, or told where it was opened from.
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "referrer-policy": "no-referrer",
}
"""What all answers say."""

PAGES = 2.0, 5.0
"""How often the page is opened each second, and at once: it takes 50 ms to lay out."""

SOCKETS = 24
"""Most WebSockets at once; a page has three, and takes 2 % of a processor."""

SLOW = 1.0
"""How long it takes to say that a token is wrong, one after the other [s]."""

ERRORS = 0.1, 5.0
"""How many wrong ones are told at once each second, and in all."""

_PLACES = re.compile(
    r"(?!.*(\.\.|//))/"
    r"(drive|favicon\.ico|(static|view|_nicegui_ws)/[\w./-]*|_nicegui/[\w./@-]*)?",
    re.ASCII,
)
"""All that there is: plain names, which lead nowhere else and may be printed."""

_HOST = re.compile(r"(?P<name>[\w.-]*|\[[\w:.]*\])(:\d+)?", re.ASCII)


def is_loopback(host: str) -> bool:
    """Returns whether a name or address is this machine, seen by itself alone."""
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host.lower() == "localhost"


class Refusal(NamedTuple):
    """An answer to who is not let in."""

    status: int
    why: str


class AuthMiddleware:
    """Lets in who has the token, and no other site's pages.

    Any site that is open in the same browser may send requests here. It cannot hide
    where it comes from: `Origin` and `Sec-Fetch-Site` say so. Nor can it, by a name of
    its own that leads here, hide that this is not its server: `Host` says so, where
    only this machine is let in; elsewhere it lacks the token.

    Args:
        app: behind the door.
        token: to be shown once, as `?token=`; a cookie stands for it from then on, at
            the address that it was shown from. Where it is None, only this machine is
            let in.
        port: that is served at.
    """

    def __init__(self, app: ASGIApp, token: str | None = None, port: int = 0) -> None:
        self.app = app
        self._token = token
        self._cookie = f"{COOKIE}_{port}"
        self._pages = Allowance(*PAGES)
        self._sockets = 0
        self._errors = Allowance(*ERRORS)
        self._slowly = asyncio.Lock()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Passes a request on, or refuses it."""
        if scope["type"] not in {"http", "websocket"}:
            await self.app(scope, receive, send)
            return
        asked = HTTPConnection(scope)
        answer: Refusal | Response | None = (
            _misnamed(asked, only_here=self._token is None)
            or _foreign(asked)
            or _misplaced(scope)
        )
        if not answer and self._token:
            answer = await self._unknown(asked, receive)
        answer = answer or self._too_much(scope)
        send = _with_headers(send)
        if answer:
            await _refuse(answer, scope, receive, send)
        else:
            with self._counted(scope), _told():
                await self.app(scope, receive, send)

    def is_token(self, shown: str) -> bool:
        """Returns whether this is the token; how long that takes tells nothing."""
        return _equal(shown, self._token or "")

    async def _unknown(
        self, asked: HTTPConnection, receive: Receive
    ) -> Refusal | Response | None:
        """Returns what to answer who shows a token, or is not known."""
        remembered = asked.cookies.get(self._cookie, "")
        known = _equal(remembered, self._worth(asked.scope))
        query = parse_qs(asked.scope["query_string"].decode("latin-1"))
        shown = query.get("token", [""])[0]
        if asked.scope["type"] == "http" and "token" in query:
            shows = self.is_token(shown)
            if known or shows:
                # The token leaves the address bar, and so the history; for one place,
                # as a path might lead to another site.
                welcome = RedirectResponse("/", status_code=303)
                if shows:
                    # Not strict: after a link in a mail or chat the browser would hold
                    # it back. Sockets ask for `Origin`, and no GET acts.
                    worth = self._worth(asked.scope)
                    welcome.set_cookie(
                        self._cookie, worth, httponly=True, samesite="lax"
                    )
                return welcome
        if known:
            return None
        if shown or remembered:
            await self._keep_waiting(receive)
        why = "the token is missing or wrong; open the address printed at the start"
        return Refusal(403, why)

    def _worth(self, scope: Scope) -> str:
        """Returns the cookie's value: what stands for the token at a client's address.

        Servers at other ports of this machine are told it as well; from elsewhere it is
        worth nothing, and the token does not follow from it.
        """
        address = (scope.get("client") or ("",))[0]
        return hmac.digest(
            (self._token or "").encode(), str(address).encode(), "sha256"
        ).hex()

    async def _keep_waiting(self, receive: Receive) -> None:
        """Has wrong tokens be told one by one, if there are many; to who waits."""
        if self._errors.takes():
            return
        ends = {
            asyncio.ensure_future(self._turn()),
            asyncio.ensure_future(_gone(receive)),
        }
        try:
            await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for end in ends:
                end.cancel()

    async def _turn(self) -> None:
        async with self._slowly:
            await asyncio.sleep(SLOW)

    def _too_much(self, scope: Scope) -> Refusal | None:
        """Returns what to answer where more is asked for than can be given."""
        if scope["type"] == "websocket":
            full = self._sockets >= SOCKETS
            return Refusal(503, "too many pages are open") if full else None
        if scope["path"] == "/" and not self._pages.takes():
            return Refusal(429, "the page is opened too often; again in a second")
        return None

    @contextlib.contextmanager
    def _counted(self, scope: Scope) -> Iterator[None]:
        is_socket = scope["type"] == "websocket"
        self._sockets += is_socket
        try:
            yield
        finally:
            self._sockets -= is_socket


def _misnamed(asked: HTTPConnection, only_here: bool) -> Refusal | None:
    """Returns why nobody is let in by the name that he has for this server."""
    named = _HOST.fullmatch(asked.headers.get("host", ""))
    if not named:
        return Refusal(403, "a host that is none")
    if only_here and not is_loopback(named["name"]):
        return Refusal(403, "this server is for the machine that it runs on")
    return None


def _foreign(asked: HTTPConnection) -> Refusal | None:
    """Returns why nobody is let in from where he comes, or nothing."""
    origin = asked.headers.get("origin")
    if origin is None and asked.scope["type"] == "websocket":
        # Browsers always say where a socket is opened from.
        return Refusal(403, "no origin")
    try:
        site = urlsplit(origin or "")
    except ValueError:
        return Refusal(403, "an origin that is none")
    ours = site.scheme in {"http", "https"} and site.netloc == asked.headers["host"]
    if origin is not None and not ours:
        return Refusal(403, "a foreign origin")
    from_elsewhere = asked.headers.get("sec-fetch-site", "none") not in _OWN
    if from_elsewhere and not _is_link(asked):
        return Refusal(403, "asked for by another site")
    return None


_OWN = {"same-origin", "none"}
"""Where requests come from that our pages or the address bar have made."""


def _is_link(asked: HTTPConnection) -> bool:
    """Returns whether a person has followed a link to the page."""
    how = [asked.headers.get(f"sec-fetch-{name}") for name in ("mode", "dest")]
    return asked.scope["path"] == "/" and how == ["navigate", "document"]


def _misplaced(scope: Scope) -> Refusal | None:
    """Returns what to answer who asks for what there is not."""
    if scope["type"] == "http" and scope["method"] not in {"GET", "HEAD"}:
        return Refusal(405, "nothing here takes that")
    if not _PLACES.fullmatch(scope["path"]):
        return Refusal(404, "there is nothing here")
    return None


async def _refuse(
    answer: Refusal | Response, scope: Scope, receive: Receive, send: Send
) -> None:
    if scope["type"] == "websocket":
        why = answer.why if isinstance(answer, Refusal) else ""
        await send({"type": "websocket.close", "code": 1008, "reason": why})
        return
    if isinstance(answer, Refusal):
        headers = {"refresh": "1"} if answer.status == 429 else None
        answer = PlainTextResponse(f"{answer.why}\n", answer.status, headers)
    await answer(scope, receive, send)


@contextlib.contextmanager
def _told() -> Iterator[None]:
    """Tells of what goes wrong inside, but for those who leave before it is said."""
    try:
        yield
    except Exception as error:
        if not isinstance(error, OSError | WebSocketDisconnect):
            logging.getLogger(__name__).error("a request failed", exc_info=error)
        raise


async def _gone(receive: Receive) -> None:
    """Waits until whoever asks has gone."""
    while not (await receive())["type"].endswith(".disconnect"):
        pass


def _equal(given: str, secret: str) -> bool:
    """Returns whether two are equal; see `hmac.compare_digest`."""
    return hmac.compare_digest(given.encode(errors="replace"), secret.encode())


def _with_headers(send: Send) -> Send:
    """Returns `send` that adds what all answers say."""

    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            headers.update(HEADERS)
            if "content-type" in headers:
                headers["x-content-type-options"] = "nosniff"
        await send(message)

    return sending
