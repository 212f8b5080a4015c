"""Driving from Meshcat's own panel, without the page: sliders, keys and a gamepad.

Meshcat tells that a key is pressed, and never that it is released: a tap of the space
bar counts as held for `FIRST`, and a release is noticed up to `NEXT` late. Nor does it
tell who presses, or whether the page has the focus: all who have it open drive at once.
"""

import math
import threading
import time
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform

from drake_mobman.console.mailbox import OperatorInput
from drake_mobman.console.session import Snapshot
from drake_mobman.console.view import LINES, Frame, Picture
from drake_mobman.scenario import AnyScenario

SLIDERS = {
    "out (up, down)": ("ArrowDown", "ArrowUp"),
    "left (left, right)": ("ArrowRight", "ArrowLeft"),
    "up (R, F)": ("KeyF", "KeyR"),
}
"""Of v_c, omega_c and v_z as shares of the largest, with the keys that push them."""

HOLD = "hold to drive (space)"
STOP = "STOP (Esc)"
RESET = "start over"

FIRST = 0.8
"""For how long a key counts as held after it was pressed [s]: it is repeated only then,
half a second on or more."""

NEXT = 0.35
"""The same after it was repeated [s]; a page that is busy drawing hears of it late."""

_TRIGGERS = (6, 7)
_DEAD = 0.12
"""Of a gamepad's sticks, which do not quite return."""


class KeyHold:
    """Whether a key is held, told by the clicks that its repetition makes.

    Args:
        clock: the wall's [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._clicks = 0
        self._until = -math.inf

    def is_held(self, clicks: int) -> bool:
        """Returns whether it is, given all clicks since the start."""
        now = self._clock()
        if clicks > self._clicks:
            repeated = now <= self._until
            self._until = now + (NEXT if repeated else FIRST)
        self._clicks = clicks
        return now <= self._until


class Pulse:
    """Whether a page in the browser is alive: it draws what it is sent, and says so.

    Meshcat tells of a slider only when that is moved, and so nothing of a page that
    is frozen, hidden or gone. But a page that is opened with `tracked_camera=on` tells
    where its camera is whenever it draws; so the camera is shaken, unseen.

    Args:
        meshcat: that the page shows.
    """

    def __init__(self, meshcat: Any) -> None:
        self._meshcat = meshcat
        self._beats = 0
        self._seen: Any = None

    def beats(self) -> bool:
        """Returns whether the page has drawn anything new since the last call."""
        self._beats += 1
        shake = [0.0, 0.0, 1e-6 * (self._beats % 100)]
        self._meshcat.SetTransform("/Cameras/default", RigidTransform(shake))
        pose = self._meshcat.GetTrackedCameraPose()
        seen = None if pose is None else pose.translation().tolist()
        drawn = seen is not None and seen != self._seen
        self._seen = seen
        return drawn


class Driven(Protocol):
    """What a panel asks of a session: see `LiveSession`."""

    scenario: AnyScenario
    choices: list[str]

    def tell(self, said: OperatorInput) -> Any:
        """Takes the operator's word."""

    def stop(self, who: str) -> None:
        """Stops the robot."""

    def choose(self, name: str) -> None:
        """Lets one of `choices` drive."""

    def reset(self) -> None:
        """Starts over, disarmed."""

    def snapshot(self) -> Snapshot:
        """Returns the session as it is."""


class Panel:
    """Meshcat's panel as an operator's desk.

    What it says goes through the same gate as the page's commands. All calls come from
    the thread that made `meshcat`.

    Args:
        session: that is driven.
        meshcat: to whose panel all is added.
    """

    def __init__(self, session: Driven, meshcat: Meshcat) -> None:
        self._session = session
        self._meshcat = meshcat
        self._picture = Picture(session.scenario)
        self._picture.draw(meshcat)
        self._shown = Frame()
        self._pulse = Pulse(self._meshcat)
        self._hold = KeyHold()
        self._held = False
        self._sequence = 0
        self._said = ""
        self._closing = threading.Event()
        self._choices = {f"by {name}": name for name in session.choices}
        for name, (less, more) in SLIDERS.items():
            self._meshcat.AddSlider(name, -1.0, 1.0, 0.1, 0.0, less, more)
        self._meshcat.AddButton(HOLD, "Space")
        self._meshcat.AddButton(STOP, "Escape")
        self._clicks = dict.fromkeys((STOP, RESET, *self._choices), 0)
        for name in (RESET, *self._choices):
            self._meshcat.AddButton(name)

    def step(self) -> None:
        """Passes on what is pushed and pressed, and draws the robot."""
        self._press()
        held, command = self._pushed()
        if self._held and not held:
            self._spring_back()
        self._held = held
        if self._pulse.beats():
            self._sequence += 1
            largest = self._session.scenario.guard.largest
            v_c, omega_c, v_z = (x * y for x, y in zip(command, largest, strict=True))
            said = OperatorInput(self._sequence, v_c, omega_c, v_z, held)
            self._session.tell(said)
        snapshot = self._session.snapshot()
        self._show(self._picture.at(snapshot))
        if snapshot.text != self._said:
            self._say(snapshot.text)

    def _show(self, frame: Frame) -> None:
        """Moves what has moved since the last call."""
        news = frame.since(self._shown)
        for path, X in news.poses.items():
            self._meshcat.SetTransform(path, X)
        for path, line in news.lines.items():
            # Meshcat draws none of less than two points.
            points = np.array([*line.points, line.points[-1]]).T
            self._meshcat.SetLine(path, points, 3, LINES[path])
        self._shown = frame

    def _pushed(self) -> tuple[bool, list[float]]:
        """Returns whether a dead-man is held, and the command in shares."""
        pad_held, pad = _gamepad(self._meshcat.GetGamepad())
        key_held = self._hold.is_held(self._meshcat.GetButtonClicks(HOLD))
        sliders = map(self._meshcat.GetSliderValue, SLIDERS)
        both = zip(sliders, pad, strict=True)
        return key_held or pad_held, [max(-1.0, min(1.0, a + b)) for a, b in both]

    def _say(self, text: str) -> None:
        """Shows how things are as a button, as Meshcat has nothing else to read."""
        if self._said:
            self._meshcat.DeleteButton(self._said)
        self._meshcat.AddButton(text)
        self._said = text

    def _spring_back(self) -> None:
        """Lets the sliders go with the dead-man, or nobody could arm again."""
        for name in SLIDERS:
            self._meshcat.SetSliderValue(name, 0.0)

    def _press(self) -> None:
        """Does what buttons say that have been pressed."""
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
    """Returns whether a trigger is held, and what the sticks say in shares."""
    if pad.index is None:
        return False, [0.0, 0.0, 0.0]
    buttons = dict(enumerate(pad.button_values))
    axes = dict(enumerate(pad.axes))
    held = any(buttons.get(i, 0.0) > 0.5 for i in _TRIGGERS)
    # Pushed away from oneself or to the left, a stick says less than 0.
    return held, [-_beyond(axes.get(i, 0.0)) for i in (1, 0, 3)]


def _beyond(value: float) -> float:
    return math.copysign(max(0.0, abs(value) - _DEAD) / (1 - _DEAD), value)
