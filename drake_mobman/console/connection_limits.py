"""Limits of each connection to the server: number, size, rate and time.

Uvicorn itself waits without limit for a request that does not come, and for a client
that does not read. What it keeps for them takes time and memory from the operator.
"""

import asyncio
import resource
from collections.abc import Iterator
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.auto import AutoWebSocketsProtocol

from drake_mobman.console.messages import BURST, RATE
from drake_mobman.console.token_bucket import TokenBucket

MAX_HEAD = 16384
"""Most bytes of a request, up to the end of its headers."""

MAX_MESSAGE = 16384
"""Most bytes of a message over a WebSocket, NiceGUI's own included."""

TIMEOUT = 5.0
"""Longest that a request may take to arrive, or an answer to be read [s]."""

FRAME_RATE, FRAME_BURST = 2 * RATE, 2 * BURST
"""Most WebSocket frames each second, and at once: each, even a ping, costs as
much as a message. Twice the limit of messages, so that a page that sends too many
messages gets that error first."""

BACKLOG = 64
"""Connections that may wait to be accepted; the server accepts them all at once."""

_POLICY_VIOLATION = b"\x88\x02" + (1008).to_bytes(2)
"""A frame that closes a WebSocket with the code "policy violation"."""

_MAX_CONNECTIONS = 128
"""Connections at once; a page of ours has up to nine."""


def max_connections() -> int:
    """Returns how many there may be, so that the session can still open files."""
    files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    if files == resource.RLIM_INFINITY:
        return _MAX_CONNECTIONS
    return min(_MAX_CONNECTIONS, files // 4)


class _WriteTimeout(asyncio.Protocol):
    """A connection that is closed if the other side does not read."""

    transport: Any
    _write_timer: asyncio.TimerHandle | None = None

    def pause_writing(self) -> None:
        super().pause_writing()
        self._stop_write_timer()
        loop = asyncio.get_running_loop()
        self._write_timer = loop.call_later(TIMEOUT, self.transport.abort)

    def resume_writing(self) -> None:
        self._stop_write_timer()
        super().resume_writing()

    def connection_lost(self, exc: Exception | None) -> None:
        self._stop_write_timer()
        super().connection_lost(exc)

    def _stop_write_timer(self) -> None:
        if self._write_timer:
            self._write_timer.cancel()
            self._write_timer = None


class LimitedHttp(_WriteTimeout, H11Protocol):
    """A connection that brings requests, one at a time, or becomes a WebSocket.

    If there are too many, the oldest is closed: a legitimate client has long received
    its answer, or has a WebSocket.
    """

    _read_timer: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Makes room for the connection, and waits for a request."""
        if len(self.connections) >= max_connections():
            self._close_oldest()
        super().connection_made(transport)  # type: ignore[arg-type]
        self.opened_at = self.loop.time()
        self._wait_for_request()

    def data_received(self, data: bytes) -> None:
        """Takes in a part of a request."""
        super().data_received(data)
        self._wait_for_request()

    def on_response_complete(self) -> None:
        """Waits for the next request."""
        super().on_response_complete()
        self._wait_for_request()

    def connection_lost(self, exc: Exception | None) -> None:
        """Stops the timers."""
        self._stop_read_timer()
        super().connection_lost(exc)

    def _wait_for_request(self) -> None:
        """Starts the timer once for a whole request, unless one is being answered."""
        upgraded = self.transport.get_protocol() is not self
        answering = self.cycle is not None and not self.cycle.response_complete
        if upgraded or answering:
            self._stop_read_timer()
        elif self._read_timer is None:
            self._read_timer = self.loop.call_later(TIMEOUT, self.transport.abort)

    def _stop_read_timer(self) -> None:
        if self._read_timer:
            self._read_timer.cancel()
            self._read_timer = None

    def _close_oldest(self) -> None:
        others = [one for one in self.connections if isinstance(one, LimitedHttp)]
        if others:
            oldest = min(others, key=lambda one: one.opened_at)
            self.connections.discard(oldest)  # It closes a moment later.
            oldest.transport.abort()


_AnyWebSocket: Any = AutoWebSocketsProtocol


class LimitedWebSocket(_WriteTimeout, _AnyWebSocket):
    """A WebSocket that is closed if it brings more frames than a page of ours sends."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._frames: FrameCounter | None = None
        self._bucket = TokenBucket(FRAME_RATE, FRAME_BURST)

    def data_received(self, data: bytes) -> None:
        """Counts what arrives, then takes it in: first a request, then frames."""
        if self._frames is None:
            self._frames = FrameCounter()
        elif not all(self._bucket.take() for _ in self._frames.sizes(data)):
            self.transport.write(_POLICY_VIOLATION)
            self.transport.close()
            self.loop.call_later(TIMEOUT, self.transport.abort)
            return
        super().data_received(data)


class FrameCounter:
    """Finds the frames in the bytes of a WebSocket (RFC 6455, section 5.2)."""

    def __init__(self) -> None:
        self._header = bytearray()  # Of the next frame, as far as it has arrived.
        self._payload_left = 0  # Bytes of the last frame that are still to arrive.

    def sizes(self, data: bytes) -> Iterator[int]:
        """Yields the size of each frame whose header ends in the next bytes."""
        i = 0
        while i < len(data):
            if self._payload_left:
                skipped = min(self._payload_left, len(data) - i)
                self._payload_left -= skipped
                i += skipped
                continue
            self._header.append(data[i])
            i += 1
            size = _payload_size(self._header)
            if size is not None:
                self._header.clear()
                self._payload_left = size
                yield size


def _payload_size(header: bytearray) -> int | None:
    """Returns the size of a frame with this header; None if it is not complete."""
    if len(header) < 2:
        return None
    short, masked = header[1] & 127, header[1] >> 7
    extended = {126: 2, 127: 8}.get(short, 0)
    if len(header) < 2 + extended + 4 * masked:
        return None
    return int.from_bytes(header[2 : 2 + extended]) if extended else short
