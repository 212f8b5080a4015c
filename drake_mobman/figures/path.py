"""The paths of base and end effector, seen from above."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from drake_mobman import signals
from drake_mobman.analysis.motion import ee_motion
from drake_mobman.figures.law import law_of, name_of
from drake_mobman.figures.poses import BASE_RADIUS, moments, positions, while_held
from drake_mobman.figures.run_figure import RunFigure
from drake_mobman.figures.style import (
    ARM,
    BASE,
    COMMAND,
    COMMAND_LINE,
    END_EFFECTOR,
    WIDTH,
    finish,
    label_axes,
    new_figure,
    span,
)
from drake_mobman.frames import body
from drake_mobman.robot_model import RobotModel
from drake_mobman.simulation.run import Run

_NOSE = BASE_RADIUS * np.array([[1.0, 0.0], [0.5, 0.35], [0.5, -0.35]])
_ARM: dict[str, Any] = {
    "color": ARM,
    "lw": 1.4,
    "marker": "o",
    "ms": 2.2,
    "zorder": 2.5,
}


def draw_path(run: Run) -> Figure:
    """Draws the run from above, in W [m]: paths, and some poses of the robot.

    The end effector's path is drawn with the one that the commands would make; the
    largest distance between the two is the drift. A guided tool's path is drawn with
    the hand's.
    """
    base, guided = run[signals.BASE_POSE][:, :2], signals.HAND_POSITION in run.log
    path, target, drift = _guided_paths(run) if guided else _commanded_paths(run)
    q = positions(run)[moments(run)]
    arms = _arms(run.model, q)
    rim = np.vstack([base - BASE_RADIUS, base + BASE_RADIUS])
    drawn = np.vstack([rim, path, target, *arms])
    x, y = span(drawn[:, 0]), span(drawn[:, 1])
    height = 1.1 + (WIDTH - 0.6) * (y[1] - y[0]) / (x[1] - x[0])
    figure = new_figure(float(np.clip(height, 2.6, 5.6)))
    axes = figure.subplots()
    for k, (pose, arm) in enumerate(zip(q[:, :3], arms, strict=True)):
        # The later, the darker.
        _draw_robot(axes, pose, arm, 0.25 + 0.75 * (k + 1) / len(arms))
    axes.plot([], [], **_ARM, label="arm")
    axes.plot(*base.T, color=BASE, lw=1.6, label="base")
    names = ("tool", "hand") if guided else ("end effector", "command")
    axes.plot(*path.T, color=END_EFFECTOR, lw=1.6, label=names[0])
    axes.plot(*target.T, **COMMAND_LINE, zorder=1.5, label=names[1])
    axes.plot(*path[0], "o", color=END_EFFECTOR, mfc="white", ms=4, zorder=3)
    axes.plot(*path[-1], "o", color=END_EFFECTOR, ms=4, zorder=3)
    if drift is not None:
        worst = int(np.argmax(drift))
        label = f"largest drift, {drift[worst]:.3g} m"
        dotted: dict[str, Any] = {
            "color": COMMAND,
            "lw": 0.8,
            "ls": ":",
            "label": label,
        }
        axes.plot(*np.stack([target[worst], path[worst]]).T, **dotted)
    axes.set_aspect("equal", adjustable="datalim")
    label_axes(axes, "$x$ [m]", "$y$ [m]")
    name = name_of(law_of(run.scenario))
    return finish(figure, f"From above, later poses darker, {name}")


def _guided_paths(run: Run) -> tuple[np.ndarray, np.ndarray, None]:
    """Returns the paths of tool and hand (N, 2) [m]; there is no drift."""
    hand = while_held(run, run[signals.HAND_POSITION][:, :2])
    return run[signals.TOOL_POSITION][:, :2], hand, None


def _commanded_paths(run: Run) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns the end effector's path and the commanded one (N, 2) [m].

    And the distance between them (N,) [m].
    """
    motion, period = ee_motion(run), run.scenario.period
    return motion.position, motion.commanded_path(period), motion.drift(period)


def _arms(model: RobotModel, q: np.ndarray) -> list[np.ndarray]:
    """Returns x, y (links, 2) [m] along the arm at each of the positions (k, 3 + n)."""
    joints = map(model.plant.get_joint, model.plant.GetJointIndices())
    parents = {j.child_body().index(): j.parent_body() for j in joints}
    links = [body(model.plant, "tool")]
    base = body(model.plant, "base").index()
    while parents[links[-1].index()].index() != base:
        links.append(parents[links[-1].index()])
    states = np.hstack([q, np.zeros_like(q)])
    return [
        np.array([model.motion_W(link, state)[0][:2] for link in links])
        for state in states
    ]


def _draw_robot(axes: Axes, pose: np.ndarray, arm: np.ndarray, alpha: float) -> None:
    x, y, theta = pose
    body = Circle((x, y), BASE_RADIUS, fc=(BASE, 0.1 * alpha), ec=(BASE, alpha))
    c, s = np.cos(theta), np.sin(theta)
    nose = [x, y] + _NOSE @ np.array([[c, s], [-s, c]])
    axes.add_patch(body)
    axes.add_patch(Polygon(nose, color=BASE, alpha=alpha, lw=0))
    axes.plot(*arm.T, **_ARM, alpha=alpha)


PATH = RunFigure("path", draw_path)
