"""Floods: of messages, of sockets, of requests that never end. The operator drives on."""

import contextlib
import json
import os
import resource
import socket
import threading
import time

import pytest
from websockets.exceptions import ConnectionClosed

PING = bytes([0x89, 0x80, 0, 0, 0, 0])

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


@pytest.mark.parametrize(
    "what", [PING, frame(WORDS), frame("x"), b"\x8a\x80" + bytes(4)]
)
def test_flood_of_who_watches_is_cut_off_and_the_operator_drives_on(
    drive, operator, what
):
    with operator.drives_on():
        ended = time.monotonic() + 3.0
        while time.monotonic() < ended:  # And comes again, and again.
            with drive.connect() as page:
                assert flooded(page, what * 400, 10.0)
    assert operator.state["ratio"] > 0.5


@pytest.mark.parametrize("what", [PING, frame(WORDS)])
def test_flood_of_the_operator_is_cut_off_and_the_robot_rests(drive, operator, what):
    operator.drives()
    assert flooded(operator, what * 400, 10.0)
    operator.until(lambda _: operator.closed, "it is closed")
    with drive.connect() as page:
        ended = time.monotonic() + 10.0
        while (state := json.loads(page.recv(timeout=10)))["v_b"] or state["omega_b"]:
            assert time.monotonic() < ended
        assert state["ratio"] > 0.5


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
    """Returns how many of them the other side has not closed."""
    still = 0
    for one in sockets:
        one.setblocking(False)
        try:
            while data := one.recv(65536):
                pass
            still += data != b""
        except BlockingIOError:
            still += 1
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
            with contextlib.suppress(ConnectionClosed, OSError, Exception):
                pages.append(stack.enter_context(drive.connect()))
        assert len(pages) < 64
        ended = time.monotonic() + 3.0
        while time.monotonic() < ended:
            for page in pages:
                page.recv(timeout=10)
    assert drive.memory < before + 40.0
    operator.until(lambda state: state["pages"] == 1, "they are forgotten")


@pytest.mark.parametrize("path", ["/drive", "/view/"])
def test_sockets_that_do_not_read_are_let_go(drive, operator, path):
    before = drive.memory, drive.descriptors
    with operator.drives_on(), opened(drive, 100, upgrade(drive, path)):
        time.sleep(3.0)
        assert drive.descriptors < before[1] + 180
    assert drive.memory < before[0] + 40.0
    operator.until(lambda state: state["pages"] == 1, "they are forgotten")


def test_requests_that_do_not_end_are_given_up(drive, operator):
    slow = f"GET / HTTP/1.1\r\nHost: {drive.own}\r\nX: ".encode()
    with operator.drives_on(), opened(drive, 300, slow) as sockets:
        ended = time.monotonic() + 5.0
        while open_still(sockets) > 128:
            assert time.monotonic() < ended
            time.sleep(0.1)
        # One who comes now is answered all the same.
        assert drive.ask("/static/keys.js").status == 200
        ended = time.monotonic() + 8.0
        while open_still(sockets):
            assert time.monotonic() < ended
            for one in sockets:  # However they trickle in.
                with contextlib.suppress(OSError):
                    one.sendall(b"x")
            time.sleep(0.5)


def test_request_after_the_first_is_waited_for_no_longer(drive):
    with drive.dial() as dialled:
        whole = f"GET /static/keys.js HTTP/1.1\r\nHost: {drive.own}\r\n\r\n".encode()
        dialled.sendall(whole)
        assert dialled.recv(100).startswith(b"HTTP/1.1 200")
        ended = time.monotonic() + 8.0
        with contextlib.suppress(OSError):
            while open_still([dialled]):
                assert time.monotonic() < ended
                dialled.sendall(whole[:1])
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
    for _ in range(5):
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
        with operator_of(drive) as operator:
            with opened(drive, 400, b"GET / HTTP/1.1\r\n"):
                assert drive.descriptors < 200
                operator.ask("record")  # It takes files.
                operator.until(lambda state: state["recording"], "it records")
                with operator.drives_on():
                    time.sleep(1.0)
                operator.ask("end_record")
                operator.until(lambda state: not state["recording"], "it ends")
        assert drive.end() == 0
        assert drive.errors == b""
    (folder,) = (tmp_path / "runs").iterdir()
    assert (folder / "metrics.json").exists()


def test_threads_and_tasks_of_those_who_left_are_gone(drive):
    """What strangers leave behind is nothing: no file, no thread, no memory."""
    drive.ask("/static/keys.js")
    time.sleep(0.5)
    before = drive.descriptors, len(os.listdir(f"/proc/{drive.pid}/task"))

    def come_and_go():
        for _ in range(50):
            drive.refuses("/drive", origin="http://evil.example")
            drive.ask("/", Sec_Fetch_Site="cross-site")
            with drive.connect():
                pass

    threads = [threading.Thread(target=come_and_go) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    ended = time.monotonic() + 10.0
    while drive.descriptors > before[0] + 2:
        assert time.monotonic() < ended
        time.sleep(0.1)
    assert len(os.listdir(f"/proc/{drive.pid}/task")) <= before[1] + 2
