"""How quickly the pad moves the robot, and how well the console lasts.

    python benchmarks/pad_to_robot.py [--minutes 2] [SCENARIO ...]

From the browser's event to the base's or arm's commanded velocity; and from when a page
freezes at full stick until the base is at rest. Then drives by a scripted browser, with
the page open: the real-time ratio, the loop's period minute by minute, and the server's
memory. The 3D view is drawn in software. It takes Chromium, and the extra `test`.
"""

import argparse
import dataclasses as dc
import json
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from playwright.sync_api import sync_playwright
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from drake_mobman.console.addresses import listening
from drake_mobman.console.server import Server
from drake_mobman.console.session import LiveSession
from drake_mobman.decomposers.blending import Blending
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = [
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update"),
    "--disable-sync",
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
]
DRIVEN = ["kwon_arbitrary", "petric_guided"]
MOVES = 200
"""Of the pad, each of which is timed."""
FREEZES = 5
"""Of the page, likewise."""


@contextmanager
def opened(address):
    """Gives the console's page in Chromium, ready to be driven."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport={"width": 1366, "height": 768})
        page.goto(address)
        page.wait_for_selector("html[data-ready][data-role=you][data-arming=ready]")
        yield page
        browser.close()


def middle_of_pad(page):
    """Returns the pad's middle and radius [pixels]."""
    box = page.locator(".pad").bounding_box()
    radius = box["width"] / 2
    return box["x"] + radius, box["y"] + radius, radius


# --- Latency -------------------------------------------------------------------------


class Clock(LeafSystem):
    """Notes after each tick when it was [s], and what came of the operator's v_c."""

    def __init__(self, ticks):
        super().__init__()
        arm = self.DeclareVectorInputPort("arm_command", 3)
        base = self.DeclareVectorInputPort("base_contribution", 2)

        def note(context):
            v_c = arm.Eval(context)[0] + base.Eval(context)[0]  # v_m + v_bm.
            ticks.append((time.time(), v_c))

        self.DeclarePerStepPublishEvent(note)


@dc.dataclass
class Watched(Blending):
    """Blending, with a clock at its outputs."""

    def __post_init__(self):
        self.ticks = []

    def build(self, setup):
        """Returns the block and the clock in a diagram, with the block's ports."""
        builder = DiagramBuilder()
        block = builder.AddSystem(super().build(setup))
        clock = builder.AddSystem(Clock(self.ticks))
        for i in range(block.num_input_ports()):
            port = block.get_input_port(i)
            builder.ExportInput(port, port.get_name())
        for i in range(block.num_output_ports()):
            port = block.get_output_port(i)
            builder.ExportOutput(port, port.get_name())
            if clock.HasInputPort(port.get_name()):
                builder.Connect(port, clock.GetInputPort(port.get_name()))
        return builder.Build()


def latencies_and_stops():
    """Returns the times [s] from the pad's events to the robot's commanded velocity.

    And those from when the page freezes until the robot is at rest.
    """
    # What has no smoother stops at once; here the base has to brake.
    scenario = load_scenario("kwon_arbitrary", ["smoother=smoother"])
    watched = Watched(**vars(scenario.decomposer))
    scenario = dc.replace(scenario, decomposer=watched)
    ticks = watched.ticks
    with LiveSession(scenario) as session:
        server = Server("kwon_arbitrary", session, listening(port=0))
        thread = threading.Thread(target=server.run)
        thread.start()
        with opened(server.address) as page:
            events = push_about(page)
            stops = [stop_time(page, session) for _ in range(FREEZES)]
        server.close()
        thread.join()
    at, moved = np.array(ticks).T
    most = scenario.guard.max_v_c
    found = []
    for sent, share in events:
        there = (at >= sent) & (abs(moved - share * most) < 1e-9)
        if there.any():
            found.append(at[there.argmax()] - sent)
    print(f"{len(found)} of {len(events)} moves of the pad reached the robot")
    return np.array(found), np.array(stops)


def stop_time(page, session):
    """Freezes the page at full stick; returns how long until the robot rests [s]."""
    most = 0.9 * session.scenario.guard.max_v_c
    read = lambda name: np.abs(session.snapshot().signals[name])  # noqa: E731
    x, y, radius = middle_of_pad(page)
    while read("base_command_smoothed")[0] < most:
        page.wait_for_timeout(20)
        if page.get_attribute("html", "data-arming") == "latched":  # By a hitch.
            page.mouse.up()
            page.wait_for_selector("html[data-arming=ready]")
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x, y - radius)
    devtools = page.context.new_cdp_session(page)
    devtools.send("Debugger.enable")
    began = time.monotonic()
    devtools.send("Debugger.pause")  # Nothing runs in it any more.
    while read("base_velocity").any() or read("arm_velocity").any():
        time.sleep(0.002)
    took = time.monotonic() - began
    devtools.send("Debugger.disable")
    page.mouse.up()
    page.wait_for_selector("html[data-arming=ready]")
    return took


def push_about(page):
    """Pushes the pad to and fro; returns when, by our clock [s], and how far."""
    page.evaluate(
        """() => {
            window.moves = [];
            const pad = document.querySelector(".pad");
            pad.addEventListener("pointermove", (event) => moves.push([
                performance.timeOrigin + event.timeStamp,
                Number(pad.style.getPropertyValue("--y")),
            ]));
        }"""
    )
    x, y, radius = middle_of_pad(page)
    page.mouse.move(x, y)
    page.mouse.down()
    page.wait_for_selector("html[data-arming=armed]")
    rng = np.random.default_rng(0)
    for k in range(MOVES):
        way = (-1) ** (k // 4)  # The arm stays within its workspace.
        page.mouse.move(x, y - way * radius * rng.uniform(0.2, 0.75))
        page.wait_for_timeout(rng.uniform(60, 140))
    page.mouse.up()
    offset = clock_offset(page)
    moves = page.evaluate("moves")
    # Those before the pad was held moved nothing, and are no less than the first one.
    return [(at / 1e3 - offset, share) for at, share in moves if share]


def clock_offset(page):
    """Returns by how much the page's clock is ahead of ours [s], at its surest."""
    best = (np.inf, 0.0)
    for _ in range(50):
        before = time.time()
        theirs = page.evaluate("performance.timeOrigin + performance.now()") / 1e3
        after = time.time()
        best = min(best, (after - before, theirs - (before + after) / 2))
    return best[1]


# --- Endurance -----------------------------------------------------------------------


def lasts(name, minutes):
    """Drives by the command line and a scripted browser, and prints how it went."""
    with tempfile.TemporaryDirectory() as parent:
        folder = Path(parent) / name
        command = [sys.executable, "-u", "-m", "drake_mobman", "drive", name]
        process = subprocess.Popen(
            [*command, "--port", "0", "--record", str(folder)],
            stdout=subprocess.PIPE,
            text=True,
        )
        address = re.search(r"http://\S+(?=;)", process.stdout.readline())[0]
        with opened(address) as page:
            drive_about(page, 20.0)  # By then, all is imported and cached.
            before = memory(process.pid)
            stretches = [min(1.0, minutes)] * max(1, round(minutes))
            ratios = [ratio_while_driven(page, 60 * stretch) for stretch in stretches]
            after = memory(process.pid)
        process.send_signal(signal.SIGINT)
        process.wait()
        numbers = json.loads((folder / "metrics.json").read_text())
        kept = np.load(folder / "log.npz")
        scenario = load_scenario(str(folder / "scenario.yaml"))
        run = simulate(scenario)
        intact = all(kept[k].tobytes() == x.tobytes() for k, x in run.log.items())
    ticks = 1e3 * scenario.period / np.array(ratios)
    print(
        f"{name}: real-time ratio {numbers['real_time_factor']:.4f} over "
        f"{run.log['time'][-1]:.0f} s, period {ticks[0]:.2f} ms in the first minute, "
        f"{ticks[-1]:.2f} in the last, {ticks.min():.2f} to {ticks.max():.2f} in all; "
        f"memory {before:.1f} -> {after:.1f} MB in {minutes:g} min, recording "
        f"{'intact' if intact else 'NOT INTACT'}"
    )


def memory(pid):
    """Returns how much memory a process holds [MB]."""
    status = Path(f"/proc/{pid}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", status)[1]) / 1024


def ratio_while_driven(page, seconds):
    """Drives for a while; returns simulated over wall time meanwhile."""
    start, began = simulated(page), time.monotonic()
    drive_about(page, seconds)
    return (simulated(page) - start) / (time.monotonic() - began)


def simulated(page):
    """Returns the time that the page shows, when that has just changed [s]."""
    shown = "document.querySelector('.time').textContent"
    page.wait_for_function(f"shown => {shown} !== shown", arg=page.evaluate(shown))
    return float(page.evaluate(shown).split()[0])


def drive_about(page, seconds):
    """Drives as a person would who tries the pad."""
    rng = np.random.default_rng(0)
    x, y, radius = middle_of_pad(page)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        page.wait_for_selector("html[data-arming=ready]")
        page.mouse.move(x, y)
        page.mouse.down()
        for _ in range(int(rng.integers(1, 30))):
            dx, dy = radius * rng.uniform(-0.7, 0.7, 2)
            page.mouse.move(x + dx, y + dy, steps=5)
            page.wait_for_timeout(rng.uniform(50, 400))
        page.mouse.up()


def main():
    """Prints all of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=2.0, help="of each drive")
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", default=DRIVEN)
    given = parser.parse_args()
    latencies, stops = latencies_and_stops()
    median, p99 = 1e3 * np.percentile(latencies, [50, 99])
    print(f"pad to robot: median {median:.0f} ms, p99 {p99:.0f} ms")
    shown = ", ".join(f"{stop:.2f}" for stop in stops)
    print(f"page frozen at full stick: base at rest after {shown} s")
    for name in given.scenarios:
        lasts(name, given.minutes)


if __name__ == "__main__":
    main()
