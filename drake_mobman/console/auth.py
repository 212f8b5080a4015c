"""Authentication by a token, and limits of how often the page may be opened.

A refusal ends the request at once, and prints nothing to the terminal.
"""

import asyncio
import contextlib
import hmac
import logging
from collections.abc import Iterator
from urllib.parse import parse_qs

from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketDisconnect

from drake_mobman.console.request_checks import (
    Refusal,
    check_host,
    check_origin,
    check_path,
)
from drake_mobman.console.token_bucket import TokenBucket

COOKIE = "mobman_token"
"""Start of the cookie's name; the port follows, as a browser keeps one cookie of a name
for all ports of a machine."""

HEADERS = {
    # Nothing from elsewhere on our pages, and no page of ours in a frame of another
    # site: a click meant for another site must not drive a robot.
    "content-security-policy": "default-src 'self' 'unsafe-inline' 'unsafe-eval' data: "
    "blob:; frame-ancestors 'self'",
    # Other sites may not read our pages, nor see where a link was opened from.
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "referrer-policy": "no-referrer",
}
"""Headers of all answers."""

PAGE_RATE, PAGE_BURST = 2.0, 5.0
"""How often the page may be opened each second, and at once: a layout takes 50 ms."""

MAX_SOCKETS = 24
"""Most WebSockets at once; a page has three, and takes 2 % of a processor."""

FAILURE_DELAY = 1.0
"""Time between two answers to wrong tokens, if there are many [s]."""

FAILURE_RATE, FAILURE_BURST = 0.1, 5.0
"""Wrong tokens that are answered without delay each second, and at once."""


class AuthMiddleware:
    """Lets in who has the token, and no other site's pages.

    Args:
        app: application that is protected.
        token: to be sent once, as `?token=`; after that a cookie replaces it, for the
            client's address. Where it is None, only this machine is let in.
        port: at which is served.
    """

    def __init__(self, app: ASGIApp, token: str | None = None, port: int = 0) -> None:
        self.app = app
        self._token = token
        self._cookie = f"{COOKIE}_{port}"
        self._page_bucket = TokenBucket(PAGE_RATE, PAGE_BURST)
        self._failure_bucket = TokenBucket(FAILURE_RATE, FAILURE_BURST)
        self._failure_lock = asyncio.Lock()
        self._sockets = 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Passes a request on, or refuses it."""
        if scope["type"] not in {"http", "websocket"}:
            await self.app(scope, receive, send)
            return
        request = HTTPConnection(scope)
        answer: Refusal | Response | None = (
            check_host(request, local_only=self._token is None)
            or check_origin(request)
            or check_path(scope)
        )
        if not answer and self._token:
            answer = await self._authenticate(request, receive)
        answer = answer or self._check_load(scope)
        send = _with_headers(send)
        if answer:
            await _refuse(answer, scope, receive, send)
        else:
            with self._counted(scope), _logged_errors():
                await self.app(scope, receive, send)

    def is_token(self, given: str) -> bool:
        """Returns whether this is the token, in a time that does not depend on it."""
        return _equal(given, self._token or "")

    async def _authenticate(
        self, request: HTTPConnection, receive: Receive
    ) -> Refusal | Response | None:
        """Returns the answer to a request with a token, or without a valid cookie."""
        cookie = request.cookies.get(self._cookie, "")
        known = _equal(cookie, self._cookie_value(request.scope))
        query = parse_qs(request.scope["query_string"].decode("latin-1"))
        token = query.get("token", [""])[0]
        if request.scope["type"] == "http" and "token" in query:
            valid = self.is_token(token)
            if known or valid:
                # The token leaves the address bar, and so the history. Always to the
                # same page, as a path might lead to another site.
                redirect = RedirectResponse("/", status_code=303)
                if valid:
                    # Not strict: after a link in a mail or chat the browser would not
                    # send it. Sockets need an `Origin`, and no GET changes anything.
                    redirect.set_cookie(
                        self._cookie,
                        self._cookie_value(request.scope),
                        httponly=True,
                        samesite="lax",
                    )
                return redirect
        if known:
            return None
        if token or cookie:
            await self._delay_failure(receive)
        reason = "the token is missing or wrong; open the address printed at the start"
        return Refusal(403, reason)

    def _cookie_value(self, scope: Scope) -> str:
        """Returns the cookie that replaces the token for a client's address.

        Browsers send it to servers at other ports of this machine too. From another
        address it is not valid, and the token cannot be found from it.
        """
        address = (scope.get("client") or ("",))[0]
        return hmac.digest(
            (self._token or "").encode(), str(address).encode(), "sha256"
        ).hex()

    async def _delay_failure(self, receive: Receive) -> None:
        """Delays the answer to a wrong token, if there are many."""
        if self._failure_bucket.take():
            return
        ends = {
            asyncio.ensure_future(self._failure_turn()),
            asyncio.ensure_future(_disconnected(receive)),
        }
        try:
            await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for end in ends:
                end.cancel()

    async def _failure_turn(self) -> None:
        async with self._failure_lock:
            await asyncio.sleep(FAILURE_DELAY)

    def _check_load(self, scope: Scope) -> Refusal | None:
        """Returns why a request is refused for the load that it brings."""
        if scope["type"] == "websocket":
            full = self._sockets >= MAX_SOCKETS
            return Refusal(503, "too many pages are open") if full else None
        if scope["path"] == "/" and not self._page_bucket.take():
            return Refusal(429, "the page is opened too often; try again in a second")
        return None

    @contextlib.contextmanager
    def _counted(self, scope: Scope) -> Iterator[None]:
        is_socket = scope["type"] == "websocket"
        self._sockets += is_socket
        try:
            yield
        finally:
            self._sockets -= is_socket


async def _refuse(
    answer: Refusal | Response, scope: Scope, receive: Receive, send: Send
) -> None:
    if scope["type"] == "websocket":
        reason = answer.reason if isinstance(answer, Refusal) else ""
        await send({"type": "websocket.close", "code": 1008, "reason": reason})
        return
    if isinstance(answer, Refusal):
        headers = {"refresh": "1"} if answer.status == 429 else None
        answer = PlainTextResponse(f"{answer.reason}\n", answer.status, headers)
    await answer(scope, receive, send)


@contextlib.contextmanager
def _logged_errors() -> Iterator[None]:
    """Logs errors of the application, but not clients that leave early."""
    try:
        yield
    except Exception as error:
        if not isinstance(error, OSError | WebSocketDisconnect):
            logging.getLogger(__name__).error("a request failed", exc_info=error)
        raise


async def _disconnected(receive: Receive) -> None:
    """Waits until the client has left."""
    while not (await receive())["type"].endswith(".disconnect"):
        pass


def _equal(given: str, secret: str) -> bool:
    """Returns whether two are equal; see `hmac.compare_digest`."""
    return hmac.compare_digest(given.encode(errors="replace"), secret.encode())


def _with_headers(send: Send) -> Send:
    """Returns `send` that adds the headers of all answers."""

    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            headers.update(HEADERS)
            if "content-type" in headers:
                headers["x-content-type-options"] = "nosniff"
        await send(message)

    return sending
