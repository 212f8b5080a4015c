"""A robot from the side and from above, with what is known of it drawn in."""

import math
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from pydrake.multibody.plant import MultibodyPlant

from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.figures.field.edges import BODY, FORWARD, REACH, RETREAT, edges
from drake_mobman.figures.solid import Solid, view
from drake_mobman.figures.style import (
    ARM,
    BASE,
    END_EFFECTOR,
    LIMIT,
    SMALL,
    TEXT,
    finish,
    label_axes,
    new_figure,
)
from drake_mobman.frames import frame
from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import Reach, RobotDescription, WorkspaceLimits
from drake_mobman.robot_model.model import BASE_JOINTS, moving_joints
from drake_mobman.robots.defaults import Start, default_of

_SIDE = view(-math.pi / 2, 0.0)
_TOP = view(-math.pi / 2, math.pi / 2)

_AXIS = 0.16
"""Length of a joint's axis, as a share of the reach."""

_ZONES: dict[str, dict[str, Any]] = {
    REACH: {"color": "0.25", "lw": 0.9},
    FORWARD: {"color": "#e08214", "lw": 0.9, "ls": "--"},
    RETREAT: {"color": "#8073ac", "lw": 0.9, "ls": "--"},
    BODY: {"color": BASE, "lw": 1.1},
}


class Drawn(NamedTuple):
    """A robot at its start, and what is drawn with it."""

    solid: Solid
    q: Any  # Positions of the plant at the start.
    arm: ArmKinematics
    reach: Reach
    field: VelocityField
    workspace: WorkspaceLimits
    start: Start


def draw_robot(robot: RobotDescription, name: str = "") -> Figure:
    """Draws a robot at its start, from the right and from above.

    With the axes of its joints, S, T and E, the workspace of E, the edges of the
    field's zones for T, and the wheels and casters that it rolls on, if any.

    Args:
        robot: to draw.
        name: for the title.
    """
    drawn = _drawn(robot)
    figure = new_figure(4.4)
    side, top = figure.subplots(1, 2)
    for axes, axis in ((side, _SIDE), (top, _TOP)):
        faces, colours = drawn.solid.seen(drawn.q, axis)
        look: dict[str, Any] = {"edgecolors": "face", "lw": 0.2, "zorder": 1.5}
        pale = 0.45 + 0.55 * colours
        axes.add_collection(PolyCollection(list(faces), facecolors=pale, **look))
        _draw_joints(axes, axis, drawn)
        _draw_points(axes, axis, drawn)
    _draw_zones(side, drawn, None)
    _draw_zones(top, drawn, float(drawn.arm.p_BT(_arm_of(drawn.q))[2]))
    side.axhline(0.0, color="0.3", lw=1.2, zorder=0)
    _draw_workspace(top, drawn)
    _draw_wheels(top, robot)
    _draw_reach(side, drawn)
    for axes, up, letter in ((side, "z", "a"), (top, "y", "b")):
        label_axes(axes, "x [m]", f"{up} [m]", letter)
        axes.set_aspect("equal", adjustable="datalim")
        axes.autoscale_view()
    return finish(figure, name)


def _drawn(robot: RobotDescription) -> Drawn:
    solid = Solid(robot)
    arm, start = robot.arm(solid.plant), default_of(robot, Start)
    q = np.array([0.0] * BASE_JOINTS + arm.inverse((start.l, start.psi, start.z)))
    return Drawn(
        solid,
        q,
        arm,
        robot.reach(solid.plant),
        default_of(robot, VelocityField),
        default_of(robot, WorkspaceLimits),
        start,
    )


def _arm_of(q: Any) -> list[float]:
    """Returns the arm's part of a robot's positions."""
    return list(q[BASE_JOINTS:])


def _draw_joints(axes: Axes, axis: np.ndarray, drawn: Drawn) -> None:
    """Draws the axis of each joint of the arm; one towards the viewer is a dot."""
    plant = drawn.solid.plant
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, drawn.q)
    for joint in moving_joints(plant)[BASE_JOINTS:]:
        X = joint.frame_on_parent().CalcPoseInWorld(context)
        half = 0.5 * _AXIS * drawn.reach.r_f * (X.rotation() @ _direction(joint))
        middle = X.translation()
        ends = np.array([middle - half, middle + half]) @ axis[:2].T
        axes.plot(*ends.T, color=ARM, lw=1.2, zorder=3, label="joints' axes")
        axes.plot(*(axis[:2] @ middle), ".", color=ARM, ms=4, zorder=3)


def _direction(joint: Any) -> np.ndarray:
    """Returns the axis (3,) of a joint in its own frame."""
    if joint.type_name() == "prismatic":
        return np.asarray(joint.translation_axis())
    return np.asarray(joint.revolute_axis())


def _draw_points(axes: Axes, axis: np.ndarray, drawn: Drawn) -> None:
    """Draws B, S, T and E."""
    plant = drawn.solid.plant
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, drawn.q)
    places = {"B": np.zeros(3), "S": np.array(drawn.arm.p_BS)}
    for letter, name in (("T", "tee"), ("E", "tool")):
        places[letter] = frame(plant, name).CalcPoseInWorld(context).translation()
    for letter, place in places.items():
        at = axis[:2] @ place
        colour = BASE if letter == "B" else END_EFFECTOR
        axes.plot(*at, "o", color=colour, mec="white", ms=5, zorder=4)
        axes.annotate(
            letter,
            at,
            (4, 4),
            textcoords="offset points",
            fontsize=TEXT,
            weight="bold",
            zorder=5,
        )


def _draw_zones(axes: Axes, drawn: Drawn, height: float | None) -> None:
    """Draws the edges of the field's zones, from above at a height, else aside."""
    columns = [0, 2] if height is None else [0, 1]
    for label, points in edges(drawn.field, drawn.reach, height).items():
        if len(points):
            axes.plot(*points[:, columns].T, **_ZONES[label], label=label, zorder=2)


def _draw_workspace(axes: Axes, drawn: Drawn) -> None:
    """Draws the ring sector in which E works, from above."""
    shoulder = np.array(drawn.arm.p_BS[:2])
    at = drawn.workspace
    angle = np.linspace(at.psi_min, at.psi_max, 41)
    out = np.column_stack([np.cos(angle), np.sin(angle)])
    ring = np.vstack([at.l_max * out, at.l_min * out[::-1], at.l_max * out[:1]])
    ring += shoulder
    axes.fill(*ring.T, color=END_EFFECTOR, alpha=0.15, zorder=1)
    axes.plot(*ring.T, color=END_EFFECTOR, lw=0.9, label="workspace of $E$")


def _draw_wheels(axes: Axes, robot: RobotDescription) -> None:
    """Draws the driven wheels and the casters, from above."""
    plant, add = MultibodyPlant(0.0), getattr(robot, "add_rolling_to", None)
    if add is None:
        return
    try:
        rolling = add(plant)
    except ParameterError:
        return  # It has none.
    plant.Finalize()
    context, base = plant.CreateDefaultContext(), frame(plant, "base")
    half = rolling.wheel_radius * np.array([-1.0, 1.0])
    for joint in (*rolling.left, *rolling.right):
        x, y, _ = joint.frame_on_child().CalcPose(context, base).translation()
        look: dict[str, Any] = {"color": BASE, "lw": 3.5, "alpha": 0.6, "zorder": 2}
        axes.plot(x + half, [y, y], **look, gid="wheel")
    angle = np.linspace(0.0, 2 * math.pi, 33)
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    for caster in rolling.casters:
        at = [caster.x, caster.y] + caster.radius * ring
        axes.plot(*at.T, color=BASE, lw=0.9, zorder=2, gid="caster")


def _draw_reach(axes: Axes, drawn: Drawn) -> None:
    """Draws the shoulder's axis, and the limits of l at the start's height."""
    d, _, l_0 = drawn.arm.p_BS
    z, at = l_0 + drawn.start.z, drawn.workspace
    top = 1.2 * max(l_0, z)
    axes.plot([d, d], [0.0, top], color=LIMIT, lw=0.8, ls=(0, (6, 3)), zorder=1)
    axes.plot([d + at.l_min, d + at.l_max], [z, z], color=END_EFFECTOR, lw=2.5)
    for l, name in ((at.l_min, "min"), (at.l_max, "max")):
        symbol = rf"$l_\mathrm{{{name}}}$"
        axes.annotate(
            symbol,
            (d + l, z),
            (0, -9),
            textcoords="offset points",
            fontsize=SMALL,
            ha="center",
            color=END_EFFECTOR,
        )
