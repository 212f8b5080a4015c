"""How the hand truly moved: what the paper's figures lack."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from drake_mobman import signals
from drake_mobman.robots.model import RobotModel
from drake_mobman.runs.figures.style import (
    ARM,
    BASE,
    COMMAND,
    COMMAND_LINE,
    ERROR_LINE,
    HAND,
    HAND_LINE,
    TIME,
    WIDTH,
    finish,
    label_axes,
    name_of,
    new_figure,
    span,
)
from drake_mobman.runs.motion import HandMotion, hand_motion
from drake_mobman.runs.simulate import Run

_BASE_RADIUS = 0.27  # Of the base in the robots' URDFs [m].
_NOSE = _BASE_RADIUS * np.array([[1.0, 0.0], [0.5, 0.35], [0.5, -0.35]])
_LEAST = 0.024  # Range shown of a velocity, so that rounding looks like nothing [m/s].
_POSES = 7  # Of the robot, drawn along its path.
_ARM: dict[str, Any] = {"color": ARM, "lw": 1.4, "marker": "o", "ms": 2.2}
_ARM_LINKS = ("upper", "lower", "tee", "tool")
"""Links whose origins lie along the arm, from the shoulder to E."""


def draw_hand_velocity(run: Run) -> Figure:
    """Draws the hand's true velocity against the commanded one, over time.

    Along the reach (a), across it (b) and the error's norm (c), all in W [m/s].
    """
    motion = _motion(run)
    time, error = run.log["time"], np.linalg.norm(motion.error, axis=1)
    rms, most = np.sqrt(np.mean(error**2)), np.max(error)
    figure = new_figure(4.2)
    panels = figure.subplots(3, 1, sharex=True)
    for i, name in enumerate(("radial", "tangential")):
        axes = panels[i]
        axes.plot(time, motion.commanded[:, i], **COMMAND_LINE, label="command")
        axes.plot(time, motion.velocity[:, i], **HAND_LINE, label="hand")
        axes.set_ylim(span(motion.commanded[:, i], motion.velocity[:, i], least=_LEAST))
        label_axes(axes, "", f"{name} [m/s]", "ab"[i])
    top = max(most, _LEAST / 2)
    note = f"error, rms {rms:.3g} m/s, largest {most:.3g} m/s"
    panels[2].plot(time, error, **ERROR_LINE, label=note)
    panels[2].set_ylim(top * np.array([-0.05, 1.05]))
    label_axes(panels[2], TIME, "error [m/s]", "c")
    return finish(figure, f"Velocity of the hand, {name_of(run.scenario.decomposer)}")


def draw_path(run: Run) -> Figure:
    """Draws the run from above, in W [m]: paths of hand and base, and some poses.

    And the path that the commanded velocity leads to; how far the hand gets from it
    is its drift.
    """
    log, motion, period = run.log, _motion(run), run.scenario.period
    base, led = log[signals.BASE_POSE][:, :2], motion.led(period)
    drift = motion.drift(period)
    worst = int(np.argmax(drift))
    poses, arms = _poses(run)
    rim = np.vstack([base - _BASE_RADIUS, base + _BASE_RADIUS])
    drawn = np.vstack([rim, motion.position, led, *arms])
    x, y = span(drawn[:, 0]), span(drawn[:, 1])
    height = 1.1 + (WIDTH - 0.6) * (y[1] - y[0]) / (x[1] - x[0])
    figure = new_figure(float(np.clip(height, 2.6, 5.6)))
    axes = figure.subplots()
    for k, (pose, arm) in enumerate(zip(poses, arms, strict=True)):
        # The later, the darker.
        _draw_robot(axes, pose, arm, 0.25 + 0.75 * (k + 1) / len(poses))
    axes.plot([], [], **_ARM, label="arm")
    axes.plot(*base.T, color=BASE, lw=1.6, label="base")
    axes.plot(*motion.position.T, color=HAND, lw=1.6, label="hand")
    axes.plot(*led.T, **COMMAND_LINE, zorder=1.5, label="where the command leads")
    axes.plot(*motion.position[0], "o", color=HAND, mfc="white", ms=4)
    axes.plot(*motion.position[-1], "o", color=HAND, ms=4)
    axes.plot(
        *np.stack([led[worst], motion.position[worst]]).T,
        color=COMMAND,
        lw=0.8,
        ls=":",
        label=f"largest drift, {drift[worst]:.3g} m",
    )
    axes.set_aspect("equal", adjustable="datalim")
    label_axes(axes, "$x$ [m]", "$y$ [m]")
    name = name_of(run.scenario.decomposer)
    return finish(figure, f"From above, the later the darker, {name}")


def _poses(run: Run) -> tuple[np.ndarray, list[np.ndarray]]:
    """Returns some poses (k, 3) of the base, and x, y (4, 2) along the arm in each.

    They are evenly spread over the way that the joints went, so that a rest shows once.
    """
    log = run.log
    q = np.hstack([log[signals.BASE_POSE], log[signals.ARM_POSITION]])
    way = np.cumsum(np.linalg.norm(np.diff(q, axis=0, prepend=q[:1]), axis=1))
    chosen = np.unique(np.searchsorted(way, np.linspace(0.0, way[-1], _POSES)))
    model = RobotModel(run.scenario.robot)
    arms = []
    for sample in q[chosen]:
        model.set_state(sample, np.zeros_like(sample))
        arms.append(np.array([model.p_W(link)[:2] for link in _ARM_LINKS]))
    return q[chosen, :3], arms


def _draw_robot(axes: Axes, pose: np.ndarray, arm: np.ndarray, alpha: float) -> None:
    x, y, theta = pose
    body = Circle((x, y), _BASE_RADIUS, fc=(BASE, 0.1 * alpha), ec=(BASE, alpha))
    c, s = np.cos(theta), np.sin(theta)
    nose = [x, y] + _NOSE @ np.array([[c, s], [-s, c]])
    axes.add_patch(body)
    axes.add_patch(Polygon(nose, color=BASE, alpha=alpha, lw=0))
    axes.plot(*arm.T, **_ARM, alpha=alpha)


def _motion(run: Run) -> HandMotion:
    return hand_motion(run)
