"""What attacks share: `mobman drive` in a process of its own, an operator, strangers.

All goes over real sockets of this machine alone, and each of them has a timeout. What a
session says in its terminal is kept: no attack may make it say a word.
"""

import contextlib
import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from websockets.exceptions import ConnectionClosed, WebSocketException
from websockets.sync.client import connect

PATIENCE = 60.0
"""Of a test that waits for what is to happen at once, on a busy machine [s]."""

COMMAND = [sys.executable, "-m", "drake_mobman", "drive"]

LATCHED, READY, ARMED = range(3)
"""What a session says of its arming."""


def until(condition, what, patience=PATIENCE):
    end = time.monotonic() + patience
    while not (found := condition()):
        assert time.monotonic() < end, what
        time.sleep(0.01)
    return found


BUSY = 0.8
"""Simulated over wall time, below which a machine is too busy to be asked for more."""


class Answer:
    """What a server answers to a request in HTTP: `status` is 0 where it says nothing.

    Args:
        data: as it came over the socket.
    """

    def __init__(self, data):
        head, _, self.body = data.partition(b"\r\n\r\n")
        first, *rest = head.decode("latin-1").split("\r\n")
        self.status = int(first.split()[1]) if first else 0
        fields = [line.partition(": ")[::2] for line in rest]
        self.headers = {name.lower(): value for name, value in fields}
        self.cookies = [value for name, value in fields if name.lower() == "set-cookie"]


class Drive:
    """A `mobman drive` that runs.

    Args:
        process: that it is.
        line: that it has printed.
        errors: file that its standard error goes to.
    """

    def __init__(self, process, line, errors):
        self.process = process
        self.pid = process.pid
        self.line = line
        self._errors = errors
        self.address = re.search(r"http://\S+(?=;)", line)[0]
        port, token = re.search(r":(\d+)/(?:\?token=(.*))?$", self.address).groups()
        self.port, self.token = int(port), token
        self.own = f"127.0.0.1:{port}"

    @property
    def errors(self):
        """Returns what it has said to its terminal since the start."""
        return self._errors.read_bytes()

    @property
    def memory(self):
        """Returns how much memory it holds [MB]."""
        text = Path(f"/proc/{self.pid}/status").read_text()
        return int(re.search(r"VmRSS:\s+(\d+)", text)[1]) / 1024

    @property
    def descriptors(self):
        """Returns how many files and sockets it has open."""
        return len(os.listdir(f"/proc/{self.pid}/fd"))

    @property
    def children(self):
        """Returns the processes that it has started and that run."""
        found = []
        for task in Path(f"/proc/{self.pid}/task").glob("*/children"):
            with contextlib.suppress(OSError):  # A thread that has ended meanwhile.
                found += map(int, task.read_text().split())
        return found

    def dial(self, timeout=10.0):
        """Returns a socket to it that says nothing yet."""
        return socket.create_connection(("127.0.0.1", self.port), timeout)

    def says(self, request, timeout=10.0):
        """Returns the answer to bytes that are sent as they are."""
        with self.dial(timeout) as dialled:
            data = b""
            with contextlib.suppress(ConnectionError):
                dialled.sendall(request)
                while part := dialled.recv(65536):
                    data += part
        return Answer(data)

    def ask(self, path="/", method="GET", timeout=10.0, **headers):
        """Returns the answer to a request; `_` in a header's name is a `-`."""
        fields = {"Host": self.own, "Connection": "close"} | headers
        head = [f"{method} {path} HTTP/1.1"]
        head += [
            f"{k.replace('_', '-')}: {x}" for k, x in fields.items() if x is not None
        ]
        return self.says("\r\n".join([*head, "", ""]).encode("latin-1"), timeout)

    def connect(self, path="/drive", **options):
        """Returns a WebSocket to it, by default as a page of its own opens it."""
        timeouts = {"open_timeout": 10, "close_timeout": 1, "ping_interval": None}
        own = {"origin": f"http://{self.own}", "compression": None, "proxy": None}
        return connect(f"ws://{self.own}{path}", **timeouts | own | options)

    def refuses(self, path="/drive", **options):
        """Returns whether no WebSocket is opened."""
        try:
            with self.connect(path, **options):
                return False
        except (WebSocketException, OSError):
            return True

    def closes(self, *messages):
        """Returns the code by which it closes a page that sends such messages."""
        with self.connect() as page:
            with contextlib.suppress(ConnectionClosed):
                for message in messages:
                    page.send(message)
            return self.closed(page)

    def closed(self, page):
        """Returns the code by which it closes a page; None if it does not."""
        try:
            for _ in range(100):  # It is told how things are meanwhile.
                page.recv(timeout=PATIENCE)
        except ConnectionClosed as closed:
            return closed.rcvd.code if closed.rcvd else 1006
        return None

    def until(self, condition, what, patience=PATIENCE):
        """Waits until something is so."""
        return until(condition, what, patience)

    def rests(self, why=""):
        """Waits, as a page that watches, until the robot is at rest for such a reason.

        Of a moment after the call; returns what the page is told then.
        """
        called = time.monotonic()
        with self.connect() as page:
            while True:
                state = json.loads(page.recv(timeout=PATIENCE))
                if at_rest(state) and why in state["text"] and state["clock"] > called:
                    return state
                assert time.monotonic() < called + PATIENCE, state

    def end(self, *signals):
        """Ends it by signals, and returns its exit status."""
        for number in signals or [signal.SIGINT]:
            self.process.send_signal(number)
        return self.process.wait(4 * PATIENCE)


class Operator:
    """A page that drives: 30 times a second it says what it is told to.

    Where it is stopped it lets go, and presses anew.

    Args:
        drive: that it is a page of.
        role: that it waits for at first.
        options: of its socket.
    """

    def __init__(self, drive, role="you", **options):
        self._opens = drive.connect(**options)
        self._role = role
        self.state = {"arming": LATCHED, "role": "nobody"}
        self.command = (0.0, 0.4, 0.0)  # Round and round.
        self.holds = True
        self.closed = None  # The code by which the socket was.
        self.counts = [0, 0]  # Of all states heard, and those where it drove.
        self.sequence = 0
        self._ended = threading.Event()
        self._threads = [threading.Thread(target=x) for x in (self._hear, self._drive)]

    def __enter__(self):
        self._socket = self._opens.__enter__()
        for thread in self._threads:
            thread.start()
        if self._role:
            until(lambda: self.state["role"] == self._role, "it has the stick")
        return self

    def __exit__(self, *_):
        self._ended.set()
        self._opens.__exit__(None, None, None)
        for thread in self._threads:
            thread.join()

    def _hear(self):
        try:
            while True:
                self.state = json.loads(self._socket.recv())
                self.counts[0] += 1
                self.counts[1] += self.state["arming"] == ARMED
        except ConnectionClosed as closed:
            self.closed = closed.rcvd.code if closed.rcvd else 1006

    def _drive(self):
        while not self._ended.wait(1 / 30) and self.closed is None:
            if self.holds is not None:
                with contextlib.suppress(ConnectionClosed):
                    self.say()

    def say(self, **changes):
        """Says where stick and dead-man are; what changes is as no page says it."""
        armed = self.state["arming"] == ARMED
        held = self.holds and self.state["arming"] != LATCHED
        v_c, omega_c, v_z = self.command if held and armed else (0.0, 0.0, 0.0)
        self.sequence += 1
        said = {"sequence": self.sequence, "v_c": v_c, "omega_c": omega_c, "v_z": v_z}
        said |= {"dead_man": held, "sent": time.monotonic(), "ahead": 0.0}
        self._socket.send(json.dumps(said | changes))

    def send(self, message):
        """Says anything."""
        self._socket.send(message)

    @property
    def socket(self):
        """Returns the socket below, for what is no message at all."""
        return self._socket.socket

    def ask(self, what, **more):
        """Presses a button."""
        said = {"ask": what, "sent": time.monotonic(), "ahead": 0.0}
        self._socket.send(json.dumps(said | more))

    def until(self, condition, what, patience=PATIENCE):
        """Waits until its state is so."""
        until(lambda: condition(self.state), what, patience)

    def drives(self):
        """Waits until it drives."""
        self.until(lambda state: state["arming"] == ARMED, "it drives")

    def moves(self):
        """Waits until the robot moves."""
        self.until(lambda state: "v_b" in state and not at_rest(state), "it moves")

    def rests(self):
        """Waits until the robot is at rest."""
        self.until(at_rest, "it rests")

    @contextlib.contextmanager
    def drives_on(self):
        """Asserts that it drives on, in time, as well as just before.

        On a machine that is too busy to keep time by itself, just that it does at all.
        """
        self.drives()
        before = [0.0, 0.0, 0.0]
        while before[1] == 0.0:  # A hitch.
            began = self._marks()
            time.sleep(0.7)
            before = self._rates_since(began)
        began = self._marks()
        yield
        after = self._rates_since(began)
        if before[2] > BUSY:
            for rate, reference in zip(after, before, strict=True):
                assert rate > 0.4 * reference, (after, before)
        self.drives()

    def _marks(self):
        return time.monotonic(), *self.counts, self.state["time"]

    def _rates_since(self, began):
        """Returns each second's number of times told and driven, and simulated time."""
        wall, *others = (b - a for a, b in zip(began, self._marks(), strict=True))
        return [x / wall for x in others]


def at_rest(state):
    """Returns whether nothing moves in a state that a page is told."""
    return not any(state.get(name) for name in ("v_b", "omega_b", "base", "arm"))


@contextlib.contextmanager
def running(errors, *arguments, code=None, ready=True, **options):
    """Runs `mobman drive`; gives it once it has said where it is.

    Args:
        errors: file for what it says to its terminal.
        arguments: of the command.
        code: Python that runs it, if not in the usual way.
        ready: whether to wait until it serves, too.
        options: of the process.
    """
    command = [sys.executable, "-c", code, "drive"] if code else COMMAND
    where = () if "--port" in arguments else ("--port", "0")
    with errors.open("wb") as stderr:
        process = subprocess.Popen(
            [*command, *map(str, arguments), *where],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=stderr,
            text=True,
            env=os.environ | {"PYTHONUNBUFFERED": "1"},
            **options,
        )
    try:
        line = process.stdout.readline()
        assert "http://" in line, errors.read_text()
        drive = Drive(process, line, errors)
        if ready:
            until(lambda: drive.ask("/static/keys.js").status, "it serves")
        yield drive
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


@pytest.fixture(scope="session")
def mobman_drive(tmp_path_factory):
    """A function that runs `mobman drive`, as a context."""

    def run(*arguments, **options):
        errors = tmp_path_factory.mktemp("drive") / "errors"
        return running(errors, *arguments, **options)

    return run


@pytest.fixture(scope="session")
def shared(mobman_drive, tmp_path_factory):
    folder = tmp_path_factory.mktemp("shared")
    (folder / "runs").write_text("a file, where recordings of the page would go")
    # What has no smoother stops at once; here the base has to brake.
    arguments = ("kwon_arbitrary", "--set", "smoother=smoother")
    with mobman_drive(*arguments, cwd=folder) as drive:
        drive.ask()  # By now, all is imported that a page takes.
        yield drive
        assert drive.end() == 0
        assert drive.errors == b""


@pytest.fixture
def drive(shared):
    """A session of this machine, without a word in its terminal before and after."""
    yield shared
    assert shared.process.poll() is None
    assert shared.errors == b""


@pytest.fixture(scope="session")
def shared_afar(mobman_drive):
    with mobman_drive("kwon_arbitrary", "--host", "0") as drive:
        yield drive


@pytest.fixture
def afar(shared_afar):
    """A session that others may reach: it has a token."""
    yield shared_afar
    assert shared_afar.errors == b""


@pytest.fixture
def operator(drive):
    """Who drives the session of this machine."""
    with Operator(drive) as operator:
        yield operator


@pytest.fixture(scope="session")
def operator_of():
    """A function that returns who drives a session, as a context."""
    return Operator
