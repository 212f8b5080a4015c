"""How hand and robot truly moved: what the paper's figures lack."""

import itertools
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from pydrake.geometry import Box, Cylinder, SceneGraph, Shape, Sphere
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from drake_mobman import signals
from drake_mobman.guidance.guiding_hand import holds
from drake_mobman.robots.model import Robot, RobotModel
from drake_mobman.runs.figures.style import (
    ARM,
    BASE,
    COMMAND,
    COMMAND_LINE,
    ERROR_LINE,
    HAND,
    HAND_LINE,
    TEXT,
    TIME,
    WIDTH,
    finish,
    label_axes,
    law_of,
    name_of,
    new_figure,
    span,
)
from drake_mobman.runs.motion import hand_motion
from drake_mobman.runs.scenario import Guided
from drake_mobman.runs.simulate import Run

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
    motion = hand_motion(run)
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
    base, motion = log[signals.BASE_POSE][:, :2], hand_motion(run)
    if guided:
        hand = log[signals.TOOL_POSITION][:, :2]
        led = _while_held(run, log[signals.HAND_POSITION][:, :2])
    else:
        hand, led = motion.position, motion.led(run.scenario.period)
    q = _positions(run)[_moments(run)]
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


def holding(run: Run) -> np.ndarray:
    """Returns whether the force logged is that of a hand that holds the tool (N,).

    It is the force of the control tick before.
    """
    ticks = run.log["time"] - run.scenario.period / 2
    releases = cast(Guided, run.scenario).hand.releases
    return np.array([holds(time, releases) for time in ticks])


def _while_held(run: Run, x: np.ndarray) -> np.ndarray:
    """Returns `x` (N, size), not a number where the hand has let go."""
    return np.where(holding(run)[:, None], x, np.nan)


def _positions(run: Run) -> np.ndarray:
    """Returns positions of base and arm (N, 3 + n)."""
    return np.hstack([run.log[signals.BASE_POSE], run.log[signals.ARM_POSITION]])


def _moments(run: Run) -> np.ndarray:
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


def _arms(robot: Robot, q: np.ndarray) -> list[np.ndarray]:
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


_COLUMNS = 4  # Of pictures in a strip.
_TILE = 0.5  # Of the floor [m].
_ARROW = 0.3  # Length that stands for the largest force [m].
_AIR = 0.08  # About the robot [m].


def _view(azimuth: float, elevation: float) -> np.ndarray:
    """Returns unit vectors to one's right, up and towards one (3, 3) in W.

    Args:
        azimuth: whence one looks [rad].
        elevation: how far down [rad].
    """
    c, s = np.cos(azimuth), np.sin(azimuth)
    right = np.array([-s, c, 0.0])
    towards = np.array(
        [np.cos(elevation) * c, np.cos(elevation) * s, np.sin(elevation)]
    )
    return np.array([right, np.cross(towards, right), towards])


_VIEW = _view(*np.radians([-60.0, 22.0]))
_LIGHT = np.array([-0.4, 0.75, 0.53])  # Whence it shines, as one sees it.


def draw_strip(run: Run) -> Figure:
    """Draws pictures of the robot at some moments, with hand and force [N] (fig. 4).

    In parallel projection. One who looks goes along with the robot; the floor's tiles
    and the paths of hand and base stand still.
    """
    log, q = run.log, _positions(run)
    moments = _moments(run)
    solid = _Solid(run.scenario.robot)
    pictures = [solid.seen(q[k]) for k in moments]
    force = log[signals.HAND_FORCE]
    hand = _seen(_while_held(run, log[signals.HAND_POSITION]))
    tool = _seen(log[signals.TOOL_POSITION])
    largest = np.max(np.linalg.norm(force[moments], axis=1))
    tip = _seen(log[signals.TOOL_POSITION] + _ARROW / max(largest, 1e-9) * force)
    base = _seen(q[:, :3] * [1.0, 1.0, 0.0])
    middle = (base + tool) / 2
    drawn = [
        np.vstack([faces.reshape(-1, 2), tip[k : k + 1]]) - middle[k]
        for k, (faces, _) in zip(moments, pictures, strict=True)
    ]
    low, high = np.min(np.vstack(drawn), 0) - _AIR, np.max(np.vstack(drawn), 0) + _AIR
    width, height = high - low
    rows = -(-len(moments) // _COLUMNS)
    figure = new_figure(0.6 + rows * WIDTH / _COLUMNS * height / width)
    panels = figure.subplots(rows, _COLUMNS, squeeze=False).ravel()
    for axes, k, picture in itertools.zip_longest(panels, moments, pictures):
        axes.set_axis_off()
        if k is None:  # More panels than pictures.
            continue
        _draw_floor(axes, q[k, :2], np.max(high - low))
        axes.plot(*base[: k + 1].T, color=BASE, lw=1.4, label="base", zorder=1)
        _draw_faces(axes, *picture)
        axes.plot(*hand.T, color=HAND, lw=0.8, alpha=0.5)
        axes.plot(*hand[: k + 1].T, color=HAND, lw=1.4, label="hand")
        axes.plot(*hand[k], "o", color=HAND, mec="white", ms=5)
        axes.plot([], [], color=COMMAND, lw=1.4, label="its force")
        if force[k].any():
            arrow = {"arrowstyle": "-|>", "color": COMMAND, "shrinkA": 0, "shrinkB": 0}
            arrow |= {"lw": 1.4, "mutation_scale": 7}
            axes.annotate("", tip[k], tool[k], arrowprops=arrow)
        note = f"{log['time'][k]:.1f} s,  {np.linalg.norm(force[k]):.1f} N"
        axes.set_title(note, fontsize=TEXT, loc="left", pad=2)
        axes.set_xlim(middle[k, 0] + low[0], middle[k, 0] + high[0])
        axes.set_ylim(middle[k, 1] + low[1], middle[k, 1] + high[1])
        axes.set_aspect("equal")
    name = name_of(law_of(run.scenario))
    return finish(figure, f"Guided by hand, {name}, floor in tiles of {_TILE:g} m")


def _seen(points: np.ndarray) -> np.ndarray:
    """Returns how far right and up (..., 2) one sees points (..., 3) of W [m]."""
    return points @ _VIEW[:2].T


def _draw_floor(axes: Axes, centre: np.ndarray, size: float) -> None:
    """Draws the floor's tiles as far as `size` [m] from `centre` (2,), by W's axes."""
    marks = _TILE * np.arange(-np.ceil(size / _TILE), np.ceil(size / _TILE) + 1)
    near = _TILE * np.round(centre / _TILE)
    ends = marks[[0, -1]]
    along_x = [[(x, y, 0.0) for x in near[0] + ends] for y in near[1] + marks]
    along_y = [[(x, y, 0.0) for y in near[1] + ends] for x in near[0] + marks]
    lines = _seen(np.array(along_x + along_y))
    axes.add_collection(LineCollection(list(lines), color="0.85", lw=0.6, zorder=0))


class _Solid:
    """A robot's shapes as its URDF draws them."""

    def __init__(self, robot: Robot) -> None:
        scene_graph = SceneGraph()
        self.plant = MultibodyPlant(0.0)
        self.plant.RegisterAsSourceForSceneGraph(scene_graph)
        (it,) = Parser(self.plant).AddModelsFromString(robot.urdf(), "urdf")
        self.plant.Finalize()
        self._context = self.plant.CreateDefaultContext()
        inspector = scene_graph.model_inspector()
        self._parts: list[tuple[Any, np.ndarray, list[float]]] = []
        for body in map(self.plant.get_body, self.plant.GetBodyIndices(it)):
            for shape in self.plant.GetVisualGeometriesForBody(body):
                faces = _faces(inspector.GetShape(shape))
                X_BG = inspector.GetPoseInFrame(shape)
                looks = inspector.GetIllustrationProperties(shape)
                rgba = looks.GetProperty("phong", "diffuse")
                colour = [rgba.r(), rgba.g(), rgba.b()]
                self._parts.append((body, _moved(X_BG, faces), colour))

    def seen(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns the faces (m, 4, 2) [m] that one sees at `q`, and their colours.

        Those behind come first, to be painted over.
        """
        self.plant.SetPositions(self._context, q)
        parts, paints = [], []
        for body, part, paint in self._parts:
            X_WB = self.plant.EvalBodyPoseInWorld(self._context, body)
            parts.append(_moved(X_WB, part) @ _VIEW.T)
            paints.append(np.tile(paint, (len(part), 1)))
        faces, colours = np.concatenate(parts), np.concatenate(paints)
        normals = np.cross(faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        light = 0.55 + 0.45 * np.clip(normals @ _LIGHT, 0.0, 1.0)
        order = np.argsort(faces[:, :, 2].mean(axis=1))
        order = order[normals[order, 2] > 0]
        return faces[order, :, :2], (light[:, None] * colours)[order]


def _draw_faces(axes: Axes, faces: np.ndarray, colours: np.ndarray) -> None:
    look: dict[str, Any] = {"edgecolors": "face", "lw": 0.2, "zorder": 1.5}
    axes.add_collection(PolyCollection(list(faces), facecolors=colours, **look))


def _moved(X: Any, faces: np.ndarray) -> np.ndarray:
    return faces @ X.rotation().matrix().T + X.translation()


def _faces(shape: Shape) -> np.ndarray:
    """Returns the faces (m, 4, 3) [m] of a box, a cylinder or a sphere.

    A ring about z goes from the bottom to the top, as wide as the shape is there. Seen
    from outside, a face's corners go counterclockwise.
    """
    corners, across, along = 32, np.array([0, 1, 1, 0]), np.array([-1, -1, 1, 1])
    if isinstance(shape, Box):
        corners = 4
        size = np.array([shape.width(), shape.depth(), shape.height()]) / 2
        size[:2] *= np.sqrt(2.0)  # A square's corners are that far out.
    elif isinstance(shape, Cylinder):
        size = np.array([shape.radius(), shape.radius(), shape.length() / 2])
    elif isinstance(shape, Sphere):
        size = np.full(3, shape.radius())
        rise = np.linspace(-np.pi / 2, np.pi / 2, 9)
        across, along = np.cos(rise), np.sin(rise)
    else:
        raise TypeError(f"cannot draw {shape}")
    turn = np.pi / corners + np.linspace(0.0, 2 * np.pi, corners + 1)
    ring = np.stack([np.cos(turn), np.sin(turn), np.ones_like(turn)], -1)
    rings = size * ring * np.stack([across, across, along], -1)[:, None]
    low, high = rings[:-1], rings[1:]
    quads = [low[:, :-1], low[:, 1:], high[:, 1:], high[:, :-1]]
    return np.stack(quads, axis=2).reshape(-1, 4, 3)
