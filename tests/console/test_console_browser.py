"""The console from end to end, in Chromium: what a person does, what the robot does.

Where there is no Chromium nothing of this runs; continuous integration installs it.
Times are generous but for those that are promised.
"""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
import urllib.request
from contextlib import contextmanager, suppress

import numpy as np
import pytest
from playwright.sync_api import sync_playwright
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from drake_mobman.console.addresses import listening
from drake_mobman.console.meshcat_panel import MeshcatPanel
from drake_mobman.console.server import Server
from drake_mobman.console.session import LiveSession
from drake_mobman.console.view import CAN_DRAG
from drake_mobman.meshcat import local_meshcat
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate
from drake_mobman.teleop.gate import Arming, GateStatus

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(not CHROMIUM, reason="there is no Chromium"),
]

FLAGS = [
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update"),
    "--disable-sync",
    # The 3D view is drawn in software.
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
]

PATIENCE = 30.0
"""Of a test that waits for what is to happen at once [s]."""

LET_GO = {GateStatus.RELEASED, GateStatus.STALE}
"""Why the gate may be closed after a page let go: on a busy machine, a command that
came too late may have closed it a moment before."""

IN_TIME = {GateStatus.OK, GateStatus.STALE}
"""What the gate may say where nobody let go, and nobody stopped: the same holds."""

LAPTOP, PHONE = {"width": 1366, "height": 768}, {"width": 390, "height": 844}


@pytest.fixture(scope="module")
def session():
    # What has no smoother stops at once; here the base has to brake.
    scenario = load_scenario("kwon_arbitrary", ["smoother=smoother"])
    with LiveSession(scenario) as session:
        yield session


@pytest.fixture(scope="module")
def server(session):
    server = Server("kwon_arbitrary", session, listening(port=0))
    thread = threading.Thread(target=server.run)
    thread.start()
    until(lambda: server.started, "it serves")
    yield server
    server.close()
    thread.join()


@pytest.fixture(scope="module")
def browser():
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()


class Console:
    """A page in the browser, and what a person does there."""

    def __init__(self, browser, address, size=LAPTOP, **options):
        self.context = browser.new_context(viewport=size, **options)
        self.page = self.context.new_page()
        self.asked_for, self.errors = [], []
        self.held = False  # Whether the pad is.
        self.page.on("request", lambda request: self.asked_for.append(request.url))
        self.page.on("websocket", lambda socket: self.asked_for.append(socket.url))
        # A bound method of a list will not do.
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.goto(address)
        self.page.wait_for_selector("html[data-ready][data-role]")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.context.close()

    def until(self, condition, what):
        """Waits, while what the browser says is heard."""
        end = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < end, what
            self.page.wait_for_timeout(20)

    def says(self, **facts):
        """Waits until the page says so, by its root's attributes."""
        for name, value in facts.items():
            self.page.wait_for_selector(f"html[data-{name}={value}]")

    def takes(self, press, let_go):
        """Presses a dead-man until that arms: one that came too late does not.

        A page that cannot keep up with drawing on a busy machine is stopped, as it has
        to be. Then a person lets go, and presses anew.
        """
        end = time.monotonic() + PATIENCE
        while True:
            press()
            self.page.wait_for_selector(
                ":is([data-arming=armed], [data-arming=latched])"
            )
            if self.arming == "armed":
                return
            assert time.monotonic() < end, self.status
            let_go()
            self.says(arming="ready")

    def while_held(self, press, let_go, condition, what):
        """Waits for what a pressed dead-man brings; presses anew where stopped."""

        def holds():
            if self.arming == "latched":
                let_go()
                self.says(arming="ready")
                press()
            return condition()

        self.until(holds, what)

    def push(self, x, y):
        """Holds the pad, pushed to the right and forward by shares of its way."""
        if self.held:
            return
        self.held = True
        box = self.page.locator(".pad").bounding_box()
        radius = box["width"] / 2
        middle = box["x"] + radius, box["y"] + radius
        mouse = self.page.mouse

        def press():
            mouse.move(*middle)
            mouse.down()

        self.takes(press, mouse.up)
        mouse.move(middle[0] + x * radius, middle[1] - y * radius, steps=4)

    def drive(self, condition, what, x=0.0, y=1.0):
        """Pushes the pad, forward if not told else, until something is so; holds it."""
        push = lambda: self.push(x, y)  # noqa: E731
        push()
        self.while_held(push, self.release, condition, what)

    def release(self):
        self.page.mouse.up()
        self.held = False

    @property
    def arming(self):
        return self.page.get_attribute("html", "data-arming")

    @property
    def status(self):
        return self.page.inner_text(".status")


@pytest.fixture
def console(session, server, browser):
    until(lambda: not server.arbiter.pages, "others are gone")
    session.reset()
    with Console(browser, server.address) as console:
        console.says(role="you", arming="ready")
        yield console
        assert console.errors == []


def signal_of(session, name):
    return np.array(session.snapshot().signals[name])


def rests(session):
    velocity = [signal_of(session, "base_velocity"), signal_of(session, "arm_velocity")]
    return not np.any(np.hstack(velocity))


def let_go_of(session):
    """Returns whether the page said that nobody holds on, and the robot rests.

    One that only falls silent leaves the last that it said, with the dead-man held.
    """
    held = signal_of(session, "operator_input")[3]
    return not held and session.snapshot().status in LET_GO and rests(session)


def stopped(session):
    """Returns whether someone stopped the robot, and it rests.

    On a busy machine a late command may have, before: it rests, but is not stopped yet.
    """
    return session.snapshot().status == GateStatus.STOPPED and rests(session)


# --- Driving -------------------------------------------------------------------------


def test_page_asks_nobody_else_for_anything(console, server):
    console.page.wait_for_timeout(1500)
    own = re.compile(rf"(http|ws)://127\.0\.0\.1:{server.port}/|data:|blob:")
    assert [url for url in console.asked_for if not own.match(url)] == []
    assert any(url.endswith("/view/") for url in console.asked_for)


def test_pad_drives_the_hand_out_and_then_the_base_and_letting_go_stops(
    console, session
):
    l_max = session.scenario.workspace.l_max
    reach, x = (
        signal_of(session, "ee_cylindrical")[0],
        signal_of(session, "base_pose")[0],
    )
    console.drive(
        lambda: signal_of(session, "ee_cylindrical")[0] > reach + 0.2, "hand out"
    )
    assert signal_of(session, "base_pose")[0] < x + 0.05
    console.drive(lambda: signal_of(session, "base_pose")[0] > x + 0.2, "base follows")
    assert signal_of(session, "ee_cylindrical")[0] == pytest.approx(l_max, abs=0.5)
    assert console.status == "driving"
    console.release()
    console.until(lambda: rests(session), "it rests")
    console.says(arming="ready")
    assert console.status.startswith("stopped: dead-man released")
    console.drive(
        lambda: signal_of(session, "ee_command")[1] > 0.2, "to the left", x=-0.9, y=0.0
    )
    console.release()


def test_page_frozen_at_full_stick_stops_the_base_in_time(console, session):
    most = session.scenario.guard.max_v_c
    console.drive(
        lambda: signal_of(session, "base_command_smoothed")[0] > 0.9 * most,
        "full speed",
    )
    limits = session.scenario.smoother
    bound = 0.25 + limits.max_speed / limits.max_acceleration + 0.1
    renderers = renderers_of(os.getpid())
    frozen = time.monotonic()
    for pid in renderers:
        os.kill(pid, signal.SIGSTOP)
    try:
        while not rests(session):
            assert time.monotonic() < frozen + PATIENCE
            time.sleep(0.002)
        took = time.monotonic() - frozen
        assert session.snapshot().status == GateStatus.STALE
        # A hand on the stick all the while, and then the page is back.
        time.sleep(0.5)
    finally:
        for pid in renderers:
            os.kill(pid, signal.SIGCONT)
    assert took < bound
    console.page.wait_for_timeout(1000)
    assert rests(session)
    # A page that has heard nothing for long lets go by itself; it has to be held anew.
    assert session.snapshot().arming != Arming.ARMED


def renderers_of(pid):
    """Returns the processes below one that draw pages in Chromium."""
    table = subprocess.run(
        ["ps", "-eo", "pid=,ppid=,args="], capture_output=True, text=True, check=True
    )
    rows = [line.split(None, 2) for line in table.stdout.splitlines()]
    below, found = {str(pid)}, []
    for _ in range(8):  # So deep, at most.
        below |= {row[0] for row in rows if row[1] in below}
    found = [row for row in rows if row[0] in below and "--type=renderer" in row[2]]
    return [int(row[0]) for row in found]


def test_page_that_loses_attention_lets_go_at_once(console, session):
    devtools = console.context.new_cdp_session(console.page)
    devtools.send("Emulation.setFocusEmulationEnabled", {"enabled": False})
    console.page.bring_to_front()
    console.says(arming="ready")
    console.drive(lambda: not rests(session), "it moves")
    other = console.context.new_page()  # In front of it.
    other.bring_to_front()
    console.until(lambda: rests(session), "it rests")
    # To open a tab may take a browser longer than a command is fresh.
    assert session.snapshot().status in LET_GO
    # It says no more, and is still there when one comes back; as is the finger.
    time.sleep(0.5)
    assert signal_of(session, "operator_input")[4] > 0.25
    other.close()
    console.page.bring_to_front()
    console.says(arming="ready")
    assert rests(session)
    console.release()


class Tab:
    """A tab of a Chromium that has no Playwright, which keeps every tab visible."""

    def __init__(self, devtools, address):
        self.devtools = devtools
        self.socket, self.calls = None, 0
        self.arming = Arming.LATCHED  # Of the session, when it was last looked at.
        until(lambda: self.opened(address), "it is open")
        (found,) = self.opened(address)
        self.id, self.url = found["id"], found["webSocketDebuggerUrl"]

    def opened(self, address):
        return [tab for tab in self.ask("list") if tab["url"].startswith(address)]

    def ask(self, what, method="GET"):
        asked = urllib.request.Request(f"{self.devtools}/{what}", method=method)
        with urllib.request.urlopen(asked) as answer:
            text = answer.read()
        return json.loads(text) if text.startswith((b"{", b"[")) else text

    def call(self, method, **params):
        self.calls += 1
        call = {"id": self.calls, "method": method, "params": params}
        self.socket.send(json.dumps(call))
        while (said := json.loads(self.socket.recv())).get("id") != self.calls:
            pass
        return said["result"]

    def evaluate(self, expression):
        said = self.call("Runtime.evaluate", expression=expression, returnByValue=True)
        return said["result"].get("value")

    def mouse(self, kind, x, y):
        button = {"button": "left", "buttons": 1, "clickCount": 1}
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **button)

    def drives(self, session):
        """Pushes the pad forward; returns whether that moves the robot by now.

        One that was stopped, as on a busy machine it may be, is let go and held anew.
        """
        arming = session.snapshot().arming
        pad = "document.querySelector('.pad').getBoundingClientRect()"
        middle = f"(({{ x, y, width }}) => [x + width / 2, y + width / 2])({pad})"
        if arming == Arming.ARMED:
            x, y = self.evaluate(middle)
            self.mouse("mouseMoved", x, y - 80)
        elif arming != self.arming:
            kind = "mousePressed" if arming == Arming.READY else "mouseReleased"
            self.mouse(kind, *self.evaluate(middle))
        self.arming = arming
        return not rests(session)


@contextmanager
def tab_of_chromium(folder, address):
    """Opens an address in a Chromium of its own, and gives the tab."""
    process = subprocess.Popen(
        [
            *(CHROMIUM, *FLAGS, "--headless=new", "--remote-debugging-port=0"),
            *(f"--user-data-dir={folder}", address),
        ],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        file = folder / "DevToolsActivePort"
        until(lambda: file.exists() and file.read_text(), "it listens")
        tab = Tab(f"http://127.0.0.1:{file.read_text().split()[0]}/json", address)
        with connect(tab.url) as tab.socket:
            yield tab
    finally:
        process.kill()
        process.wait()


def test_tab_that_is_hidden_lets_go_at_once(session, server, tmp_path):
    until(lambda: not server.arbiter.pages, "others are gone")
    session.reset()
    with tab_of_chromium(tmp_path, server.address) as tab:
        until(lambda: tab.drives(session), "it moves")

        tab.ask("new?about:blank", method="PUT")  # Another in front of it.
        until(lambda: rests(session), "it rests")
        # To open a tab may take a browser longer than a command is fresh.
        assert session.snapshot().status in LET_GO
        assert tab.evaluate("document.visibilityState") == "hidden"
        time.sleep(0.5)
        assert signal_of(session, "operator_input")[4] > 0.25

        tab.ask(f"activate/{tab.id}")
        until(lambda: session.snapshot().arming == Arming.READY, "it is back")
        assert tab.evaluate("document.visibilityState") == "visible"
        assert rests(session)


def test_link_that_is_cut_stops_the_robot_and_comes_back(console, session):
    console.drive(lambda: not rests(session), "it moves")
    console.context.set_offline(True)
    console.until(lambda: rests(session), "it rests")
    assert session.snapshot().status == GateStatus.STALE
    console.context.set_offline(False)
    console.release()
    console.says(role="you", arming="ready")


def test_second_page_watches_stops_and_takes_over_what_it_is_given(
    console, session, server, browser
):
    with Console(browser, server.address, PHONE, has_touch=True) as second:
        second.says(role="another")
        console.drive(lambda: not rests(session), "it moves")
        second.page.mouse.click(100, 600)  # On its pad, which does nothing.
        assert session.snapshot().status in IN_TIME
        name = session.snapshot().choice
        second.page.mouse.click(*middle_of(second, ".choose:not([aria-pressed=true])"))
        second.page.wait_for_timeout(200)
        assert session.snapshot().choice == name
        second.page.click(".stop")
        console.until(lambda: rests(session), "it rests")
        console.until(lambda: "by a viewer" in console.status, "it says who")
        assert session.snapshot().text.startswith("stopped by a viewer")
        console.release()
        console.says(arming="ready")

        second.page.click(".take")
        console.says(asked="yes")
        second.says(role="another")
        console.page.click(".hand_over")
        second.page.wait_for_selector("html[data-role=nobody]")
        second.page.click(".take")
        second.says(role="you", arming="ready")
        console.says(role="another")
        second.drive(lambda: not rests(session), "the phone drives")
        second.release()
        second.until(lambda: rests(session), "it rests")


class Fingers:
    """Fingers on a touch screen, by name."""

    def __init__(self, console):
        self.devtools = console.context.new_cdp_session(console.page)
        self.points = {}

    def put(self, name, x, y):
        kind = "touchMove" if name in self.points else "touchStart"
        self.points[name] = {"x": x, "y": y, "id": len(name)}
        self._send(kind)

    def lift(self):
        self.points.clear()
        self._send("touchEnd")

    def cancel(self):
        self.points.clear()
        self._send("touchCancel")

    def _send(self, kind):
        points = list(self.points.values())
        self.devtools.send(
            "Input.dispatchTouchEvent", {"type": kind, "touchPoints": points}
        )


def test_thumbs_on_a_phone_drive_and_stop(session, server, browser):
    until(lambda: not server.arbiter.pages, "others are gone")
    session.reset()
    with Console(browser, server.address, PHONE, has_touch=True) as console:
        console.says(role="you", arming="ready")
        where = {}
        for name in ("pad", "lever", "stop"):
            box = console.page.locator(f".{name}").bounding_box()
            assert box["y"] + box["height"] <= PHONE["height"]  # Without scrolling.
            where[name] = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        box_of_pad = console.page.locator(".pad").bounding_box()
        fingers = Fingers(console)
        up = lambda name: (where[name][0], where[name][1] - 60)  # noqa: E731

        def thumb():
            console.takes(lambda: fingers.put("pad", *where["pad"]), fingers.lift)
            fingers.put("pad", *up("pad"))

        def thumbs():
            thumb()
            fingers.put("lever", *where["lever"])
            fingers.put("lever", *up("lever"))

        def both_go():
            return min(signal_of(session, "ee_command")[[0, 2]]) > 0

        thumbs()
        console.while_held(thumbs, fingers.lift, both_go, "both")
        # It stays where it is, however long the status says what.
        assert console.page.locator(".pad").bounding_box() == box_of_pad
        # A second thumb chooses while the first one drives.
        fingers.put("choice", *middle_of(console, '[data-choice="exact"]'))
        console.until(lambda: session.snapshot().choice == "exact", "it is chosen")
        fingers.put("stop", *where["stop"])
        console.until(lambda: stopped(session), "it is stopped, and rests")
        fingers.lift()
        console.says(arming="ready")
        choose(console, "blending")

        thumbs()
        console.while_held(thumbs, fingers.lift, lambda: not rests(session), "it moves")
        fingers.cancel()  # As when a call comes in.
        console.until(lambda: let_go_of(session), "it is let go, and rests")


def test_keys_and_gamepad_drive_while_their_dead_man_is_held(console, session):
    keys = console.page.keyboard
    keys.down("ArrowUp")
    console.page.wait_for_timeout(300)
    assert rests(session)
    keys.up("ArrowUp")
    console.says(arming="ready")

    def goes(condition, what, *names):
        hold(console, lambda: condition(signal_of(session, "ee_command")), what, *names)

    goes(lambda command: command.tolist() == [0.0, 0.4, 0.0], "it turns", "Space", "a")
    goes(lambda command: command[1] == 0.1, "it turns slowly", "Space", "a", "Shift")
    keys.up("Shift")
    goes(lambda command: command[1] == 0.4, "and quickly", "Space", "a")
    for key, way in [("r", 1), ("f", -1)]:
        goes(lambda command, way=way: command[2] * way > 0, key, "Space", "a", key)
        keys.up(key)
    keys.press("Escape")
    console.until(lambda: stopped(session), "it is stopped, and rests")
    assert session.snapshot().text.startswith("stopped by the operator")
    keys.up("a")
    keys.up("Space")
    console.says(arming="ready")

    plug_in_gamepads(console)
    console.says(arming="ready")  # Whatever the one says that is no gamepad.

    def goes_by_gamepad(condition, what, *state):
        press = lambda: set_gamepad(console, *state)  # noqa: E731
        let_go = lambda: set_gamepad(console, [0, 0, 0, 0])  # noqa: E731
        press()
        console.while_held(press, let_go, condition, what)

    def command(i):
        return signal_of(session, "ee_command")[i]

    goes_by_gamepad(lambda: command(1) == 0.4, "it turns", [-1, 0, 0, 0], 6)
    goes_by_gamepad(lambda: command(2) > 0, "it goes up", [0, 0, 0, -1], 6)
    set_gamepad(console, [0, 0, 0, 0])
    console.says(arming="ready")
    goes_by_gamepad(lambda: command(0) == 0.4, "it goes out", [0, -1, 0, 0], 7)
    console.page.evaluate("plugged.buttons[1] = { value: 1, pressed: true }")
    console.until(lambda: stopped(session), "it is stopped, and rests")
    set_gamepad(console, [0, 0, 0, 0])
    console.says(arming="ready")
    goes_by_gamepad(lambda: not rests(session), "it moves", [0, -1, 0, 0], 7)
    console.page.evaluate("plugged.connected = false")
    console.until(lambda: let_go_of(session), "it is let go, and rests")


def plug_in_gamepads(console):
    """Plugs in a gamepad, and before it a throttle that rests at the end of its way."""
    console.page.evaluate(
        """() => {
            const known = { connected: true, mapping: "standard" };
            window.plugged = { ...known, axes: [0, 0, 0, 0] };
            plugged.buttons = Array.from({ length: 17 }, () => ({ value: 0 }));
            const odd = { connected: true, mapping: "", axes: [0, 0, 0, -1] };
            odd.buttons = [{ value: 0 }];
            navigator.getGamepads = () => [null, odd, plugged];
        }"""
    )
    console.page.wait_for_timeout(300)  # Until it has been looked at.


def set_gamepad(console, axes, trigger=None):
    """Moves its sticks, pulls a trigger, and lets all other buttons go."""
    console.page.evaluate(
        """([axes, trigger]) => {
            const value = (_, i) => ({ value: i === trigger ? 1 : 0 });
            Object.assign(plugged, { axes, buttons: plugged.buttons.map(value) });
        }""",
        [axes, trigger],
    )


def test_choice_and_reset_are_a_click_away(console, session):
    for name in ("exact", "blending"):
        choose(console, name)
        console.until(lambda: session.snapshot().choice == name, "it is chosen")  # noqa: B023
        console.page.wait_for_selector(f'[data-choice="{name}"][aria-pressed=true]')
    console.until(lambda: session.snapshot().time > 1.0, "it runs")
    console.page.click(".reset")
    console.until(lambda: session.snapshot().time < 1.0, "it starts over")


def hold(console, condition, what, *names):
    """Holds keys until something is so; anew, where a busy machine stopped them."""

    def press():
        for name in names:
            console.page.keyboard.down(name)

    press()
    console.while_held(press, lambda: let_go(console, *names), condition, what)


def hold_until_it_moves(console, session, *names):
    console.says(arming="ready")
    hold(console, lambda: not rests(session), "they move it", *names)


def let_go(console, *names):
    for name in names:
        console.page.keyboard.up(name)


def choose(console, name):
    console.page.click(f'.choose[data-choice="{name}"]')


def middle_of(console, selector):
    """Returns the middle of the first such element [pixels]."""
    box = console.page.locator(selector).first.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_choice_can_be_changed_while_keys_drive(console, session):
    hold_until_it_moves(console, session, "Space", "w")
    choose(console, "exact")
    console.until(lambda: session.snapshot().choice == "exact", "it is chosen")
    assert session.snapshot().status in IN_TIME
    choose(console, "blending")
    console.until(lambda: session.snapshot().choice == "blending", "it is chosen")
    let_go(console, "Space", "w")
    console.until(lambda: rests(session), "it rests")
    # The space bar is the dead-man, whatever button was used last.
    console.page.focus('.choose[data-choice="exact"]')
    console.page.keyboard.press("Space")
    console.page.wait_for_timeout(300)
    assert session.snapshot().choice == "blending"


@pytest.mark.parametrize("fails", ["without WebGL", "without a server"])
def test_picture_that_did_not_load_keeps_no_key_held(console, session, fails):
    if fails == "without WebGL":
        console.context.add_init_script(
            "HTMLCanvasElement.prototype.getContext = () => null"
        )
    else:
        console.context.route("**/view/", lambda route: route.abort())
    console.page.evaluate(
        """() => new Promise((done) => {
            const frame = document.querySelector(".scene");
            frame.addEventListener("load", done);
            frame.contentWindow.location.reload();
        })"""
    )
    console.errors.clear()  # Of Meshcat.
    hold_until_it_moves(console, session, "Space", "w")
    console.page.click(".scene")
    let_go(console, "Space", "w")
    console.until(lambda: let_go_of(session), "it is let go, and rests")
    if fails == "without WebGL":
        console.page.keyboard.press("Escape")
        console.until(lambda: session.snapshot().status == GateStatus.STOPPED, "stop")
    # The pad takes the attention back.
    console.page.click(".pad")
    console.says(arming="ready")
    console.drive(lambda: not rests(session), "it moves")
    console.release()


@pytest.mark.parametrize("kind", ["keydown", "keyup", "contextmenu"])
def test_meta_key_and_menus_let_go_of_keys(console, session, kind):
    hold_until_it_moves(console, session, "Space", "w")
    if kind == "contextmenu":
        console.page.click(".help", button="right")
    else:  # As macOS does: of what else is let go meanwhile it says nothing.
        console.page.evaluate(
            """(kind) => {
                const meta = { key: "Meta", code: "MetaLeft", bubbles: true };
                document.body.dispatchEvent(new KeyboardEvent(kind, meta));
            }""",
            kind,
        )
    console.until(lambda: let_go_of(session), "it is let go, and rests")
    let_go(console, "Space", "w")


SIZES = [
    *((1366, 768), (1000, 600), (1000, 500), (1000, 390), (844, 390), (568, 320)),
    *((390, 844), (390, 664), (360, 640)),
]


def test_stop_is_never_covered_and_all_it_takes_to_drive_is_in_sight(console):
    page = console.page
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        for scrolled in (0, 10_000):
            page.evaluate(
                "(y) => document.querySelector('.stage').scrollTo(0, y)", scrolled
            )
            assert covered(page, ".stop") == [], (width, height, scrolled)
        page.evaluate("document.querySelector('.stage').scrollTo(0, 0)")
        for name in ("scene", "pad", "lever", "choices", "reset"):
            box = page.locator(f".{name}").bounding_box()
            assert box["y"] + box["height"] <= height, (name, width, height)
            assert box["x"] + box["width"] <= width, (name, width, height)
            assert min(box["width"], box["height"]) >= 30, (name, width, height)
            assert covered(page, f".{name}") == [], (name, width, height)


def covered(page, selector):
    """Returns what lies over an element, or beside it within the box that it fills."""
    return page.evaluate(
        """(selector) => {
            const element = document.querySelector(selector);
            const { x, y, width, height } = element.getBoundingClientRect();
            const over = [];
            for (let i = 1; i < 10; i++) {
                for (let j = 1; j < 10; j++) {
                    // Round as the pad is.
                    if (Math.hypot(i - 5, j - 5) > 4.9) continue;
                    const at = [x + width * i / 10, y + height * j / 10];
                    const top = document.elementFromPoint(...at);
                    if (!element.contains(top)) over.push(top?.className ?? "nothing");
                }
            }
            return over;
        }""",
        selector,
    )


def test_pad_that_moves_under_a_resting_thumb_is_not_pushed(console, session):
    console.push(0.0, 0.0)
    before = console.page.locator(".pad").bounding_box()
    console.page.evaluate("document.querySelector('.notice').style.height = '90px'")
    after = console.page.locator(".pad").bounding_box()
    assert after["y"] > before["y"] + 20
    x, y = (before[k] + before["width"] / 2 for k in "xy")
    console.page.mouse.move(x + 1, y)
    console.page.wait_for_timeout(300)
    assert rests(session)
    assert not np.any(signal_of(session, "ee_command"))
    console.release()


# --- Those who mean no good ----------------------------------------------------------


@contextmanager
def wired(server, **options):
    """Gives a `Wire` to a server."""
    options = {
        "origin": f"http://127.0.0.1:{server.port}",
        "close_timeout": 1,
    } | options
    with connect(f"ws://127.0.0.1:{server.port}/drive", **options) as socket:
        yield Wire(socket)


RESET = 1006
"""Of a socket that was closed while more was under way: that may cost it the code."""


class Wire:
    """A socket to the session that says what no page does."""

    def __init__(self, socket):
        self.socket = socket
        self.sequence = 0

    def says(self, v_c=0.0, dead_man=False):
        self.sequence += 1
        said = {"v_c": v_c, "omega_c": 0.0, "v_z": 0.0, "dead_man": dead_man}
        # Its clock is ours.
        more = {"sequence": self.sequence, "sent": time.monotonic(), "ahead": 0.0}
        self.socket.send(json.dumps(said | more))

    def drives(self, session):
        """Arms, as a page would, and drives at full stick."""
        end = time.monotonic() + PATIENCE
        while rests(session):
            assert time.monotonic() < end
            # What comes late on a busy machine disarms; then it is let go, and pressed.
            arming = session.snapshot().arming
            pressed = arming != Arming.LATCHED
            self.says(float(arming == Arming.ARMED), dead_man=pressed)
            time.sleep(0.03)

    def closed(self):
        """Returns the code by which the server closes it."""
        end = time.monotonic() + PATIENCE
        try:
            while time.monotonic() < end:
                self.socket.recv(timeout=PATIENCE)
        except ConnectionClosed as closed:
            return closed.rcvd.code if closed.rcvd else RESET
        raise AssertionError("it is still open")


@pytest.fixture
def wire(server):
    until(lambda: not server.arbiter.pages, "others are gone")
    with wired(server) as wire:
        yield wire


def until(condition, what):
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, what
        time.sleep(0.01)


def goes_on(session):
    """Asserts that the simulation keeps to the wall clock."""
    began, time_ = time.monotonic(), session.snapshot().time
    time.sleep(1.0)
    went = session.snapshot().time - time_
    assert went == pytest.approx(time.monotonic() - began, abs=0.5)


@pytest.mark.parametrize(
    ("message", "code"),
    [
        ("hello", 1008),
        ('{"v_c": NaN}', 1008),
        (b"\x00", 1008),
        ("x" * 600, 1009),
        ("x" * 100_000, 1009),
    ],
)
def test_operator_who_says_nonsense_is_cut_off_and_the_robot_stops(
    wire, session, message, code
):
    wire.drives(session)
    wire.socket.send(message)
    assert wire.closed() == code
    until(lambda: rests(session), "it rests")
    assert session.snapshot().status == GateStatus.GONE
    goes_on(session)


def test_flood_of_commands_stops_the_robot_and_disturbs_nothing(wire, session):
    wire.drives(session)
    ended = time.monotonic() + PATIENCE
    with suppress(ConnectionClosed):
        while time.monotonic() < ended:
            for _ in range(33):  # At once: a flood on a busy machine too.
                wire.says(1.0, dead_man=True)
            time.sleep(0.033)
    assert wire.closed() in {1008, RESET}
    until(lambda: rests(session), "it rests")
    assert session.snapshot().status == GateStatus.GONE
    goes_on(session)


def flooded(wire, server):
    """Drives for two seconds, while a viewer floods until it is cut off."""
    began, gone = time.monotonic(), False
    with wired(server) as viewer:
        while not (gone and time.monotonic() > began + 2.0):
            assert time.monotonic() < began + PATIENCE, "it is still open"
            wire.says(-1.0, dead_man=True)
            try:
                for _ in range(33):
                    viewer.says()
            except ConnectionClosed:
                gone = True
            time.sleep(0.033)
        assert viewer.closed() in {1008, RESET}


def test_flood_of_a_viewer_disturbs_nobody(wire, session, server):
    end = time.monotonic() + PATIENCE
    wire.drives(session)
    flooded(wire, server)
    # A busy machine stops an operator now and then, flood or not.
    while session.snapshot().status == GateStatus.STALE and time.monotonic() < end:
        until(lambda: rests(session), "it rests")
        wire.drives(session)
        flooded(wire, server)
    assert session.snapshot().status == GateStatus.OK
    goes_on(session)


def test_page_of_another_site_gets_no_socket(server):
    for origin in ("http://evil.example", None):
        with pytest.raises(InvalidStatus) as refused, wired(server, origin=origin):
            pass
        assert refused.value.response.status_code == 403


# --- From the command line -----------------------------------------------------------


@contextmanager
def mobman_drive(*arguments, folder=None):
    """Runs `mobman drive` in a folder; gives the process and the address it prints."""
    command = [sys.executable, "-u", "-m", "drake_mobman", "drive"]
    process = subprocess.Popen(
        [*command, *map(str, arguments), "--port", "0"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,
    )
    try:
        line = process.stdout.readline()
        assert "http://" in line, process.communicate()
        yield process, re.search(r"http://\S+(?=;)", line)[0]
    finally:
        process.kill()
        process.communicate()


def test_beyond_this_machine_the_token_that_is_printed_lets_in(browser):
    with mobman_drive("petric_guided", "--host", "0.0.0.0") as (_, address):
        port, token = re.search(r":(\d+)/\?token=(\S+)", address).groups()
        own = f"http://127.0.0.1:{port}/"
        context = browser.new_context()
        page = context.new_page()
        assert page.goto(own).status == 403
        assert page.goto(f"{own}?token={token[:-1]}").status == 403
        assert page.request.get(f"{own}view/").status == 403
        context.close()
        with Console(browser, f"{own}?token={token}", PHONE) as console:
            assert console.page.url == own
            # Pad and lever pull the hand here.
            console.says(role="you", arming="ready")
            console.drive(lambda: console.status == "driving", "it drives")
            console.release()


def test_page_says_so_when_nothing_is_heard_of_the_session(browser):
    with (
        mobman_drive("kwon_1") as (process, address),
        Console(browser, address) as console,
    ):
        console.says(role="you", arming="ready")
        process.send_signal(signal.SIGSTOP)
        console.until(lambda: "no data from it" in console.status, "it is missed")
        console.says(role="nobody", arming="latched")
        process.send_signal(signal.SIGCONT)
        console.says(role="you", arming="ready")


def drive_about(console, seconds, seed):
    """Drives as a child would, with all that the page has."""
    rng = np.random.default_rng(seed)
    page = console.page
    choices = page.locator(".choose").all_inner_texts()
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        console.says(arming="ready")
        if rng.random() < 0.7:
            console.push(*rng.uniform(-0.8, 0.8, 2))
            page.wait_for_timeout(rng.uniform(200, 2500))
            end_with = rng.choice(["release", "stop"])
            if end_with == "stop":
                page.keyboard.press("Escape")
            console.release()
        else:
            held = ["Space", *rng.choice(["w", "a", "s", "d", "r", "f"], 2)]
            for key in held:
                page.keyboard.down(key)
            page.wait_for_timeout(rng.uniform(200, 1500))
            for key in held:
                page.keyboard.up(key)
        if rng.random() < 0.3:
            choose(console, rng.choice(choices))


def ended(process):
    """Ends a session as Ctrl-C does."""
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (0, "")


def played_back(folder):
    """Plays a recording back, which has to be the same to the bit; returns its log."""
    run = simulate(load_scenario(str(folder / "scenario.yaml")))
    kept = np.load(folder / "log.npz")
    assert set(kept.files) == run.log.keys()
    for name, values in run.log.items():
        assert kept[name].tobytes() == values.tobytes(), name
    return run.log


def memory(pid):
    """Returns how much memory a process holds [MB]."""
    with open(f"/proc/{pid}/status") as status:
        return int(re.search(r"VmRSS:\s+(\d+)", status.read())[1]) / 1024


@pytest.mark.realtime
@pytest.mark.timeout(400)
def test_two_minutes_of_driving_leak_nothing_keep_time_and_play_back_bit_for_bit(
    browser, tmp_path
):
    folder = tmp_path / "session"
    with mobman_drive("kwon_spatial", "--record", folder) as (process, address):
        with Console(browser, address) as console:
            drive_about(console, 20.0, seed=1)  # By then, all is imported and cached.
            before = memory(process.pid)
            drive_about(console, 100.0, seed=2)
            assert memory(process.pid) < before + 20.0
            assert console.errors == []
        ended(process)
    log = played_back(folder)
    assert log["time"][-1] > 115.0
    assert len(np.unique(log["gate_status"])) > 2
    assert np.abs(log["base_command_smoothed"]).max() > 0.1
    # Its loop never hurries, and falls behind only where the machine does.
    factor = json.loads((folder / "metrics.json").read_text())["real_time_factor"]
    assert 0.9 < factor < 1.001


def test_recording_begun_and_ended_on_the_page_plays_back_bit_for_bit(
    browser, tmp_path
):
    with mobman_drive("kwon_arbitrary", folder=tmp_path) as (process, address):
        with Console(browser, address) as console:
            console.says(role="you", arming="ready")
            console.page.click(".button.record")
            console.says(recording="on", arming="ready")
            assert "recording to" in console.page.inner_text(".fact.recording")
            end = time.monotonic() + 1.0
            drives = lambda: console.status == "driving"  # noqa: E731
            console.drive(lambda: drives() and time.monotonic() > end, "it drives")
            console.release()
            console.page.click(".end_record")
            console.says(recording="off")
            assert console.page.is_visible(".button.record")
        ended(process)
    (folder,) = (tmp_path / "runs").iterdir()
    assert folder.name.startswith("kwon_arbitrary-")
    log = played_back(folder)
    assert np.abs(log["ee_command"]).max() > 0.0


@pytest.mark.skipif(not CAN_DRAG, reason="this Meshcat knows nothing of dragging")
def test_arm_is_pulled_by_control_and_the_mouse_and_played_back_bit_for_bit(
    browser, tmp_path
):
    folder = tmp_path / "session"
    with mobman_drive("petric_guided", "--record", folder) as (process, address):
        with Console(browser, address) as console:
            console.says(role="you", arming="ready")
            x, y = middle_of_link(console, "link6")
            mouse, keys = console.page.mouse, console.page.keyboard
            mouse.move(x, y)
            mouse.down()  # Without Control, it turns the picture.
            mouse.move(x + 10, y)
            mouse.up()
            console.page.wait_for_timeout(300)
            console.says(arming="ready")

            keys.down("Control")
            x, y = pulled(console, "link6", 150, seconds=4.0)
            # The picture has the focus, and Escape stops all the same.
            keys.press("Escape")
            console.until(lambda: "stopped by the operator" in console.status, "stop")
            mouse.move(x + 10, y)
            console.page.wait_for_timeout(300)
            assert "release stick and dead-man" in console.status
            mouse.up()
            console.says(arming="ready")
            # It is let go just as well where the attention goes elsewhere.
            grabbed(console, "link6")
            console.frame.evaluate("window.dispatchEvent(new Event('blur'))")
            console.until(lambda: "dead-man released" in console.status, "it stops")
            mouse.up()
            keys.up("Control")
            assert console.errors == []
        ended(process)
    log = played_back(folder)
    assert len(np.unique(log["drag"][:, 0])) > 1
    assert np.abs(log["hand_force"]).max() > 5.0
    assert np.linalg.norm(log["base_pose"][-1, :2]) > 0.1


def grabbed(console, link):
    """Takes hold of a link until that counts; returns where [pixels]."""
    mouse = console.page.mouse
    where = []

    def press():
        where[:] = middle_of_link(console, link)
        mouse.move(*where)
        mouse.down()

    console.takes(press, mouse.up)
    return where


def pulled(console, link, far, seconds):
    """Pulls a link to the right, so long without a stop; returns where to [pixels]."""
    end = time.monotonic() + PATIENCE
    while True:
        x, y = grabbed(console, link)
        console.page.mouse.move(x + far, y, steps=10)
        began = time.monotonic()
        while console.arming == "armed":
            console.page.wait_for_timeout(20)
            if time.monotonic() > began + seconds:
                return x + far, y
        assert time.monotonic() < end, console.status
        console.page.mouse.up()
        console.says(arming="ready")


def middle_of_link(console, link):
    """Returns where on the page the middle of a link is drawn [pixels]."""
    console.frame = console.page.frame(url=re.compile("/view/"))
    console.frame.wait_for_function(
        f"viewer.scene_tree.children.drake?.children.{link}"
    )
    there = console.frame.evaluate(
        """(link) => {
            const { Box3, Vector3 } = MeshCat.THREE;
            const part = viewer.scene_tree.find(["drake", link]).object;
            const middle = new Box3().setFromObject(part).getCenter(new Vector3());
            const { x, y } = middle.project(viewer.camera);
            return [(1 + x) / 2 * innerWidth, (1 - y) / 2 * innerHeight];
        }""",
        link,
    )
    box = console.page.locator(".scene").bounding_box()
    return box["x"] + there[0], box["y"] + there[1]


def test_meshcat_alone_drives_too_and_only_while_its_page_draws(browser):
    # A busy machine takes its time to draw.
    scenario = load_scenario("kwon_arbitrary", ["gate.fresh=1.0"])
    with LiveSession(scenario) as session:
        meshcat = local_meshcat("127.0.0.1")
        panel = MeshcatPanel(session, meshcat)
        # So small that it is drawn quickly.
        page = browser.new_page(viewport={"width": 320, "height": 240})
        page.goto(f"{meshcat.web_url()}/?tracked_camera=on")

        def until(condition, what):
            end = time.monotonic() + PATIENCE
            while not condition():
                assert time.monotonic() < end, what
                panel.step()
                page.wait_for_timeout(10)

        until(lambda: session.snapshot().arming == Arming.READY, "its page is there")

        def drives():
            page.keyboard.down("Space")  # A key that is held is repeated.
            return session.snapshot().text == "driving"

        def moves():
            page.keyboard.press("ArrowUp")
            return drives() and signal_of(session, "ee_command")[0] > 0.1

        until(drives, "it is armed")
        until(moves, "it moves")
        page.keyboard.up("Space")
        until(lambda: rests(session), "it rests")
        assert session.snapshot().status == GateStatus.RELEASED
        until(lambda: session.snapshot().arming == Arming.READY, "its sliders are back")
        says = page.get_by_text("driving", exact=True)
        until(lambda: drives() and says.count(), "it is armed again, and says so")
        assert rests(session)
        page.keyboard.press("Escape")
        until(lambda: session.snapshot().status == GateStatus.STOPPED, "it stops")
        page.close()
        time.sleep(0.5)
        panel.step()
        assert signal_of(session, "operator_input")[4] > 0.25
