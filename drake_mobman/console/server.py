"""The console's server: the page, the socket that it drives by, and the picture in it.

All that acts comes by one socket of ours, where origin, size, shape and rate are
checked; NiceGUI lays out the page, and hears nothing.
"""

import asyncio
import json
import math
import secrets
import socket
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any

import uvicorn
from fastapi import FastAPI, Response, WebSocket, WebSocketDisconnect
from nicegui import app as nicegui_app
from nicegui import ui
from starlette.responses import HTMLResponse
from starlette.staticfiles import StaticFiles

from drake_mobman.console import bounds
from drake_mobman.console.auth import AuthMiddleware, is_loopback
from drake_mobman.console.deaf import Deaf
from drake_mobman.console.messages import MessageError
from drake_mobman.console.operator_arbiter import OperatorArbiter, Page
from drake_mobman.console.page import add_page
from drake_mobman.console.session import LiveSession
from drake_mobman.console.state import state
from drake_mobman.console.view import (
    DRAGS,
    PERIOD,
    Frame,
    Picture,
    picture_page,
)
from drake_mobman.terminal import visible

STATIC = Path(__file__).parent / "static"

TELL = 1 / 20
"""Between two times that a page is told the session's state [s]."""

_BREATH = 1.0
"""After what time a page is told of a picture in which nothing moves [s]."""

_GONE = (RuntimeError, WebSocketDisconnect)
"""What it comes to when one writes to a browser that has gone."""


class Server:
    """Serves the console of a session; one in a process.

    Args:
        name: of what is driven.
        session: that is driven.
        place: where to serve; see `listening`. Where that is seen beyond this machine,
            a token is asked for.
    """

    def __init__(self, name: str, session: LiveSession, place: socket.socket) -> None:
        self._place = place
        self._host, self.port, *_ = place.getsockname()
        self.token = token_for(place)
        self.desk = OperatorArbiter(session, lambda: _new_folder(name))
        self._picture = Picture(session.scenario, session.draggable if DRAGS else ())
        self._drawn = picture_page(self._picture)
        app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
        self._session = session
        self._p_BS = session.scenario.robot.arm().p_BS
        app.add_api_websocket_route("/drive", self._drive)
        app.add_api_route("/view/", self._view)
        app.add_api_websocket_route("/view/", self._stream_view)
        app.mount("/static", _Fresh(directory=STATIC))
        add_page(name, session)
        ui.run_with(
            app,
            title=f"{visible(name)} · mobman drive",
            favicon="🦾",
            dark=True,
            show_welcome_message=False,
        )
        # In place of what `run_with` has put there, which walks through all of Python's
        # objects: Drake, at work in another thread, does not survive that.
        app.router.lifespan_context = self._open
        config = uvicorn.Config(
            AuthMiddleware(Deaf(app), self.token, self.port),
            http=bounds.Requests,
            h11_max_incomplete_event_size=bounds.LARGEST_HEAD,
            ws=bounds.WebSocket,
            ws_max_size=bounds.LARGEST_MESSAGE,
            ws_per_message_deflate=False,
            backlog=bounds.WAITING,
            log_level="critical",  # What strangers get wrong is nothing to tell of.
            timeout_graceful_shutdown=1,
        )
        self._uvicorn = uvicorn.Server(config)

    @property
    def address(self) -> str:
        """Returns what to open in a browser."""
        everywhere = self._host in {"0.0.0.0", "::"}
        host = _outgoing(self._place.family) if everywhere else self._host
        host = f"[{host}]" if ":" in host else host
        address = f"http://{host}:{self.port}/"
        return f"{address}?token={self.token}" if self.token else address

    @property
    def serves(self) -> bool:
        """Returns whether it answers by now."""
        return self._uvicorn.started

    def run(self) -> None:
        """Serves until `close` or, in the main thread, Ctrl-C or SIGTERM."""
        self._uvicorn.run(sockets=[self._place])

    def close(self) -> None:
        """Has `run` return."""
        self._uvicorn.should_exit = True

    @asynccontextmanager
    async def _open(self, _app: FastAPI) -> AsyncIterator[None]:
        async with nicegui_app.router.lifespan_context(nicegui_app):
            yield

    # The socket that pages drive by.

    async def _drive(self, browser: WebSocket) -> None:
        """Serves a page from when it opens until it is gone, or says what none does."""
        await browser.accept()
        page = self.desk.join()
        telling = asyncio.create_task(self._tell(browser, page))
        wrong = None
        try:
            while (said := await browser.receive())["type"] == "websocket.receive":
                self.desk.hear(page, said.get("text") or said.get("bytes") or "")
        except MessageError as error:
            wrong = error
        finally:
            self.desk.leave(page)
            telling.cancel()
        if wrong:
            with suppress(*_GONE):
                await browser.close(wrong.code, str(wrong))

    async def _tell(self, browser: WebSocket, page: Page) -> None:
        """Tells a page how things are; one that does not listen holds up nobody."""
        with suppress(*_GONE):
            while True:
                said = state(self._session.snapshot(), self._p_BS)
                said |= {
                    "role": self.desk.role(page),
                    "pages": len(self.desk.pages),
                    "asked": self.desk.asked,
                    "notice": page.notice,
                    "clock": time.monotonic(),
                }
                await browser.send_text(json.dumps(said))
                await asyncio.sleep(TELL)

    # The picture. Its page is Meshcat's, but nothing of Meshcat is served.

    async def _view(self) -> Response:
        """Serves the page of the picture."""
        return HTMLResponse(self._drawn, headers={"cache-control": "no-cache"})

    async def _stream_view(self, browser: WebSocket) -> None:
        """Tells a browser what moves in the picture, and listens to nothing."""
        await browser.accept()
        showing = asyncio.create_task(self._show(browser))
        try:
            await _drained(browser)
        finally:
            showing.cancel()

    async def _show(self, browser: WebSocket) -> None:
        """Tells what has moved; one that is slow to listen is told less often."""
        shown, breath = Frame(), -math.inf
        with suppress(*_GONE):
            while True:
                now = time.monotonic()
                frame = self._picture.at(self._session.snapshot())
                if frame is not shown or now - breath > _BREATH:
                    await browser.send_text(json.dumps(frame.message(shown)))
                    shown, breath = frame, now
                await asyncio.sleep(PERIOD)


class _Fresh(StaticFiles):
    """Files that a browser asks for anew each time, as they change with our version."""

    def file_response(self, *args: Any, **kwargs: Any) -> Response:
        response = super().file_response(*args, **kwargs)
        response.headers["cache-control"] = "no-cache"
        return response


async def _drained(browser: WebSocket) -> None:
    """Waits until a browser has gone; what it says until then is not listened to."""
    while (await browser.receive())["type"] != "websocket.disconnect":
        pass


def listening(host: str = "127.0.0.1", port: int = 8080) -> socket.socket:
    """Returns a socket to serve at.

    Args:
        host: name or address of this machine.
        port: 0 for any that is free.

    Raises:
        OSError: where it cannot be had.
    """
    found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    family, _, _, _, address = found[0]
    place = socket.socket(family, socket.SOCK_STREAM)
    try:
        place.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        place.bind(address)
        place.listen()  # Of two who may bind, only one may listen.
    except OSError:
        place.close()
        raise
    return place


def token_for(place: socket.socket) -> str | None:
    """Returns a new token, if others than this machine may come to a place."""
    host = place.getsockname()[0]
    return None if is_loopback(host) else secrets.token_urlsafe(16)


def _outgoing(family: int) -> str:
    """Returns this machine's address in its network, or its name where it has none.

    Phones often find nothing by the name.
    """
    beyond = "2001:db8::1" if family == socket.AF_INET6 else "203.0.113.1"
    with socket.socket(family, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((beyond, 9))  # By UDP: nothing is sent.
        except OSError:
            return socket.gethostname()
        address: str = probe.getsockname()[0]
    return address


def _new_folder(name: str) -> Path:
    """Returns where a recording goes that the page has asked for."""
    return Path("runs") / f"{name}-{time.strftime('%Y%m%d-%H%M%S')}"
