"""A base that follows its hand: what the field asked for, and what it took to pull.

What Petric & Zlajpah claim and do not plot: zones, force, manipulability, commands.
"""

from collections.abc import Mapping
from typing import cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drake_mobman import signals
from drake_mobman.analysis.motion import holding, manipulability
from drake_mobman.base.velocity_field import Zone, field_zone, signed_distances
from drake_mobman.figures.style import (
    ARM,
    BASE,
    COMMAND_LINE,
    ERROR_LINE,
    FORWARD,
    HAND_LINE,
    LIMIT,
    RETREAT,
    ROTATION,
    TIME,
    draw_limits,
    finish,
    label_axes,
    law_of,
    name_of,
    near,
    new_figure,
    span,
)
from drake_mobman.robot_model import RobotModel
from drake_mobman.scenario import Guided
from drake_mobman.simulation.simulate import Run

ZONES = {
    "forward": (Zone.FORWARD, FORWARD),
    "retreat": (Zone.RETREAT, RETREAT),
    "rotation": (Zone.ROTATION, ROTATION),
}
"""Flag and colour of each zone; what is left white is passive."""

_TINT = 0.3  # Opacity of a band.
_NEAR = 0.3  # Share of the largest force allowed from which that is drawn.


def draw_zones(run: Run) -> Figure:
    """Draws the zones that the hand was in, over time, and what puts it there (fig. 1).

    T's distance from c and from the capsule's axis [m] between the thresholds of
    forward and retreat zone (a), and its bearing phi [rad] between those of the
    rotation zone (b).
    """
    time, points = run.log["time"], run.log[signals.P_BT]
    field, reach = law_of(run.scenario), run.scenario.robot.reach()
    d_f, d_r = np.array([signed_distances(p, reach, field.b_d) for p in points]).T
    zone = np.array([field_zone(p, field, reach) for p in points]).astype(int)
    phi = np.arctan2(points[:, 1], points[:, 0])
    figure = new_figure(3.9)
    distance, bearing = figure.subplots(2, 1, sharex=True)

    distances = {
        "r_f": reach.r_f,
        r"r_f - \Delta_f": reach.r_f - field.Delta_f,
        r"b_d + \Delta_r": field.b_d + field.Delta_r,
        "b_d": field.b_d,
    }
    from_centre, from_axis = reach.r_f - d_f, d_r + field.b_d
    distance.plot(time, from_centre, **HAND_LINE, label="from $c$")
    dashed = {"color": BASE, "lw": 1.2, "ls": "--"}
    distance.plot(time, from_axis, **dashed, label="from the body's axis")
    distance.set_ylim(span(from_centre, from_axis, [*distances.values()]))
    draw_limits(distance, distances)
    label_axes(distance, "", "distance of $T$ [m]", "a")

    angles = _symmetric(r"\varphi_\mathrm{min}", field.phi_min)
    angles |= _symmetric(r"\varphi_\mathrm{max}", field.phi_max)
    bearing.plot(time, phi, color=ARM, lw=1.2, label=r"$\varphi$")
    bearing.set_ylim(span(phi, [*angles.values()]))
    draw_limits(bearing, angles)
    label_axes(bearing, TIME, r"bearing $\varphi$ [rad]", "b")

    for name, (flag, colour) in ZONES.items():
        axes = bearing if flag == Zone.ROTATION else distance
        _draw_band(axes, time, zone & flag > 0, colour, name)
    title = f"Zones that $T$ was in, {name_of(field)}, passive where white"
    return finish(figure, title)


def draw_hand_force(run: Run) -> Figure:
    """Draws the hand's force [N] (a), and how far the tool is from it [mm] (b).

    Both as norms in space, over time. Once it has let go, the hand is anywhere.
    """
    log, hand = run.log, cast(Guided, run.scenario).hand
    time, force = log["time"], np.linalg.norm(log[signals.HAND_FORCE], axis=1)
    held = holding(run)
    gap = log[signals.HAND_POSITION] - log[signals.TOOL_POSITION]
    error = 1e3 * np.linalg.norm(gap, axis=1)
    error[~held] = np.nan
    figure = new_figure(3.3)
    panels = figure.subplots(2, 1, sharex=True)
    largest = f"largest {np.max(force):.3g} N of {hand.max_force:g} N allowed"
    panels[0].plot(time, force, color=ARM, lw=1.2, label=f"force, {largest}")
    if np.max(force) > _NEAR * hand.max_force:
        draw_limits(panels[0], {r"f_\mathrm{max}": hand.max_force})
    largest = f"largest {np.max(error, initial=0.0, where=held):.3g} mm"
    panels[1].plot(time, error, **ERROR_LINE, label=f"error, {largest}")
    for axes in panels:
        axes.set_ylim(bottom=0.0)
        _draw_band(axes, time, ~held, LIMIT, "let go")
    label_axes(panels[0], "", "force [N]", "a")
    label_axes(panels[1], TIME, r"$|p_{WH} - p_{WE}|$ [mm]", "b")
    return finish(figure, f"The hand that pulls, {name_of(law_of(run.scenario))}")


def draw_manipulability(run: Run) -> Figure:
    """Draws T's manipulability (a) and each joint's way to its nearer limit [rad] (b).

    Over time, with the least of either.
    """
    time, q = run.log["time"], run.log[signals.ARM_POSITION]
    model, values = RobotModel(run.scenario.robot), manipulability(run)
    margins = np.minimum(q - model.joint_limits.lower, model.joint_limits.upper - q)
    nearest = np.min(margins, axis=1)
    joint = model.arm_joints[np.argmin(margins[np.argmin(nearest)])]
    figure = new_figure(3.3)
    panels = figure.subplots(2, 1, sharex=True)
    label = f"manipulability, least {np.min(values):.3g}"
    panels[0].plot(time, values, **HAND_LINE, label=label)
    # In an arm's joints [rad], a velocity in space [m/s]: m for each direction.
    power = min(q.shape[1], 3)
    unit = "m" if power == 1 else f"m$^{power}$"
    label_axes(panels[0], "", rf"$\sqrt{{\det JJ^T}}$ [{unit}]", "a")
    panels[1].plot(time, margins, color="0.8", lw=0.7)
    panels[1].plot([], [], color="0.8", lw=0.7, label="each joint")
    label = f"the nearest to its limit, least {np.min(nearest):.3g} rad, {joint}"
    panels[1].plot(time, nearest, color=ARM, lw=1.4, label=label)
    label_axes(panels[1], TIME, "joint margin [rad]", "b")
    for axes, x in zip(panels, (values, nearest), strict=True):
        least = int(np.argmin(x))
        axes.plot(time[least], x[least], "o", color=LIMIT, mfc="white", ms=5)
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    law = name_of(law_of(run.scenario))
    return finish(figure, f"Manipulability of $T$ and margins of the joints, {law}")


def draw_base_commands(run: Run) -> Figure | None:
    """Draws what is wanted of the base and what it is sent, over time.

    v_b [m/s] and omega_b [rad/s] (a, b), and how fast those sent change [m/s^2],
    [rad/s^2] (c, d), between the smoother's limits. Of a command without smoothing
    other figures show all.
    """
    log, smoother = run.log, run.scenario.smoother
    if smoother.limits().follows_at_once and signals.EE_COMMAND in log:
        return None
    time, sent = log["time"], log[signals.BASE_COMMAND_SMOOTHED]
    # Before the start, the base was sent nothing.
    change = np.diff(sent, axis=0, prepend=np.zeros((1, 2))) / run.scenario.period
    figure = new_figure(3.6)
    panels = figure.subplots(2, 2, sharex=True)
    columns = (
        ("v", "m/s", smoother.max_speed, smoother.limits().max_acceleration),
        (r"\omega", "rad/s", smoother.max_yaw_rate, smoother.limits().max_yaw_acceleration),
    )
    for i, (symbol, unit, fastest, steepest) in enumerate(columns):
        at, slope = panels[:, i]
        wanted = log[signals.BASE_COMMAND][:, i]
        at.plot(time, wanted, **COMMAND_LINE, label="raw, as wanted")
        at.plot(time, sent[:, i], color=BASE, lw=1.2, label="sent")
        slope.plot(time, change[:, i], color=BASE, lw=1.0)
        label_axes(at, "", f"${symbol}_b$ [{unit}]", "ab"[i])
        rate = rf"\dot{{{symbol}}}_b"
        label_axes(slope, TIME, f"${rate}$ [{unit}$^2$]", "cd"[i])
        if not smoother.limits().follows_at_once:
            limits = _symmetric(rf"{symbol}_\mathrm{{max}}", fastest)
            _draw_between(at, limits, wanted, sent[:, i])
            limits = _symmetric(rf"\dot{{{symbol}}}_\mathrm{{max}}", steepest)
            _draw_between(slope, limits, change[:, i])
    law = name_of(law_of(run.scenario))
    return finish(figure, f"Commands to the base before and after smoothing, {law}")


def _symmetric(symbol: str, limit: float) -> dict[str, float]:
    return {symbol: limit, f"-{symbol}": -limit}


def _draw_between(axes: Axes, limits: Mapping[str, float], *data: np.ndarray) -> None:
    """Draws those limits that the data come near."""
    limits = near(limits, np.concatenate(data))
    axes.set_ylim(span(*data, [*limits.values()]))
    draw_limits(axes, limits)


def _draw_band(
    axes: Axes, time: np.ndarray, inside: np.ndarray, colour: str, label: str
) -> None:
    """Colours the axes from bottom to top for as long as `inside` (N,) holds."""
    axes.fill_between(
        time,
        0.0,
        1.0,
        where=inside,
        step="post",
        transform=axes.get_xaxis_transform(),
        color=colour,
        alpha=_TINT,
        lw=0,
        label=label if inside.any() else None,
    )
