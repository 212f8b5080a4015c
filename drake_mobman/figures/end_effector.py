"""How hand and robot truly moved: what the paper's figures lack."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from drake_mobman import signals
from drake_mobman.analysis.motion import ee_motion, holding
from drake_mobman.figures.style import (
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
    law_of,
    name_of,
    new_figure,
    span,
)
from drake_mobman.robot_model import RobotDescription, RobotModel
from drake_mobman.simulation.simulate import Run

_BASE_RADIUS = 0.27  # Of the base in the robots' URDFs [m].
_NOSE = _BASE_RADIUS * np.array([[1.0, 0.0], [0.5, 0.35], [0.5, -0.35]])
_LEAST = 0.024  # Range shown of a velocity, so that rounding looks like nothing [m/s].
_POSES = 8  # Of the robot, drawn along its path and in a strip.
_STRETCH = 3.0  # How much more the arm's pose tells than the base's.
_ALIKE = 0.01  # Where two poses differ by less, one tells all [m].
_ARM: dict[str, Any] = {
    "color": ARM,
    "lw": 1.4,
    "marker": "o",
    "ms": 2.2,
    "zorder": 2.5,
}


def draw_hand_velocity(run: Run) -> Figure:
    """Draws the hand's true velocity against the commanded one, over time.

    Along the reach (a), across it (b) and the error's norm (c), all in W [m/s].
    """
    motion = ee_motion(run)
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
    return finish(figure, f"Velocity of the hand, {name_of(law_of(run.scenario))}")


def draw_path(run: Run) -> Figure:
    """Draws the run from above, in W [m]: paths of hand and base, and some poses.

    And the path that the hand is led along. Where a command leads it, how far it gets
    from there is its drift.
    """
    log, guided = run.log, signals.HAND_POSITION in run.log
    base, motion = log[signals.BASE_POSE][:, :2], ee_motion(run)
    if guided:
        hand = log[signals.TOOL_POSITION][:, :2]
        led = while_held(run, log[signals.HAND_POSITION][:, :2])
    else:
        hand, led = motion.position, motion.led(run.scenario.period)
    q = positions(run)[moments(run)]
    arms = _arms(run.scenario.robot, q)
    rim = np.vstack([base - _BASE_RADIUS, base + _BASE_RADIUS])
    drawn = np.vstack([rim, hand, led, *arms])
    x, y = span(drawn[:, 0]), span(drawn[:, 1])
    height = 1.1 + (WIDTH - 0.6) * (y[1] - y[0]) / (x[1] - x[0])
    figure = new_figure(float(np.clip(height, 2.6, 5.6)))
    axes = figure.subplots()
    for k, (pose, arm) in enumerate(zip(q[:, :3], arms, strict=True)):
        # The later, the darker.
        _draw_robot(axes, pose, arm, 0.25 + 0.75 * (k + 1) / len(arms))
    axes.plot([], [], **_ARM, label="arm")
    axes.plot(*base.T, color=BASE, lw=1.6, label="base")
    names = ("tool", "hand") if guided else ("hand", "where the command leads")
    axes.plot(*hand.T, color=HAND, lw=1.6, label=names[0])
    axes.plot(*led.T, **COMMAND_LINE, zorder=1.5, label=names[1])
    axes.plot(*hand[0], "o", color=HAND, mfc="white", ms=4, zorder=3)
    axes.plot(*hand[-1], "o", color=HAND, ms=4, zorder=3)
    if not guided:
        drift = motion.drift(run.scenario.period)
        worst = int(np.argmax(drift))
        axes.plot(
            *np.stack([led[worst], hand[worst]]).T,
            color=COMMAND,
            lw=0.8,
            ls=":",
            label=f"largest drift, {drift[worst]:.3g} m",
        )
    axes.set_aspect("equal", adjustable="datalim")
    label_axes(axes, "$x$ [m]", "$y$ [m]")
    name = name_of(law_of(run.scenario))
    return finish(figure, f"From above, the later the darker, {name}")


def while_held(run: Run, x: np.ndarray) -> np.ndarray:
    """Returns `x` (N, size), not a number where the hand has let go."""
    return np.where(holding(run)[:, None], x, np.nan)


def positions(run: Run) -> np.ndarray:
    """Returns positions of base and arm (N, 3 + n)."""
    return np.hstack([run.log[signals.BASE_POSE], run.log[signals.ARM_POSITION]])


def moments(run: Run) -> np.ndarray:
    """Returns up to `_POSES` samples, the first and the last among them.

    Each other is where the robot stands least as it does in those before: by where its
    front is in W and T in B. So the moments differ, and a rest shows once.
    """
    x, y, theta = run.log[signals.BASE_POSE].T
    x, y = x + _BASE_RADIUS * np.cos(theta), y + _BASE_RADIUS * np.sin(theta)
    looks = np.column_stack([x, y, _STRETCH * run.log[signals.P_BT]])
    chosen = [0, len(looks) - 1]
    while len(chosen) < _POSES:
        unlike = np.linalg.norm(looks[:, None] - looks[chosen], axis=2).min(axis=1)
        if np.max(unlike) < _ALIKE:
            break
        chosen.append(int(np.argmax(unlike)))
    return np.unique(chosen)


def _arms(robot: RobotDescription, q: np.ndarray) -> list[np.ndarray]:
    """Returns x, y (links, 2) [m] along the arm at each of the positions (k, 3 + n)."""
    model = RobotModel(robot)
    joints = map(model.plant.get_joint, model.plant.GetJointIndices())
    parents = {j.child_body().name(): j.parent_body().name() for j in joints}
    links = ["tool"]
    while parents[links[-1]] != "base":
        links.append(parents[links[-1]])
    arms = []
    for sample in q:
        model.set_state(sample, np.zeros_like(sample))
        arms.append(np.array([model.p_W(link)[:2] for link in links]))
    return arms


def _draw_robot(axes: Axes, pose: np.ndarray, arm: np.ndarray, alpha: float) -> None:
    x, y, theta = pose
    body = Circle((x, y), _BASE_RADIUS, fc=(BASE, 0.1 * alpha), ec=(BASE, alpha))
    c, s = np.cos(theta), np.sin(theta)
    nose = [x, y] + _NOSE @ np.array([[c, s], [-s, c]])
    axes.add_patch(body)
    axes.add_patch(Polygon(nose, color=BASE, alpha=alpha, lw=0))
    axes.plot(*arm.T, **_ARM, alpha=alpha)
