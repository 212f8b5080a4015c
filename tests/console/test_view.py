"""The picture: the robot in the middle, the world beneath it, and the floor in that.

What is held against it is what is really shown: by Meshcat, or by Chromium, in W's axes
about the picture's middle.
"""

import dataclasses as dc
import json
import re
import shutil
import signal
import struct
import subprocess
import sys
import threading
import time
from contextlib import contextmanager, suppress

import numpy as np
import pytest
from pydrake.multibody.tree import BodyIndex
from websockets.sync.client import connect

from drake_mobman.console.frame import Frame
from drake_mobman.console.mailbox import OperatorInput
from drake_mobman.console.meshcat_panel import MeshcatPanel
from drake_mobman.console.session import LiveSession
from drake_mobman.console.view import Picture, picture_page
from drake_mobman.meshcat import offline_meshcat
from drake_mobman.robot_model.model import drawn_plant
from drake_mobman.robots.file import File
from drake_mobman.scenario import load_scenario
from drake_mobman.scenario.fitted import fitted_teleop
from drake_mobman.scenario_files import robot_paths
from drake_mobman.teleop.gate import Arming

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

CELL = 0.5
"""Width of the floor's cells [m]."""

FAR = 20.0
"""How far is driven [m]."""

PATIENCE = 60.0
"""Of a test that waits for what is to happen soon [s]."""

DIGITS = 1e-5
"""By how much a picture may be off [m]: browsers are told six digits."""


FAST = ["guard.max_v_c=4.0", "smoother=unsmoothed", "gate.fresh=5.0"]
"""Of a scenario that goes far in a few seconds, on a busy machine too."""


class Drive:
    """A session that is driven ahead, fast, from a thread of its own."""

    def __init__(self):
        self.session = LiveSession(load_scenario("kwon_arbitrary", FAST))
        self.goes = threading.Event()
        self.ended = threading.Event()
        self.thread = threading.Thread(target=self.run)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.ended.set()
        self.thread.join()
        self.session.close()

    def run(self):
        sequence = 0
        while not self.ended.wait(0.02):
            sequence += 1
            arming = self.session.snapshot().arming
            goes = self.goes.is_set() and self.way < FAR
            v_c = 4.0 if goes and arming == Arming.ARMED else 0.0
            pressed = arming != Arming.LATCHED
            self.session.send(OperatorInput(sequence, v_c, 0.0, 0.0, pressed))

    @property
    def way(self):
        """Returns how far the base is from where it started [m]."""
        pose = self.session.snapshot().signals.get("base_pose", (0.0, 0.0, 0.0))
        return float(np.hypot(*pose[:2]))

    @property
    def base(self):
        return np.array(self.session.snapshot().signals["base_pose"][:2])


def stands_still_in_the_world(floor, world):
    """Asserts that the floor is about the middle, and its lines are fixed in W.

    Args:
        floor: place (x, y) of the floor's middle [m].
        world: the same of W's origin.
    """
    cells = (np.array(floor) - world) / CELL
    assert cells == pytest.approx(np.round(cells), abs=10 * DIGITS)
    assert np.abs(floor).max() <= CELL + DIGITS


def held_place(meshcat, path):
    """Returns where in the picture Meshcat holds the origin of an absolute path."""
    X = np.eye(4)
    names = path.strip("/").split("/")
    for i in range(len(names)):
        packed = meshcat._GetPackedTransform("/" + "/".join(names[: i + 1]))
        if packed:
            # Sixteen numbers at the end, each after a byte that says what it is.
            numbers = [x[0] for x in struct.iter_unpack(">xd", packed[-16 * 9 :])]
            X = X @ np.reshape(numbers, (4, 4), order="F")
    return X[:2, 3]


def test_floor_in_meshcat_stands_still_for_twenty_meters():
    with Drive() as drive:
        meshcat = offline_meshcat()
        panel = MeshcatPanel(drive.session, meshcat)
        ways = []
        drive.goes.set()
        end = time.monotonic() + PATIENCE
        while drive.way < FAR:
            assert time.monotonic() < end, "it gets there"
            panel.step()
            (floor,) = [x for x in ("/floor", "/drake/floor") if meshcat.HasPath(x)]
            world = held_place(meshcat, "/world")
            stands_still_in_the_world(held_place(meshcat, floor), world)
            assert held_place(meshcat, "/world/base") == pytest.approx(0, abs=1e-9)
            ways.append(np.linalg.norm(world))
            time.sleep(0.02)
    assert max(ways) > FAR - 1
    # Twice the speed would be seen in each of these.
    assert len({round(way / CELL) for way in ways}) > 10


@pytest.mark.parametrize("name", ["kwon_arbitrary", "petric_guided"])
def test_all_that_is_drawn_has_its_place_by_an_absolute_path(name):
    scenario = load_scenario(name)
    meshcat = offline_meshcat()
    Picture(scenario, ["hand_position"]).draw(meshcat)
    # Meshcat puts what has a relative path there, as it does what may be dragged.
    assert not meshcat.HasPath("/drake")
    assert meshcat.HasPath("/floor")
    assert meshcat.HasPath("/world/base")


def test_frame_tells_what_moved_and_lines_begin_anew_after_a_reset():
    with Drive() as drive:
        picture = Picture(drive.session.scenario, drive.session.signals)
        drive.goes.set()
        until(lambda: drive.way > 1.0, "it drives")
        first = picture.at(drive.session.snapshot())
        assert first.message(first) == {"poses": {}, "lines": {}}
        until(lambda: drive.way > 2.0, "it drives on")
        second = picture.at(drive.session.snapshot())
        news = second.since(first)
        assert {"/world", "/drake", "/world/base"} <= news.poses.keys()
        (path,) = [x for x in second.trails if "base" in x]
        assert second.message(first)["lines"][path]["keep"] == 1
        ((x, y, _),) = second.message(first)["lines"][path]["add"]
        assert (x, y) == pytest.approx(drive.base, abs=1.0)
        drive.session.reset()
        until(lambda: drive.session.snapshot().time < 0.5, "it starts over")
        third = picture.at(drive.session.snapshot())
        for line in third.message(second)["lines"].values():
            assert (line["keep"], len(line["add"])) == (0, 1)


def until(condition, what):
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, what
        time.sleep(0.01)


def test_lines_are_bounded_and_told_whole_to_whoever_hears_how_often():
    with Drive() as drive:
        until(lambda: "base_pose" in drive.session.snapshot().signals, "it runs")
        snapshot = drive.session.snapshot()
    picture = Picture(load_scenario("kwon_arbitrary"), snapshot.signals)
    rng = np.random.default_rng(1)
    shown, drawn, way = Frame(), {}, 0.0
    for i in range(1500):
        way += 0.03
        moved = snapshot.signals | {"base_pose": (way, 0.0, 0.0)}
        # Started over twice.
        time_ = float(i % 600)
        frame = picture.at(dc.replace(snapshot, signals=moved, time=time_))
        if rng.random() < 0.02:
            for path, news in frame.message(shown)["lines"].items():
                before = drawn.get(path, [])
                drawn[path] = before[len(before) - news["keep"] :] + news["add"]
            shown = frame
            for path, trail in frame.trails.items():
                assert drawn[path] == pytest.approx(np.array(trail.points), abs=1e-4)
                assert len(trail.points) == min(int(time_) + 1, 400)


def test_page_of_the_picture_is_whole_by_itself():
    scenario = load_scenario("petric_guided")
    page = picture_page(Picture(scenario, ["hand_position"], ["link3"]))
    assert not re.search(r"new WebSocket\(url\)", page)
    assert not re.search(r"""src=["'](?!data:)""", page)


# --- In the browser ------------------------------------------------------------------

FLAGS = [
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update"),
    # The 3D view is drawn in software.
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
]

PLACES = """() => {
    // Meshcat's scene has W's axes, and is turned as a whole.
    const { scene, scene_tree } = viewer;
    scene.updateMatrixWorld(true);
    if (!scene_tree.children.world?.children.base) return null;
    const place = (...path) => {
        const { object } = scene_tree.find(path);
        const at = object.localToWorld(new MeshCat.THREE.Vector3());
        return scene.worldToLocal(at).toArray().slice(0, 2);
    };
    const below = (name) => Object.keys(scene_tree.find([name]).children).sort();
    return {
        floor: place("floor"), world: place("world"), base: place("world", "base"),
        paths: Object.keys(scene_tree.children), drake: below("drake"),
        points: scene_tree.find(["world", "base_trail", "<object>"])
            .object.geometry.attributes.position.count,
    };
}"""


@contextmanager
def mobman_drive(folder):
    """Runs `mobman drive`, recording to a folder; gives the page's host and port."""
    options = [x for one in FAST for x in ("--set", one)]
    command = [sys.executable, "-u", "-m", "drake_mobman", "drive"]
    process = subprocess.Popen(
        [*command, "kwon_arbitrary", *options, "--port", "0", "--record", str(folder)],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        line = process.stdout.readline()
        yield re.search(r"http://(\S+)/;", line)[1]
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=PATIENCE) == 0
    finally:
        process.kill()
        process.communicate()


class Wire:
    """Drives ahead by a socket, as the console's page does."""

    def __init__(self, socket):
        self.socket = socket
        self.sequence = 0
        self.state = json.loads(socket.recv(timeout=PATIENCE))

    def drives(self, v_c=1.0):
        with suppress(TimeoutError):
            while True:
                self.state = json.loads(self.socket.recv(timeout=0.001))
        self.sequence += 1
        armed = self.state["arming"] == Arming.ARMED
        said = {
            "sequence": self.sequence,
            "v_c": v_c if armed else 0.0,
            "omega_c": 0.0,
            "v_z": 0.0,
            "dead_man": self.state["arming"] != Arming.LATCHED,
            # Its clock is ours.
            "sent": time.monotonic(),
            "ahead": 0.0,
        }
        self.socket.send(json.dumps(said))


@pytest.mark.realtime
@pytest.mark.browser
@pytest.mark.skipif(not CHROMIUM, reason="there is no Chromium")
def test_floor_in_the_browser_stands_still_for_twenty_meters(tmp_path):
    playwright_api = pytest.importorskip("playwright.sync_api")
    ways = []
    with (
        mobman_drive(tmp_path / "session") as own,
        connect(f"ws://{own}/drive", origin=f"http://{own}") as socket,
        playwright_api.sync_playwright() as playwright,
    ):
        wire = Wire(socket)  # First, and so who drives; the page watches.
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport={"width": 500, "height": 500})
        page.goto(f"http://{own}/")
        page.wait_for_selector("html[data-ready][data-role]")
        frame = page.frame(url=re.compile("/view/"))
        frame.wait_for_function("!!window.viewer?.connection?.send")
        until(lambda: frame.evaluate(PLACES), "it shows the robot")
        end = time.monotonic() + PATIENCE
        while not ways or max(ways) < FAR:
            assert time.monotonic() < end, "it gets there"
            wire.drives()
            seen = frame.evaluate(PLACES)
            stands_still_in_the_world(seen["floor"], seen["world"])
            assert seen["base"] == pytest.approx([0, 0], abs=DIGITS)
            ways.append(np.linalg.norm(seen["world"]))
            frame.wait_for_timeout(20)
        wire.drives(0.0)
        frame.wait_for_timeout(1000)
        seen = frame.evaluate(PLACES)
        browser.close()
    assert len({round(way / CELL) for way in ways}) > 10
    # Where it really went.
    path = np.load(tmp_path / "session" / "log.npz")["base_pose"][:, :2]
    assert seen["world"] == pytest.approx(-path[-1], abs=1e-3)
    assert np.linalg.norm(path[-1]) > FAR
    assert seen["points"] > 20
    assert seen["drake"] == []
    assert "floor" in seen["paths"]


@pytest.mark.parametrize("name", ["ur5_husky", "gen3"])
def test_bodies_of_one_name_in_two_models_are_all_drawn(name):
    robot = File(str(robot_paths()[name]))
    picture = Picture(fitted_teleop(robot), ())
    drawn = {}

    class Drawing:
        """A Meshcat that keeps what is set at each path."""

        def SetObject(self, path, *_):
            drawn[path] = drawn.get(path, 0) + 1

        def __getattr__(self, _):
            return lambda *_: None

    picture.draw(Drawing())
    assert set(drawn.values()) == {1}
    plant, _ = drawn_plant(robot)
    shapes = [
        len(plant.GetVisualGeometriesForBody(plant.get_body(BodyIndex(i))))
        for i in range(plant.num_bodies())
    ]
    assert len(drawn) == sum(shapes)
