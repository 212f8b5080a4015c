"""Driving from Meshcat's own panel, without the page: sliders, keys and a gamepad.

Meshcat reports that a key is pressed, but never that it is released: a tap of the space
bar counts as held for `FIRST_HOLD`, and a release is noticed up to `REPEAT_HOLD` late.
Nor does it report who presses, or whether the page has the focus: all who have it open
drive at once.
"""

import math
import time
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform

from drake_mobman.console.frame import Frame
from drake_mobman.console.mailbox import OperatorInput
from drake_mobman.console.snapshot import Snapshot
from drake_mobman.console.view import TRAIL_COLORS, Picture
from drake_mobman.scenario import AnyScenario

SLIDERS = {
    "out (up, down)": ("ArrowDown", "ArrowUp"),
    "left (left, right)": ("ArrowRight", "ArrowLeft"),
    "up (R, F)": ("KeyF", "KeyR"),
}
"""Sliders of v_c, omega_c and v_z, as shares of the largest, and the keys that move
them."""

HOLD = "hold to drive (space)"
STOP = "STOP (Esc)"
RESET = "start over"

FIRST_HOLD = 0.8
"""How long a key counts as held after it was pressed [s]: its first repetition comes
half a second later or more."""

REPEAT_HOLD = 0.35
"""The same after a repetition [s]; a page that is busy drawing reports it late."""

_TRIGGERS = (6, 7)
"""Buttons of a gamepad that are its dead-man."""

_DEAD_ZONE = 0.12
"""Of a gamepad's sticks, which do not quite return to the middle."""


class KeyHold:
    """Finds out whether a key is held from the clicks that its repetition makes.

    Args:
        clock: monotonic wall clock [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._clicks = 0
        self._until = -math.inf

    def is_held(self, clicks: int) -> bool:
        """Returns whether it is held, given the number of clicks since the start."""
        now = self._clock()
        if clicks > self._clicks:
            repeated = now <= self._until
            self._until = now + (REPEAT_HOLD if repeated else FIRST_HOLD)
        self._clicks = clicks
        return now <= self._until


class Heartbeat:
    """Finds out whether a page in the browser is alive: it draws what it receives.

    Meshcat reports a slider only when it is moved, and so nothing about a page that is
    frozen, hidden or closed. But a page that is opened with `tracked_camera=on` reports
    the pose of its camera whenever it draws. So the camera is moved, too little to see.

    Args:
        meshcat: that the page shows.
    """

    def __init__(self, meshcat: Any) -> None:
        self._meshcat = meshcat
        self._count = 0
        self._last: Any = None

    def beat(self) -> bool:
        """Returns whether the page has drawn anything new since the last call."""
        self._count += 1
        shake = [0.0, 0.0, 1e-6 * (self._count % 100)]
        self._meshcat.SetTransform("/Cameras/default", RigidTransform(shake))
        pose = self._meshcat.GetTrackedCameraPose()
        place = None if pose is None else pose.translation().tolist()
        drawn = place is not None and place != self._last
        self._last = place
        return drawn


class PanelSession(Protocol):
    """What a panel uses of a session: see `LiveSession`."""

    scenario: AnyScenario
    signals: frozenset[str]
    choices: list[str]

    def send(self, operator_input: OperatorInput) -> Any:
        """Takes the operator's input."""

    def stop(self, who: str) -> None:
        """Stops the robot."""

    def choose(self, name: str) -> None:
        """Lets one of `choices` drive."""

    def reset(self) -> None:
        """Starts over, disarmed."""

    def snapshot(self) -> Snapshot:
        """Returns the session as it is."""


class MeshcatPanel:
    """Meshcat's panel as an operator's input device.

    Its commands go through the same gate as those of the page. All calls come from the
    thread that made `meshcat`.

    Args:
        session: that is driven.
        meshcat: to which sliders and buttons are added.
    """

    def __init__(self, session: PanelSession, meshcat: Meshcat) -> None:
        self._session = session
        self._meshcat = meshcat
        self._picture = Picture(session.scenario, session.signals)
        self._picture.draw(meshcat)
        self._shown = Frame()
        self._heartbeat = Heartbeat(self._meshcat)
        self._key = KeyHold()
        self._held = False
        self._sequence = 0
        self._status = ""
        self._choices = {f"by {name}": name for name in session.choices}
        for name, (less, more) in SLIDERS.items():
            self._meshcat.AddSlider(name, -1.0, 1.0, 0.1, 0.0, less, more)
        self._meshcat.AddButton(HOLD, "Space")
        self._meshcat.AddButton(STOP, "Escape")
        self._clicks = dict.fromkeys((STOP, RESET, *self._choices), 0)
        for name in (RESET, *self._choices):
            self._meshcat.AddButton(name)

    def step(self) -> None:
        """Sends the operator's input to the session, and draws the robot."""
        self._check_buttons()
        held, command = self._input()
        if self._held and not held:
            self._center_sliders()
        self._held = held
        if self._heartbeat.beat():
            self._sequence += 1
            largest = self._session.scenario.guard.largest
            v_c, omega_c, v_z = (x * y for x, y in zip(command, largest, strict=True))
            self._session.send(OperatorInput(self._sequence, v_c, omega_c, v_z, held))
        snapshot = self._session.snapshot()
        self._show(self._picture.at(snapshot))
        if snapshot.text != self._status:
            self._show_status(snapshot.text)

    def _show(self, frame: Frame) -> None:
        """Moves what has moved since the last call."""
        changes = frame.since(self._shown)
        for path, X in changes.poses.items():
            self._meshcat.SetTransform(path, X)
        for path, trail in changes.trails.items():
            # Meshcat draws no line of less than two points.
            points = np.array([*trail.points, trail.points[-1]]).T
            self._meshcat.SetLine(path, points, 3, TRAIL_COLORS[path])
        self._shown = frame

    def _input(self) -> tuple[bool, list[float]]:
        """Returns whether a dead-man is held, and the command in shares."""
        pad_held, pad = _gamepad(self._meshcat.GetGamepad())
        key_held = self._key.is_held(self._meshcat.GetButtonClicks(HOLD))
        sliders = map(self._meshcat.GetSliderValue, SLIDERS)
        both = zip(sliders, pad, strict=True)
        return key_held or pad_held, [max(-1.0, min(1.0, a + b)) for a, b in both]

    def _show_status(self, text: str) -> None:
        """Shows the status as a button, as Meshcat has no other text."""
        if self._status:
            self._meshcat.DeleteButton(self._status)
        self._meshcat.AddButton(text)
        self._status = text

    def _center_sliders(self) -> None:
        """Centers the sliders with the dead-man, or nobody could arm again."""
        for name in SLIDERS:
            self._meshcat.SetSliderValue(name, 0.0)

    def _check_buttons(self) -> None:
        """Does what the buttons are for that were pressed since the last call."""
        for name, before in self._clicks.items():
            self._clicks[name] = clicks = self._meshcat.GetButtonClicks(name)
            if clicks == before:
                continue
            if name == STOP:
                self._session.stop("the operator")
            elif name == RESET:
                self._session.reset()
            else:
                self._session.choose(self._choices[name])


def _gamepad(pad: Any) -> tuple[bool, list[float]]:
    """Returns whether a trigger is held, and the sticks' command in shares."""
    if pad.index is None:
        return False, [0.0, 0.0, 0.0]
    buttons = dict(enumerate(pad.button_values))
    axes = dict(enumerate(pad.axes))
    held = any(buttons.get(i, 0.0) > 0.5 for i in _TRIGGERS)
    # Pushed forward or to the left, an axis is negative.
    return held, [-_without_dead_zone(axes.get(i, 0.0)) for i in (1, 0, 3)]


def _without_dead_zone(value: float) -> float:
    share = max(0.0, abs(value) - _DEAD_ZONE) / (1 - _DEAD_ZONE)
    return math.copysign(share, value)
