"""The console's server: the page, its socket for driving, and the picture in it.

All that moves the robot comes through one WebSocket, where origin, size, shape and rate
are checked. NiceGUI lays out the page, and receives nothing from it.
"""

import asyncio
import json
import math
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

from drake_mobman.console import connection_limits
from drake_mobman.console.addresses import own_address, token_for
from drake_mobman.console.auth import AuthMiddleware
from drake_mobman.console.frame import Frame
from drake_mobman.console.messages import MessageError
from drake_mobman.console.nicegui_filter import NiceguiFilter
from drake_mobman.console.operator_arbiter import OperatorArbiter, Page
from drake_mobman.console.page import add_page
from drake_mobman.console.session import LiveSession
from drake_mobman.console.state import state
from drake_mobman.console.view import CAN_DRAG, FRAME_PERIOD, Picture, picture_page
from drake_mobman.terminal import visible

STATIC = Path(__file__).parent / "static"

_STATE_PERIOD = 1 / 20
"""Time between two states that are sent to a page [s]."""

_HEARTBEAT_PERIOD = 1.0
"""Time after which an empty frame is sent, if nothing moves [s]."""

_DISCONNECTED = (RuntimeError, WebSocketDisconnect)
"""What sending to a browser raises when it has left."""


class Server:
    """Serves the console of a session; one in a process.

    Args:
        name: of the scenario.
        session: that is driven.
        listener: where to serve; see `listening`. If other machines can reach it, a
            token is needed.
    """

    def __init__(
        self, name: str, session: LiveSession, listener: socket.socket
    ) -> None:
        self._listener = listener
        self._host, self.port, *_ = listener.getsockname()
        self.token = token_for(listener)
        self.arbiter = OperatorArbiter(session, lambda: _new_folder(name))
        draggable = session.draggable if CAN_DRAG else ()
        self._picture = Picture(session.scenario, session.signals, draggable)
        self._picture_page = picture_page(self._picture)
        self._session = session
        self._p_BS = session.scenario.robot.arm().p_BS
        app = self._app(name)
        config = uvicorn.Config(
            AuthMiddleware(NiceguiFilter(app), self.token, self.port),
            http=connection_limits.LimitedHttp,
            h11_max_incomplete_event_size=connection_limits.MAX_HEAD,
            ws=connection_limits.LimitedWebSocket,
            ws_max_size=connection_limits.MAX_MESSAGE,
            ws_per_message_deflate=False,
            backlog=connection_limits.BACKLOG,
            log_level="critical",  # Errors of strangers are not printed.
            timeout_graceful_shutdown=1,
        )
        self._uvicorn = uvicorn.Server(config)

    def _app(self, name: str) -> FastAPI:
        """Returns the application with all its routes."""
        app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
        app.add_api_websocket_route("/drive", self._drive)
        app.add_api_route("/view/", self._view)
        app.add_api_websocket_route("/view/", self._stream_view)
        app.mount("/static", _UncachedFiles(directory=STATIC))
        add_page(name, self._session)
        ui.run_with(
            app,
            title=f"{visible(name)} · mobman drive",
            favicon="🦾",
            dark=True,
            show_welcome_message=False,
        )
        # This replaces what `run_with` has set, which walks through all of Python's
        # objects: Drake, at work in another thread, does not survive that.
        app.router.lifespan_context = self._lifespan
        return app

    @property
    def address(self) -> str:
        """Returns what to open in a browser."""
        everywhere = self._host in {"0.0.0.0", "::"}
        host = own_address(self._listener.family) if everywhere else self._host
        host = f"[{host}]" if ":" in host else host
        address = f"http://{host}:{self.port}/"
        return f"{address}?token={self.token}" if self.token else address

    @property
    def started(self) -> bool:
        """Returns whether it answers requests by now."""
        return self._uvicorn.started

    def run(self) -> None:
        """Serves until `close` or, in the main thread, Ctrl-C or SIGTERM."""
        self._uvicorn.run(sockets=[self._listener])

    def close(self) -> None:
        """Has `run` return."""
        self._uvicorn.should_exit = True

    @asynccontextmanager
    async def _lifespan(self, _app: FastAPI) -> AsyncIterator[None]:
        async with nicegui_app.router.lifespan_context(nicegui_app):
            yield

    # The WebSocket for driving.

    async def _drive(self, browser: WebSocket) -> None:
        """Serves a page until it closes, or sends what no page of ours does."""
        await browser.accept()
        page = self.arbiter.join()
        sending = asyncio.create_task(self._send_states(browser, page))
        wrong = None
        try:
            while (event := await browser.receive())["type"] == "websocket.receive":
                message = event.get("text") or event.get("bytes") or ""
                self.arbiter.receive(page, message)
        except MessageError as error:
            wrong = error
        finally:
            self.arbiter.leave(page)
            sending.cancel()
        if wrong:
            with suppress(*_DISCONNECTED):
                await browser.close(wrong.code, str(wrong))

    async def _send_states(self, browser: WebSocket, page: Page) -> None:
        """Sends states to a page; a page that is slow to read delays nobody else."""
        with suppress(*_DISCONNECTED):
            while True:
                message = state(self._session.snapshot(), self._p_BS)
                message |= {
                    "role": self.arbiter.role(page),
                    "pages": len(self.arbiter.pages),
                    "asked": self.arbiter.handover_requested,
                    "notice": page.notice,
                    "clock": time.monotonic(),
                }
                await browser.send_text(json.dumps(message))
                await asyncio.sleep(_STATE_PERIOD)

    # The picture. Its page is Meshcat's, but no Meshcat is served.

    async def _view(self) -> Response:
        """Serves the page of the picture."""
        return HTMLResponse(self._picture_page, headers={"cache-control": "no-cache"})

    async def _stream_view(self, browser: WebSocket) -> None:
        """Sends what moves in the picture, and ignores what the browser sends."""
        await browser.accept()
        sending = asyncio.create_task(self._send_frames(browser))
        try:
            while (await browser.receive())["type"] != "websocket.disconnect":
                pass
        finally:
            sending.cancel()

    async def _send_frames(self, browser: WebSocket) -> None:
        """Sends what has moved; a browser that is slow to read gets fewer frames."""
        shown, last = Frame(), -math.inf
        with suppress(*_DISCONNECTED):
            while True:
                now = time.monotonic()
                frame = self._picture.at(self._session.snapshot())
                if frame is not shown or now - last > _HEARTBEAT_PERIOD:
                    await browser.send_text(json.dumps(frame.message(shown)))
                    shown, last = frame, now
                await asyncio.sleep(FRAME_PERIOD)


class _UncachedFiles(StaticFiles):
    """Files that a browser loads anew each time, as they change with our version."""

    def file_response(self, *args: Any, **kwargs: Any) -> Response:
        response = super().file_response(*args, **kwargs)
        response.headers["cache-control"] = "no-cache"
        return response


def _new_folder(name: str) -> Path:
    """Returns the folder of a recording that is started on the page."""
    return Path("runs") / f"{name}-{time.strftime('%Y%m%d-%H%M%S')}"
