"""A live session: in real time, and safe from whatever its operator does.

Times here are generous: what is asked for holds on a busy machine, too.
"""

import json
import os
import pty
import re
import subprocess
import sys
import threading
import time
import urllib.request
from contextlib import suppress

import pytest

from drake_mobman.console.mailbox import OperatorInput
from drake_mobman.console.session import LiveSession
from drake_mobman.scenario import load_scenario
from drake_mobman.teleop.gate import Arming, GateStatus

PATIENCE = 20.0
"""Of a test that waits for what is to happen at once [s]."""


def scenario_of(name="kwon_arbitrary", *overrides):
    return load_scenario(name, overrides)


def until(condition, what):
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, what
        time.sleep(0.01)


class Stick:
    """An operator's device: says the same 50 times a second, until told otherwise."""

    def __init__(self, session):
        self.session = session
        self.command, self.dead_man = (0.0, 0.0, 0.0), False
        self.sequence = 0
        self.speaks, self.ended = threading.Event(), threading.Event()
        self.speaks.set()
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.ended.set()
        self.thread.join()

    def run(self):
        while not self.ended.wait(0.02):
            if self.speaks.is_set():
                self.sequence += 1
                said = OperatorInput(self.sequence, *self.command, self.dead_man)
                self.session.send(said)

    def arm(self, *command):
        """Lets go, presses, and pushes."""
        self.command, self.dead_man = (0.0, 0.0, 0.0), False
        shown = self.session.snapshot
        until(lambda: shown().arming == Arming.READY, "it gets ready")
        self.dead_man = True
        until(lambda: shown().status == GateStatus.OK, "it is armed")
        self.command = command


def stopped_by(session, status):
    until(lambda: session.snapshot().status == status, f"it stops: {status!r}")
    until(lambda: session.snapshot().signals["ee_command"] == (0, 0, 0), "it rests")


def test_stick_moves_the_robot_and_every_way_to_stop_it_says_why():
    with LiveSession(scenario_of()) as session, Stick(session) as stick:
        until(lambda: session.snapshot().time > 0.1, "it runs")
        assert session.snapshot().status == GateStatus.NOT_ARMED
        reach = session.snapshot().signals["ee_cylindrical"][0]
        stick.arm(0.3, 0.0, 0.0)
        until(
            lambda: session.snapshot().signals["ee_cylindrical"][0] > reach + 0.1,
            "moves",
        )
        assert session.snapshot().text == "driving"

        stick.dead_man = False
        stopped_by(session, GateStatus.RELEASED)
        stick.arm(0.1, 0.0, 0.0)
        stick.speaks.clear()
        stopped_by(session, GateStatus.STALE)
        stick.speaks.set()
        stick.arm(0.1, 0.0, 0.0)
        stick.command = (0.1, float("nan"), 0.0)
        stopped_by(session, GateStatus.NOT_FINITE)
        stick.arm(0.1, 0.0, 0.0)
        stick.command = (0.1, 4.0, 0.0)
        stopped_by(session, GateStatus.OVER_RANGE)
        stick.arm(0.1, 0.0, 0.0)
        session.stop("a viewer")
        stopped_by(session, GateStatus.STOPPED)
        assert session.snapshot().text.startswith("stopped by a viewer; ")
        stick.arm(0.1, 0.0, 0.0)
        session.release()
        stick.sequence = 0  # Another's device, which counts from where it likes.
        stopped_by(session, GateStatus.GONE)
        stick.arm(0.1, 0.0, 0.0)


def test_it_keeps_to_the_wall_clock():
    with LiveSession(scenario_of()) as session:
        until(lambda: session.snapshot().time > 0, "it runs")
        began, simulated = time.monotonic(), session.snapshot().time
        time.sleep(2.0)
        went = session.snapshot().time - simulated
        assert went == pytest.approx(time.monotonic() - began, abs=0.5)
        assert session.snapshot().real_time_factor > 0.7


def test_snapshot_tells_all_that_a_page_shows():
    with LiveSession(scenario_of()) as session:
        until(lambda: session.snapshot().time > 0, "it runs")
        shown = session.snapshot()
        for name, size in (
            ("ee_cylindrical", 3),
            ("base_contribution", 2),
            ("arm_command", 3),
            ("base_command_smoothed", 2),
            ("base_pose", 3),
            ("arm_position", 2),
            ("operator_input", 14),
        ):
            assert len(shown.signals[name]) == size
        json.dumps(shown.signals["base_pose"])
        assert shown.choice == session.choices[0] == "blending"
        assert shown.problem == shown.died == ""
        assert shown.recording is None


def test_choice_is_of_those_that_work_with_the_robot():
    with LiveSession(scenario_of("petric_guided")) as session:
        assert session.choices == ["field, projected", "field, printed"]
    with LiveSession(scenario_of()) as session:
        for name in ("blending", "switching", "exact", "field, printed"):
            assert name in session.choices
        session.choose("switching")
        until(lambda: session.snapshot().choice == "switching", "it is chosen")
        with pytest.raises(ValueError, match="valid names are 'blending'"):
            session.choose("magic")


def test_reset_starts_over_and_asks_to_be_armed_again():
    with LiveSession(scenario_of()) as session, Stick(session) as stick:
        stick.arm(0.3, 0.0, 0.0)
        until(lambda: session.snapshot().time > 0.5, "it runs")
        session.reset()
        until(lambda: session.snapshot().time < 0.4, "it starts over")
        time.sleep(0.3)  # The dead-man is held all along.
        assert session.snapshot().status == GateStatus.NOT_ARMED
        assert session.snapshot().signals["ee_cylindrical"][0] == pytest.approx(1.0)


def test_closing_twice_is_closing():
    session = LiveSession(scenario_of())
    session.close()
    session.close()
    time_ = session.snapshot().time
    time.sleep(0.1)
    assert session.snapshot().time == time_


@pytest.mark.parametrize("screen", ["", ":0"])
def test_browser_opens_by_itself_where_there_is_a_screen(tmp_path, screen):
    opened, browser = tmp_path / "opened", tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\necho "$1" > {opened}\n')
    browser.chmod(0o755)
    command = [sys.executable, "-m", "drake_mobman", "drive", "kwon_1"]
    us, them = pty.openpty()  # A person's terminal.
    process = subprocess.Popen(
        [*command, "--port", "0"],
        stdout=them,
        stderr=them,
        env=os.environ
        | {"BROWSER": str(browser), "DISPLAY": screen, "WAYLAND_DISPLAY": ""},
    )
    os.close(them)
    try:
        said = ""
        while "Ctrl-C" not in said:
            said += os.read(us, 1000).decode()
        address = re.search(r"http://\S+(?=;)", said)[0]
        if screen:
            until(lambda: opened.exists() and opened.read_text(), "it is opened")
            assert opened.read_text() == f"{address}\n"
        else:
            until(lambda: answers(address), "it serves")
            assert not opened.exists()
    finally:
        process.kill()
        process.wait()
        os.close(us)


def answers(address):
    """Returns whether a page is served."""
    with suppress(OSError), urllib.request.urlopen(address) as answer:
        return answer.status == 200
    return False
