"""Floods of messages, of sockets, of requests without end: the operator drives on."""

import contextlib
import json
import os
import resource
import socket
import threading
import time

import pytest
from websockets.exceptions import WebSocketException

from drake_mobman.console.auth import MAX_SOCKETS

pytestmark = pytest.mark.realtime

PING = bytes([0x89, 0x80, 0, 0, 0, 0])
PONG = bytes([0x8A, 0x80, 0, 0, 0, 0])

FRIENDLY = {"sent": 0.0, "ahead": None, "v_c": 0.0, "omega_c": 0.0, "v_z": 0.0}


def flooded(page, data, seconds):
    """Sends as much as goes; returns whether it is cut off in time."""
    ended = time.monotonic() + seconds
    try:
        while time.monotonic() < ended:
            page.socket.sendall(data)
    except OSError:
        return True
    return False


def frame(text):
    """Returns a message as it goes over the wire."""
    data = text.encode()
    size = bytes([0x80 | len(data)])
    if len(data) > 125:
        size = b"\xfe" + len(data).to_bytes(2)
    return b"\x81" + size + bytes(4) + data


WORDS = json.dumps(FRIENDLY | {"sequence": 1, "dead_man": False})
STOP = json.dumps({"ask": "stop", "sent": 0.0, "ahead": None})


FLOODS = {"pings": PING, "pongs": PONG, "words": frame(WORDS), "noise": frame("x")}


@pytest.mark.parametrize("what", FLOODS)
def test_flood_of_who_watches_is_cut_off_and_the_operator_drives_on(
    drive, operator, what
):
    with operator.drives_on():
        ended = time.monotonic() + 1.5
        while time.monotonic() < ended:  # And comes again, and again.
            with drive.connect() as page:
                assert flooded(page, FLOODS[what] * 400, 10.0)


@pytest.mark.parametrize("what", ["pings", "words"])
def test_flood_of_the_operator_is_cut_off_and_the_robot_rests(drive, operator, what):
    operator.moves()
    assert flooded(operator, FLOODS[what] * 400, 10.0)
    operator.until(lambda _: operator.closed, "it is closed")
    drive.rests()


@contextlib.contextmanager
def opened(drive, count, said=b""):
    """Opens so many sockets that say something, as far as they are let."""
    with contextlib.ExitStack() as stack:
        sockets = []
        for _ in range(count):
            with contextlib.suppress(OSError):
                dialled = stack.enter_context(drive.dial(5.0))
                dialled.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
                dialled.sendall(said)
                sockets.append(dialled)
        yield sockets


def open_still(sockets):
    """Returns those that the other side has not closed."""
    still = []
    for one in sockets:
        one.setblocking(False)
        try:
            while one.recv(65536):
                pass
        except BlockingIOError:
            still.append(one)
        except OSError:
            pass
    return still


def upgrade(drive, path):
    """Returns the request of a page for a WebSocket."""
    return (
        f"GET {path} HTTP/1.1\r\nHost: {drive.own}\r\nOrigin: http://{drive.own}\r\n"
        "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    ).encode()


def test_hundreds_of_sockets_that_read_are_bounded(drive, operator):
    before = drive.memory
    with operator.drives_on(), contextlib.ExitStack() as stack:
        pages = []
        for _ in range(200):
            with contextlib.suppress(WebSocketException, OSError):
                pages.append(stack.enter_context(drive.connect()))
        assert len(pages) <= MAX_SOCKETS
        ended = time.monotonic() + 1.5
        while time.monotonic() < ended:
            for page in pages:
                page.recv(timeout=10)
    assert drive.memory < before + 40.0
    operator.until(lambda state: state["pages"] == 1, "they are forgotten")


def test_sockets_that_do_not_read_are_let_go(drive, operator):
    before = drive.memory, drive.descriptors
    with (
        operator.drives_on(),
        opened(drive, 50, upgrade(drive, "/drive")),
        opened(drive, 50, upgrade(drive, "/view/")),
        opened(drive, 50, f"GET / HTTP/1.1\r\nHost: {drive.own}\r\n\r\n".encode()),
    ):
        time.sleep(1.5)
        assert drive.descriptors < before[1] + 180
    assert drive.memory < before[0] + 60.0
    operator.until(lambda state: state["pages"] == 1, "they are forgotten")


def test_requests_that_do_not_end_are_given_up(drive, operator):
    whole = f"GET /static/keys.js HTTP/1.1\r\nHost: {drive.own}\r\n\r\n".encode()
    slow = whole[:-2] + b"X: "
    with (
        operator.drives_on(),
        opened(drive, 300, slow) as sockets,
        drive.dial() as second,
    ):
        # One who comes now is answered all the same; as for his next request, he is
        # waited for no longer than others.
        second.sendall(whole)
        assert second.recv(100).startswith(b"HTTP/1.1 200")
        second.sendall(slow)
        drive.until(
            lambda: len(open_still(sockets)) <= 128, "they are as many as may be"
        )
        sockets.append(second)
        began = time.monotonic()
        while sockets := open_still(sockets):
            assert time.monotonic() < began + 30.0
            for one in sockets:  # However they trickle in.
                with contextlib.suppress(OSError):
                    one.sendall(b"x")
            time.sleep(0.5)


@pytest.mark.parametrize("part", ["path", "header", "headers", "cookie", "body"])
def test_two_megabytes_are_not_taken(drive, part):
    before = drive.memory
    big = b"x" * 2_000_000
    own = f"Host: {drive.own}\r\nConnection: close\r\n".encode()
    request = {
        "path": b"GET /" + big + b" HTTP/1.1\r\n" + own,
        "header": b"GET / HTTP/1.1\r\n" + own + b"X: " + big + b"\r\n",
        "headers": b"GET / HTTP/1.1\r\n" + own + b"X: x\r\n" * 400_000,
        "cookie": b"GET / HTTP/1.1\r\n" + own + b"Cookie: a=" + big + b"\r\n",
        "body": b"GET / HTTP/1.1\r\n" + own + b"Content-Length: 2000000\r\n",
    }[part]
    for _ in range(3):
        answer = drive.says(request + b"\r\n" + (big if part == "body" else b""), 20.0)
        assert answer.status in {0, 200, 400, 429, 431}
        assert (answer.status == 200) <= (part == "body")
    assert drive.memory < before + 30.0


def limited():
    resource.setrlimit(resource.RLIMIT_NOFILE, (256, 256))


def test_all_file_descriptors_used_up_leave_enough_for_the_session(
    mobman_drive, operator_of, tmp_path
):
    with mobman_drive("kwon_arbitrary", preexec_fn=limited, cwd=tmp_path) as drive:
        with (
            operator_of(drive) as operator,
            opened(drive, 400, b"GET / HTTP/1.1\r\n"),
            opened(drive, 20, upgrade(drive, "/drive")),
        ):
            assert drive.descriptors < 200
            operator.ask("record")  # It takes files.
            operator.until(lambda state: state["recording"], "it records")
            operator.drives()
            operator.until(lambda state: state["time"] > 0.5, "it goes on")
            operator.ask("end_record")
            operator.until(lambda state: not state["recording"], "it ends")
            # Nor do they hold up its end.
            assert drive.end() == 0
        assert drive.errors == b""
    (folder,) = (tmp_path / "runs").iterdir()
    assert (folder / "metrics.json").exists()


def test_who_left_leaves_nothing_behind(drive):
    drive.ask("/static/keys.js")
    drive.until(lambda: drive.descriptors < 60, "those before have left")
    before = drive.descriptors, len(os.listdir(f"/proc/{drive.pid}/task"))

    def come_and_go():
        for _ in range(30):
            drive.refuses("/drive", origin="http://evil.example")
            drive.ask("/", Sec_Fetch_Site="cross-site")
            with drive.connect():
                pass

    threads = [threading.Thread(target=come_and_go) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    drive.until(lambda: drive.descriptors <= before[0] + 2, "their sockets are closed")
    assert len(os.listdir(f"/proc/{drive.pid}/task")) <= before[1] + 2
