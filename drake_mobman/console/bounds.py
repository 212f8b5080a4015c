"""How much a connection may ask of the server: in number, size, rate and patience.

Uvicorn itself waits for ever for a request that does not come, and for whoever does not
read; all that it holds for them comes off the operator's.
"""

import asyncio
import resource
from collections.abc import Iterator
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.auto import AutoWebSocketsProtocol

from drake_mobman.console.allowance import Allowance
from drake_mobman.console.messages import BURST, RATE

LARGEST_HEAD = 16384
"""Most bytes of a request, up to the end of its headers."""

LARGEST_MESSAGE = 16384
"""Most bytes of a message over a WebSocket, NiceGUI's own included."""

PATIENCE = 5.0
"""For how long a request may come in, or an answer not be read [s]."""

FRAMES = 2 * RATE, 2 * BURST
"""Frames that may come over a WebSocket each second, and at once: to take in a ping, or
a piece of a message, costs as much as a message. There is room for twice as many as a
page may say: one that says more is told so first."""

WAITING = 64
"""Connections that may wait to be accepted; accepted they are all at once."""

_TOO_MUCH = b"\x88\x02" + (1008).to_bytes(2)
"""A frame that closes a WebSocket as against our policy."""

_MOST = 128
"""Connections at once; a page of ours has up to nine."""


def most_connections() -> int:
    """Returns how many there may be, so that files for the session are left."""
    files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    if files == resource.RLIM_INFINITY:
        return _MOST
    return min(_MOST, files // 4)


class _Read(asyncio.Protocol):
    """A connection that ends where the other side does not read."""

    transport: Any
    _stalled: asyncio.TimerHandle | None = None

    def pause_writing(self) -> None:
        super().pause_writing()
        self._stop_waiting()
        loop = asyncio.get_running_loop()
        self._stalled = loop.call_later(PATIENCE, self.transport.abort)

    def resume_writing(self) -> None:
        self._stop_waiting()
        super().resume_writing()

    def connection_lost(self, exc: Exception | None) -> None:
        self._stop_waiting()
        super().connection_lost(exc)

    def _stop_waiting(self) -> None:
        if self._stalled:
            self._stalled.cancel()
            self._stalled = None


class Requests(_Read, H11Protocol):
    """A connection that brings requests, one at a time, or becomes a WebSocket.

    Where there are too many, the oldest gives way: who is let in has its answer long
    since, or a WebSocket.
    """

    _late: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Makes room for it, and waits for a request."""
        if len(self.connections) >= most_connections():
            self._make_room()
        super().connection_made(transport)  # type: ignore[arg-type]
        self.since = self.loop.time()
        self._wait()

    def data_received(self, data: bytes) -> None:
        """Takes in a part of a request."""
        super().data_received(data)
        self._wait()

    def on_response_complete(self) -> None:
        """Waits for the next request."""
        super().on_response_complete()
        self._wait()

    def connection_lost(self, exc: Exception | None) -> None:
        """Waits no more."""
        self._stop_late()
        super().connection_lost(exc)

    def _wait(self) -> None:
        """Waits for a request, however it trickles in, unless one is being answered."""
        upgraded = self.transport.get_protocol() is not self
        answers = self.cycle is not None and not self.cycle.response_complete
        if upgraded or answers:
            self._stop_late()
        elif self._late is None:
            self._late = self.loop.call_later(PATIENCE, self.transport.abort)

    def _stop_late(self) -> None:
        if self._late:
            self._late.cancel()
            self._late = None

    def _make_room(self) -> None:
        others = [one for one in self.connections if isinstance(one, Requests)]
        if others:
            oldest = min(others, key=lambda one: one.since)
            self.connections.discard(oldest)  # It ends a moment later.
            oldest.transport.abort()


_AnyWebSocket: Any = AutoWebSocketsProtocol


class WebSocket(_Read, _AnyWebSocket):
    """A WebSocket that ends where more comes than a page of ours sends."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._frames: Frames | None = None
        self._allowance = Allowance(*FRAMES)

    def data_received(self, data: bytes) -> None:
        """Takes in what comes, once it is counted: first a request, then frames."""
        if self._frames is None:
            self._frames = Frames()
        elif not all(self._allowance.takes() for _ in self._frames.begun(data)):
            self.transport.write(_TOO_MUCH)
            self.transport.close()
            self.loop.call_later(PATIENCE, self.transport.abort)
            return
        super().data_received(data)


class Frames:
    """Finds where frames begin in what comes over a WebSocket (RFC 6455, 5.2)."""

    def __init__(self) -> None:
        self._head = bytearray()  # Of the next frame, as far as it has come.
        self._left = 0  # Bytes of the last frame that are still to come.

    def begun(self, data: bytes) -> Iterator[int]:
        """Yields the size of each frame whose header ends in the next bytes."""
        i = 0
        while i < len(data):
            if self._left:
                passed = min(self._left, len(data) - i)
                self._left -= passed
                i += passed
                continue
            self._head.append(data[i])
            i += 1
            size = _size(self._head)
            if size is not None:
                self._head.clear()
                self._left = size
                yield size


def _size(head: bytearray) -> int | None:
    """Returns the size of a frame with such a header; None if that goes on."""
    if len(head) < 2:
        return None
    short, masked = head[1] & 127, head[1] >> 7
    longer = {126: 2, 127: 8}.get(short, 0)
    if len(head) < 2 + longer + 4 * masked:
        return None
    return int.from_bytes(head[2 : 2 + longer]) if longer else short
