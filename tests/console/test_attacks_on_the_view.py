"""Attacks on the picture and on what is seen and dragged there, each on a real server.

All is on this machine: any web site that is open in a browser here can do as much.
"""

import json
import os
import re
import shutil
import signal
import struct
import subprocess
import sys
import threading
import time
import urllib.request
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from drake_mobman.console.addresses import free_address, listening
from drake_mobman.console.meshcat_panel import HOLD, RESET, STOP
from drake_mobman.console.panel_process import PanelProcess
from drake_mobman.console.session import LiveSession
from drake_mobman.meshcat import offline_meshcat, random_loopback_host
from drake_mobman.scenario import load_scenario
from drake_mobman.teleop.gate import Arming, GateStatus

pytestmark = pytest.mark.realtime

PATIENCE = 30.0
"""Of a test that waits for what is to happen at once [s]."""

EVIL = "http://evil.example"
"""Origin of another site's page."""


def until(condition, what):
    end = time.monotonic() + PATIENCE
    while not (found := condition()):
        assert time.monotonic() < end, what
        time.sleep(0.02)
    return found


def packed(value):
    """Returns MessagePack, as Meshcat's page sends it, of a small value."""
    match value:
        case bool():
            return b"\xc3" if value else b"\xc2"
        case float():
            return b"\xcb" + struct.pack(">d", value)
        case str():
            return bytes([0xD9, len(value)]) + value.encode()
        case list():
            return struct.pack(">BH", 0xDC, len(value)) + b"".join(map(packed, value))
        case dict():
            content = (packed(x) for pair in value.items() for x in pair)
            return bytes([0x80 + len(value)]) + b"".join(content)


def camera_pose(numbers):
    return packed(
        {"type": "camera_pose", "camera_pose": numbers, "is_perspective": True}
    )


CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

FLAGS = [
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update"),
    # The 3D view is drawn in software.
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
]

DEADLY = {
    "empty": b"",
    "zeros": camera_pose([0.0] * 16),
    "malformed": b"\xc1\xff\xdf\xff\xff\xff\xff",
    "oversized": b"\x00" * 300_000,
    "text": "x" * 1000,
}
"""Frames that end Meshcat's thread, or might."""


# --- What can be reached at all ------------------------------------------------------


def family_of(pid):
    """Returns a process and all below it."""
    table = subprocess.run(
        ["ps", "-eo", "pid=,ppid="], capture_output=True, text=True, check=True
    )
    rows = [tuple(map(int, line.split())) for line in table.stdout.splitlines()]
    found = {pid}
    for _ in range(5):  # So deep, at most.
        found |= {child for child, parent in rows if parent in found}
    return found


def ports_of(pid):
    """Returns where a process and all below it listen: pairs of address and port."""
    sockets = set()
    for member in family_of(pid):
        with suppress(OSError):
            for file in Path(f"/proc/{member}/fd").iterdir():
                with suppress(OSError):
                    sockets.add(os.readlink(file))
    found = set()
    for line in Path("/proc/net/tcp").read_text().splitlines()[1:]:
        _, local, _, state, *_, inode = line.split()[:10]
        if state == "0A" and f"socket:[{inode}]" in sockets:
            address, port = local.split(":")
            host = ".".join(str(x) for x in bytes.fromhex(address)[::-1])
            found.add((host, int(port, 16)))
    return found


@contextmanager
def mobman_drive(*arguments):
    """Runs `mobman drive`; gives the process and the address it prints."""
    process = subprocess.Popen(
        [sys.executable, "-u", "-m", "drake_mobman", "drive", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        line = process.stdout.readline()
        assert "http://" in line, process.communicate(timeout=PATIENCE)
        yield process, re.search(r"http://\S+(?=;)", line)[0]
    finally:
        process.kill()
        process.communicate(timeout=PATIENCE)


def answers(address):
    with suppress(OSError), urllib.request.urlopen(address, timeout=5) as answer:
        return answer.status == 200


def shoot(url, frame, origin=EVIL):
    """Sends a frame to a socket, and gives it time to do what it does."""
    with (
        suppress(OSError, ConnectionClosed, InvalidStatus, TimeoutError),
        connect(url, origin=origin, open_timeout=5, close_timeout=1) as socket,
    ):
        socket.recv(timeout=5)
        socket.send(frame)
        with suppress(ConnectionClosed, TimeoutError):
            while True:
                socket.recv(timeout=0.1)


needs_proc = pytest.mark.skipif(
    not Path("/proc/net/tcp").exists(), reason="needs Linux's /proc"
)


@needs_proc
def test_picture_is_reached_by_nobody_and_no_frame_ends_the_session():
    with mobman_drive("kwon_1", "--port", "0") as (process, address):
        until(lambda: answers(address), "it serves")
        own = address.removeprefix("http://").rstrip("/")
        host, port = own.split(":")
        assert ports_of(process.pid) == {(host, int(port))}
        for place in ports_of(process.pid):  # Whatever they are.
            for frame in DEADLY.values():
                shoot("ws://{}:{}/".format(*place), frame)
        for frame in DEADLY.values():
            shoot(f"ws://{own}/view/", frame, origin=address.rstrip("/"))
        assert answers(address)
        drive = connect(f"ws://{own}/drive", origin=address.rstrip("/"), open_timeout=5)
        with drive as socket:
            before = json.loads(socket.recv(timeout=5))["time"]
            end = time.monotonic() + PATIENCE
            while json.loads(socket.recv(timeout=5))["time"] < before + 0.3:
                assert time.monotonic() < end, "the session goes on"
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=PATIENCE)
        assert errors == ""


@needs_proc
def test_meshcat_that_only_draws_is_reached_by_nobody():
    before = ports_of(os.getpid())
    for _ in range(3):
        meshcat = offline_meshcat()
        assert ports_of(os.getpid()) == before
        url = meshcat.web_url()
        with pytest.raises(OSError, match="refused"):
            urllib.request.urlopen(url, timeout=5)
        meshcat.SetProperty("/Grid", "visible", False)
        assert "meshcat-pane" in meshcat.StaticHtml()
        del meshcat


def test_addresses_are_of_this_machine_alone_and_not_guessed():
    hosts = [random_loopback_host() for _ in range(50)]
    assert all(re.fullmatch(r"127(\.\d+){3}", host) for host in hosts)
    if sys.platform == "linux":
        assert len(set(hosts)) == 50
        assert free_address().host not in {"127.0.0.1", *hosts}


# --- By the console's own port -------------------------------------------------------


@pytest.fixture(scope="module")
def own():
    """Host and port of a console."""
    with mobman_drive("kwon_arbitrary", "--port", "0") as (_, address):
        until(lambda: answers(address), "it serves")
        yield address.removeprefix("http://").rstrip("/")


@contextmanager
def wired(own, path, origin=None, **options):
    """Gives a socket to a console, as one of its pages opens it."""
    options = {"open_timeout": 5, "close_timeout": 1} | options
    with connect(f"ws://{own}{path}", origin=origin or f"http://{own}", **options) as x:
        yield x


def signal_of(session, name):
    return np.array(session.snapshot().signals[name])


def rests(session):
    velocity = [signal_of(session, "base_velocity"), signal_of(session, "arm_velocity")]
    return not np.any(np.hstack(velocity))


class Operator:
    """Drives by a socket to the session, as the console's page does."""

    def __init__(self, socket):
        self.socket = socket
        self.sequence = 0
        self.state = json.loads(socket.recv(timeout=PATIENCE))

    def hears(self):
        """Takes in all that the session has said of itself; returns the latest."""
        with suppress(TimeoutError):
            while True:
                self.state = json.loads(self.socket.recv(timeout=0.001))
        return self.state

    def says(self, v_c=0.0, omega_c=0.0, dead_man=False, drag="null"):
        self.sequence += 1
        said = {"v_c": v_c, "omega_c": omega_c, "v_z": 0.0, "dead_man": dead_man}
        # Its clock is ours.
        times = {"sequence": self.sequence, "sent": time.monotonic(), "ahead": 0.0}
        # A drag as text: JSON has no infinity, and a page may write 1e999.
        self.socket.send(f'{json.dumps(said | times)[:-1]}, "drag": {drag}}}')

    def asks(self, what, **more):
        said = {"ask": what, "sent": time.monotonic(), "ahead": 0.0}
        self.socket.send(json.dumps(said | more))

    @property
    def motion(self):
        """Returns the base's speeds, and those of base and arm along the reach."""
        return [self.state[name] for name in ("v_b", "omega_b", "base", "arm")]

    def gets(self, arming):
        """Lets everything go, and presses the dead-man, until it is armed so far."""
        end = time.monotonic() + PATIENCE
        while self.hears()["arming"] != arming:
            assert time.monotonic() < end, arming
            self.says(dead_man=self.state["arming"] == Arming.READY)
            time.sleep(0.02)

    def arms(self):
        self.gets(Arming.READY)
        self.gets(Arming.ARMED)


def test_page_of_another_site_does_not_see_the_picture(own):
    for origin in (EVIL, "null", "http://127.0.0.1:9"):
        with (
            pytest.raises(InvalidStatus) as refused,
            wired(own, "/view/", origin=origin),
        ):
            pass
        assert refused.value.response.status_code == 403


def test_nothing_that_is_said_to_the_picture_drives_the_robot(own):
    # Opened first, and so who would drive.
    with wired(own, "/view/") as socket, wired(own, "/drive") as drive:
        watcher = Operator(drive)
        until(lambda: "l" in watcher.hears(), "it runs")
        reach = watcher.state["l"]
        for i in range(1, 60):
            said = {"sequence": i, "v_c": 1.0, "omega_c": 1.0, "v_z": 0.0}
            times = {"sent": time.monotonic(), "ahead": 0.0}
            socket.send(json.dumps(said | times | {"dead_man": i > 20, "drag": None}))
            for name in (HOLD, RESET, STOP):
                socket.send(packed({"type": "button", "name": name}))
            socket.send(packed({"type": "slider", "name": "x", "value": 1.0}))
            watcher.hears()
            assert watcher.state["arming"] != Arming.ARMED
            assert (watcher.motion, watcher.state["l"]) == ([0, 0, 0, 0], reach)
            time.sleep(0.01)


def test_viewer_who_does_not_listen_holds_up_nobody(own):
    with wired(own, "/view/", max_queue=1), wired(own, "/drive") as drive:
        operator = Operator(drive)
        operator.arms()
        with wired(own, "/view/", max_queue=None) as viewer:
            for i in range(60):
                operator.says(0.5 * (-1) ** (i // 15), dead_man=True)
                operator.hears()
                time.sleep(0.02)
            seen = []
            with suppress(TimeoutError):
                while len(seen) < 20:
                    seen.append(json.loads(viewer.recv(timeout=2)))
        assert len(seen) == 20
        assert "/world" in seen[0]["poses"]  # Who comes later is told all.


@pytest.mark.browser
@pytest.mark.skipif(not CHROMIUM, reason="there is no Chromium")
def test_page_says_why_there_is_no_picture_and_shows_it_again_by_itself():
    playwright_api = pytest.importorskip("playwright.sync_api")
    with (
        mobman_drive("kwon_1", "--port", "0") as (process, address),
        playwright_api.sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport={"width": 500, "height": 500})
        page.route("**/view/", lambda route: route.abort())
        page.goto(address)
        notice = page.locator(".still")
        no_picture, frozen = "No picture: it did", "The picture is frozen"

        def says(text):
            page.wait_for_function(
                "x => document.querySelector('.still')?.textContent.startsWith(x)",
                arg=text,
                timeout=1e3 * PATIENCE,
            )

        def shows_it():
            page.wait_for_selector(".still:empty", state="attached")
            page.wait_for_function(
                "window[0]?.viewer?.scene_tree.children.world.children.base"
            )
            assert not notice.is_visible()

        says(no_picture)
        page.unroute("**/view/")
        shows_it()
        process.send_signal(signal.SIGSTOP)
        says(frozen)
        process.send_signal(signal.SIGCONT)
        shows_it()
        browser.close()


# --- While armed ---------------------------------------------------------------------


def test_hundreds_of_choices_while_armed_make_no_jump(own):
    with wired(own, "/drive") as socket:
        operator = Operator(socket)
        operator.arms()
        # Not the one that jumps by itself, where it switches.
        choices = ["blending", "exact", "field, projected"]
        states = []
        began = time.monotonic()
        for i in range(200):
            # Slower than the fastest that the session hears.
            share = 0.6 * min(1.0, time.monotonic() - began)
            operator.says(share, 0.5 * share, dead_man=True)
            operator.asks("choose", choice=choices[i % len(choices)])
            time.sleep(0.02)
            if operator.hears() not in states[-1:]:
                states.append(operator.state)
        assert len({state["choice"] for state in states}) > 2
        assert {state["arming"] for state in states} == {Arming.ARMED}  # It drives on.
    # A change takes half a second, and nowhere goes faster than 3 times its way a
    # second; the ways are below 1 m/s and 1 rad/s. Told at once, each would jump.
    gaps = np.diff([state["time"] for state in states])
    for name in ("v_b", "omega_b"):
        values = np.array([state[name] for state in states])
        assert (np.abs(np.diff(values)) <= 4.0 * gaps).all()
    assert values.max() > 0.1


def test_dozens_of_resets_leave_the_robot_at_rest_at_its_start(own):
    with wired(own, "/drive") as socket:
        operator = Operator(socket)
        operator.arms()
        for _ in range(24):
            operator.says(1.0, dead_man=True)
            operator.asks("reset")
            time.sleep(0.02)
        until(lambda: 0.3 < operator.hears()["time"] < 3.0, "it started over")
        for _ in range(20):
            operator.says(1.0, dead_man=True)
            operator.hears()
            assert operator.state["arming"] != Arming.ARMED
            assert operator.motion == [0, 0, 0, 0]
            assert (operator.state["l"], operator.state["psi"]) == (1.0, 0.0)
            time.sleep(0.02)
        operator.arms()  # And can be driven as before.


STRONGEST = 60.0
"""Force of a hand, at most [N]."""

HARSH = {
    "infinite": "1e999, 0, 1e999",
    "huge": "1e300, -1e300, 1e300",
    "below the floor": "0.6, 0, -5",
    "far away": "9.9, 0, 0.5",
}
"""Places whereto a link is dragged, as they are written."""


def test_harsh_drags_pull_with_a_bounded_force(tmp_path):
    folder = tmp_path / "session"
    drive = mobman_drive("petric_guided", "--port", "0", "--record", str(folder))
    with drive as (process, address):
        until(lambda: answers(address), "it serves")
        own = address.rstrip("/")
        url = own.replace("http", "ws") + "/drive"
        with connect(url, origin=own, open_timeout=5, close_timeout=1) as socket:
            drag_about(Operator(socket))
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=PATIENCE)
        assert (process.returncode, errors) == (0, "")
    log = np.load(folder / "log.npz")
    force = np.linalg.norm(log["hand_force"], axis=1)
    assert force.max() <= STRONGEST * (1 + 1e-9)
    assert force[log["drag"][:, 0] > 0].max() > 5.0  # It does pull.
    for name in ("base_pose", "arm_position", "arm_velocity", "base_command_smoothed"):
        assert np.isfinite(log[name]).all(), name
    statuses = set(log["gate_status"].ravel())
    assert {GateStatus.NOT_FINITE, GateStatus.OVER_RANGE, GateStatus.OK} <= statuses


def drag_about(operator):
    """Drags the last link to harsh places, by harsh points, and to and fro."""

    def drags(to, point="0, 0, 0.1"):
        operator.arms()
        for _ in range(20):
            drag = f'{{"body": "link7", "point": [{point}], "to": [{to}]}}'
            operator.says(dead_man=True, drag=drag)
            time.sleep(0.02)

    for to in HARSH.values():
        drags(to)
    for point in ("1e999, 0, 0", "1e300, 0, 0", "0, 0, 0.9"):
        drags("0.6, 0, 0.5", point)
    for i in range(90):  # From side to side, thirty times a second.
        way = (-1) ** i
        to = f"{0.4 + 0.3 * way}, {0.8 * way}, {0.5 - 0.4 * way}"
        drag = f'{{"body": "link7", "point": [0, 0, 0.1], "to": [{to}]}}'
        operator.says(dead_man=True, drag=drag)
        time.sleep(1 / 30)
    assert "died" not in operator.hears()["text"]


# --- Meshcat's panel, which is the page itself ---------------------------------------


class Panels:
    """Speaks to Meshcat as its page in the browser does."""

    def __init__(self, address):
        self.url = re.sub(r"^http(.*)/\?.*", r"ws\1/", address)
        self.beats = 0

    def connected(self):
        with suppress(OSError, InvalidStatus):
            return connect(self.url, open_timeout=5, close_timeout=1, max_queue=None)

    def draws(self, socket):
        """Says that it has drawn something new, and that a dead-man is held."""
        self.beats += 1
        pose = np.eye(4)
        pose[0, 3] = self.beats
        socket.send(camera_pose(pose.ravel(order="F").tolist()))

    def presses(self, socket, name):
        socket.send(packed({"type": "button", "name": name}))

    def pushes(self, socket, name, value):
        socket.send(packed({"type": "slider", "name": name, "value": value}))


def test_panel_that_is_ended_frozen_or_killed_stops_the_robot_and_comes_back():
    said = []
    scenario = load_scenario("kwon_arbitrary", ["gate.fresh=0.5"])
    with LiveSession(scenario) as session:
        panel = PanelProcess(session, free_address(), said.append)
        thread = threading.Thread(target=panel.run)
        thread.start()
        try:
            for wrong in ("zeros", signal.SIGSTOP, signal.SIGKILL):
                ended_while_driving(panel, session, wrong)
                until(lambda: answers(panel.address), "it is back")
                assert rests(session)
        finally:
            panel.close()
            thread.join(PATIENCE)
        assert not thread.is_alive()
    assert len(said) == 3
    assert said[0] == "the panel has ended; the robot stops, it starts again"
    assert "does not respond" in said[1]


def ended_while_driving(panel, session, wrong):
    """Drives from a panel, and ends that by a frame or a signal."""
    page = Panels(panel.address)
    socket = until(page.connected, "the panel is there")
    with socket:

        def moves():
            page.draws(socket)
            arming = session.snapshot().arming
            if arming != Arming.LATCHED:
                page.presses(socket, HOLD)
            push = 0.6 if arming == Arming.ARMED else 0.0
            page.pushes(socket, "out (up, down)", push)
            time.sleep(0.03)
            return not rests(session)

        until(moves, "it moves")
        if isinstance(wrong, str):
            socket.send(DEADLY[wrong])
        else:
            os.kill(panel._process.pid, wrong)
        ended = time.monotonic()
        until(lambda: rests(session), "it rests")
        assert time.monotonic() - ended < 2.0
        assert session.snapshot().status in {GateStatus.STALE, GateStatus.GONE}


@needs_proc
@pytest.mark.parametrize("way", [signal.SIGINT, signal.SIGKILL])
def test_drive_from_meshcats_panel_ends_when_told_even_if_meshcat_is_dead(way):
    with mobman_drive("kwon_1", "--plain") as (process, address):
        # Somebody else's site would have to guess where it is.
        assert "127.0.0.1" not in address
        assert answers(address)
        family = family_of(process.pid)
        assert len(family) > 1
        shoot(Panels(address).url, DEADLY["empty"])
        process.send_signal(way)
        _, errors = process.communicate(timeout=PATIENCE)
        assert process.returncode == (-way if way == signal.SIGKILL else 0)
        # It says what it exposes, before anything else.
        first = errors.splitlines()[0]
        assert first.startswith("mobman: Meshcat's panel has no login")
        assert "Traceback" not in errors
        for member in family | family_of(process.pid):
            until(lambda member=member: not is_alive(member), "its processes are gone")


def is_alive(pid):
    with suppress(OSError):
        return ") Z " not in Path(f"/proc/{pid}/stat").read_text()
    return False


def test_panel_is_refused_where_it_cannot_be_served():
    with pytest.raises(OSError, match="1024 or above"):
        free_address(80)
    with listening(port=0) as taken, pytest.raises(OSError, match="in use"):
        free_address(taken.getsockname()[1])
