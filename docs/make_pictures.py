"""Makes the pictures of the documentation from the laws and from runs.

    python docs/make_pictures.py [NAME...]

Drawn for light and dark pages alike: without a background, text and axes in a grey that
both let one read.
"""

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, Rectangle, Wedge

import drake_mobman as mm
from drake_mobman.analysis.motion import ee_motion
from drake_mobman.arm.limits import end_rates
from drake_mobman.arm.place_first import place_first
from drake_mobman.base.jerk_limited import JerkLimited
from drake_mobman.base.smoother import smoothed
from drake_mobman.base.velocity_field import VelocityField, field_on
from drake_mobman.decomposers.projection import Projection, base_speed, radial_weight
from drake_mobman.decomposers.share import blended_share, strict_share
from drake_mobman.decomposers.switching import switched_share
from drake_mobman.robot_model import WorkspaceLimits

FOLDER = Path(__file__).parent / "pictures"

INK = "#7d8590"  # Axes and text, on white and on black.
# Okabe & Ito's colours, in shades that stand out on both.
BASE, ARM, EE, OTHER = "#3d95cf", "#d9702b", "#16a37f", "#c278a8"
L_MAX = r"$L_\mathrm{max}$"
SHARE = r"share of the base, $\mu$  [–]"

Draw = Callable[[], Figure]
PICTURES: dict[str, Draw] = {}
"""What draws each picture, by the name of its file."""


def picture(draw: Draw) -> Draw:
    """Adds a picture, under the name of what draws it."""
    PICTURES[draw.__name__] = draw
    return draw


def axes_of(height: float, columns: int = 1, **options: Any) -> tuple[Figure, Any]:
    """Returns a figure `height` [in] high, and its axes in one row."""
    figure = Figure(figsize=(7.2, height), layout="constrained")
    panels = figure.subplots(1, columns, **options)
    for axes in np.ravel(panels):
        axes.grid(color=INK, alpha=0.25, lw=0.6)
        axes.set_axisbelow(True)
        axes.patch.set_alpha(0)
    return figure, panels


def marked(axes: Axes, at: float, name: str) -> None:
    """Draws a limit of the coordinate that runs across."""
    axes.axvline(at, color=INK, lw=1, ls="--")
    axes.annotate(
        name, (at, 1), xycoords=("data", "axes fraction"), xytext=(0, 3),
        textcoords="offset points", ha="center", color=INK, fontsize=9,
    )  # fmt: skip


def named(axes: Axes, x: str, y: str, title: str = "") -> None:
    """Names the axes."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.set_title(title, fontsize=10, color=INK, pad=16 if title else None)


@picture
def share() -> Figure:
    """The share of the base at both limits of the reach, for several sharpnesses."""
    limits = WorkspaceLimits()
    figure, panels = axes_of(2.9, 2, sharey=True)
    ends = (-1.0, limits.l_min, r"$L_\mathrm{min}$"), (1.0, limits.l_max, L_MAX)
    for axes, (v_c, limit, name) in zip(panels, ends, strict=True):
        l = np.linspace(limit - 0.35, limit + 0.35, 301)
        for alpha, alpha_line in ((5.0, 0.35), (10.0, 0.6), (21.0, 1.0)):
            mu = [blended_share(v_c, x, limits.l_min, limits.l_max, alpha) for x in l]
            label = rf"$\alpha$ = {alpha:g} 1/m"
            axes.plot(l, mu, color=BASE, alpha=alpha_line, lw=2, label=label)
        marked(axes, limit, name)
        direction = "pulled in, $v_c < 0$" if v_c < 0 else r"pushed out, $v_c \geq 0$"
        named(axes, "$l$ [m]", SHARE if v_c < 0 else "", direction)
    panels[1].legend(loc="upper left")
    return figure


@picture
def switching() -> Figure:
    """The share of the base, switched and blended."""
    limits = WorkspaceLimits()
    l = np.linspace(1.25, 1.95, 701)
    ends = limits.l_min, limits.l_max
    figure, axes = axes_of(2.7)
    mu = [switched_share(1.0, x, *ends) for x in l]
    axes.plot(l, mu, color=ARM, lw=2, label="switching")
    mu = [blended_share(1.0, x, *ends, 21.0) for x in l]
    axes.plot(l, mu, color=BASE, lw=2, label="blending")
    marked(axes, limits.l_max, L_MAX)
    named(axes, "$l$ [m]", SHARE)
    axes.legend(loc="upper left")
    return figure


@picture
def projection() -> Figure:
    """The speed of the base by the angle of the arm."""
    psi = np.linspace(-math.pi, math.pi, 721)
    params = Projection()
    figure, axes = axes_of(3.0)
    kappa = [radial_weight(x, params.sigma) for x in psi]
    axes.plot(psi, kappa, color=INK, ls="--", lw=1.5, label=r"$\kappa(\psi)$")
    speed = [base_speed(1.0, x, params) for x in psi]
    axes.plot(psi, speed, color=BASE, lw=2, label=r"$v_b\,/\,v_{bm}$")
    marked(axes, -math.pi / 2, r"$-\pi/2$")
    marked(axes, math.pi / 2, r"$\pi/2$")
    named(axes, r"$\psi$ [rad]", "[–]")
    axes.legend(loc="lower center")
    return figure


@picture
def smoother() -> Figure:
    """A step of the command, as it is sent, and a stop."""
    period, acceleration, most = 0.01, 1.0, 0.5
    time = np.arange(0.0, 3.0, period)
    raw = np.where((time >= 0.2) & (time < 1.6), 0.4, 0.0)
    figure, axes = axes_of(2.9)
    axes.plot(time, raw, color=INK, ls="--", lw=1.5, label="wanted")
    step = acceleration * period
    for smoothing, color in ((0.2, BASE), (0.02, EE)):
        sent = [0.0]
        for wanted in raw[1:]:
            sent.append(smoothed(sent[-1], wanted, smoothing, step, most))
        label = rf"sent, $\alpha$ = {smoothing:g}"
        axes.plot(time, sent, color=color, lw=2, label=label)
    params, state = (
        JerkLimited(max_acceleration=acceleration, max_speed=most),
        [0.0] * 4,
    )
    sent = [0.0]
    for wanted in raw[1:]:
        state = params.next(state, [wanted, 0.0], period)
        sent.append(state[0])
    axes.plot(time, sent, color=ARM, lw=2, label="sent, jerk limited")
    named(axes, "time [s]", "$v_b$ [m/s]")
    axes.legend(loc="upper right")
    return figure


@picture
def strict_workspace() -> Figure:
    """The reach under a push that lasts, by either share."""
    limits, v_c, period = WorkspaceLimits(), 0.3, 0.01
    time = np.arange(0.0, 12.0, period)
    figure, (left, right) = axes_of(3.0, 2)
    grid = np.linspace(1.3, 1.8, 501)
    laws = (("tanh", blended_share, ARM), ("smoothstep", strict_share, EE))
    for name, law, color in laws:

        def share_at(x: float, law: Any = law) -> float:
            return float(law(v_c, x, limits.l_min, limits.l_max, 21.0))

        left.plot(grid, [share_at(x) for x in grid], color=color, lw=2, label=name)
        l = [1.4]
        for _ in time[1:]:
            l.append(l[-1] + period * (1 - share_at(l[-1])) * v_c)
        right.plot(time, l, color=color, lw=2, label=name)
    marked(left, limits.l_max, L_MAX)
    named(left, "$l$ [m]", SHARE)
    right.axhline(limits.l_max, color=INK, lw=1, ls="--")
    right.annotate(
        L_MAX, (1, limits.l_max), xycoords=("axes fraction", "data"), xytext=(4, -3),
        textcoords="offset points", color=INK,
    )  # fmt: skip
    named(right, "time [s]", "$l$ [m]")
    left.legend(loc="upper left")
    return figure


@picture
def geometry() -> Figure:
    """Base, shoulder, reach and end effector from above, with their symbols."""
    figure, axes = axes_of(3.2)
    axes.grid(visible=False)
    axes.axis("off")
    axes.set_aspect("equal")
    d, psi, l = 0.35, 0.55, 1.75
    S = np.array([d, 0.12])
    ray = np.array([math.cos(psi), math.sin(psi)])
    E = S + l * ray
    across = np.array([-ray[1], ray[0]])
    axes.add_patch(Circle((0, 0), 0.5, fc="none", ec=BASE, lw=2))
    for y in (-0.5, 0.42):
        axes.add_patch(Rectangle((-0.16, y), 0.32, 0.08, fc=BASE, ec="none"))
    axes.plot([S[0], E[0]], [S[1], E[1]], color=ARM, lw=2.5)
    axes.plot([S[0], S[0] + 1.1], [S[1], S[1]], color=INK, lw=0.8, ls="--")
    axes.add_patch(Wedge(S, 0.7, 0, math.degrees(psi), width=0.01, color=INK))
    for point, color in ((np.zeros(2), BASE), (S, ARM), (E, EE)):
        axes.plot(*point, "o", color=color, ms=6)

    def arrow(start: Any, along: Any, text: str, color: str, at: Any) -> None:
        end = start + along
        axes.add_patch(
            FancyArrowPatch(
                start, end, arrowstyle="-|>", mutation_scale=14, color=color
            )
        )
        axes.annotate(
            text, end, xytext=at, textcoords="offset points", color=color, fontsize=11
        )

    arrow(E, 0.5 * ray, "$v_c$", EE, (4, 2))
    arrow(E, 0.5 * across, r"$l\,\omega_c$", EE, (-8, 5))
    arrow(np.zeros(2), np.array([1.0, 0.0]), "$v_b$", BASE, (4, -4))
    turn = FancyArrowPatch(
        (-0.62, 0.28), (-0.62, -0.28), connectionstyle="arc3,rad=0.45",
        arrowstyle="-|>", mutation_scale=14, color=BASE,
    )  # fmt: skip
    axes.add_patch(turn)
    note = {"color": INK, "fontsize": 11}
    axes.text(-1.0, 0.0, r"$\omega_b$", color=BASE, fontsize=11)
    axes.text(-0.16, -0.22, "$B$", **note)
    axes.text(S[0] - 0.16, S[1] + 0.09, "$S$", **note)
    axes.text(E[0] + 0.02, E[1] - 0.22, "$E$", **note)
    axes.text(S[0] + 0.78, S[1] + 0.17, r"$\psi$", **note)
    axes.text(*(S + 0.62 * l * ray + 0.1 * across), "$l$", **note)
    axes.set_xlim(-1.2, 2.9)
    axes.set_ylim(-0.65, 1.75)
    return figure


@picture
def exact() -> Figure:
    """How far the end effector's velocity is off, by blending and exactly."""
    figure, axes = axes_of(2.9)
    laws = (("blending", mm.Blending(), ARM), ("exact", mm.Exact(), EE))
    for name, params, color in laws:
        run = mm.simulate("kwon_arbitrary", decomposer=params)
        error = np.linalg.norm(ee_motion(run).error, axis=1)
        # What is exact but for rounding would not be seen.
        axes.semilogy(
            run.time, np.maximum(error, 1e-16), color=color, lw=1.2, label=name
        )
    axes.set_ylim(1e-17, 10)
    named(axes, "time [s]", "velocity error [m/s]")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return figure


@picture
def optimization() -> Figure:
    """The reach of the arm as the end effector is pushed out, by each decomposer."""
    figure, axes = axes_of(3.0)
    laws = (
        ("blending", mm.Blending(), ARM),
        ("exact", mm.Exact(), EE),
        ("qp", mm.Qp(), BASE),
        ("diffik", mm.DiffIk(), OTHER),
    )
    for name, params, color in laws:
        run = mm.simulate("kwon_arbitrary", decomposer=params)
        axes.plot(
            run.time, run["ee_cylindrical"][:, 0], color=color, lw=1.6, label=name
        )
    limits = WorkspaceLimits()
    axes.axhspan(limits.l_min, limits.l_max, color=INK, alpha=0.12, lw=0)
    named(axes, "time [s]", "$l$ [m]")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4)
    return figure


@picture
def place_first_() -> Figure:
    """What is left of the end effector's velocity as a wrist joint nears its end."""
    setup = mm.RobotSetup.of(mm.FrankaTiago(), period=0.01)
    arm, limits, period = setup.arm, setup.joint_limits, setup.period
    start = mm.load_scenario("kwon_franka").start
    q = list(map(float, arm.inverse((start.l, start.psi, start.z))))
    joint = arm.wrist[-1]
    rooms = np.geomspace(1e-4, 0.3, 120)
    slowed, placed = [], []
    for room in rooms:
        q[joint] = limits.upper[joint] - room
        turns = arm.turn_rates(q)
        # Across the reach, with the orientation held in the world.
        moving = np.array(arm.undamped_rates(q, (0.0, 0.6, 0.0))[0], dtype=float)
        wanted = moving - 0.6 * turns[:, 2]
        wanted = (math.copysign(1.0, wanted[joint]) * wanted).tolist()
        ends = end_rates(wanted, q, limits, period)
        past = [abs(x) / end for x, end in zip(wanted, ends, strict=True)]
        slowed.append(1 / max(1.0, *past))
        placed.append(place_first(wanted, turns, arm.wrist, q, limits, period).share)
    figure, axes = axes_of(2.9)
    axes.semilogx(rooms, slowed, color=ARM, lw=2, label="all joints slowed alike")
    axes.semilogx(rooms, placed, color=EE, lw=2, label="place before orientation")
    named(axes, "room left to the wrist joint [rad]", "share of the velocity  [–]")
    axes.set_ylim(-0.05, 1.1)
    axes.legend(loc="center right")
    return figure


@picture
def field() -> Figure:
    """The field about the base from above, as printed and projected."""
    reach = mm.RobotSetup.of(mm.FrankaTiago(), period=0.01).reach
    figure, panels = axes_of(3.6, 2, sharey=True)
    shoulder = reach.ahead, reach.aside
    side = np.linspace(-0.75, 0.75, 201)
    x, y = np.meshgrid(side + shoulder[0], side + shoulder[1])
    points = np.stack([x, y, np.full_like(x, reach.l_0)], axis=-1)
    outside = np.hypot(x - shoulder[0], y - shoulder[1]) > reach.r_f
    colours = LinearSegmentedColormap.from_list("field", [OTHER, "#9aa2ad", ARM])
    for axes, law in zip(panels, ("printed", "projected"), strict=True):
        params = VelocityField(law=law)
        v, _, _ = field_on(points, params, reach)
        v = np.ma.array(np.clip(v, -0.5, 0.5), mask=outside)
        image = axes.pcolormesh(
            x, y, v, cmap=colours, vmin=-0.5, vmax=0.5, rasterized=True
        )
        zones = (reach.r_f - params.Delta_f, params.b_d + params.Delta_r)
        for radius, line in ((zones[0], "--"), (zones[1], "--"), (params.b_d, "-")):
            axes.add_patch(Circle(shoulder, radius, fc="none", ec="0.15", ls=line))
        for phi in (params.phi_min, -params.phi_min, params.phi_max, -params.phi_max):
            end = 0.8 * np.array([math.cos(phi), math.sin(phi)])
            axes.plot([0, end[0]], [0, end[1]], color=BASE, lw=1.2, ls=":")
        axes.set_aspect("equal")
        named(axes, "$x$ [m]", "$y$ [m]" if law == "printed" else "", law)
    bar = figure.colorbar(image, ax=list(panels), shrink=0.9)
    bar.set_label("$v_b$ [m/s]")
    return figure


STYLE = {
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "font.size": 9.5,
    "legend.frameon": False,
    "legend.labelcolor": INK,
    "svg.hashsalt": "drake_mobman",  # The same bytes each time.
    "xtick.color": INK,
    "ytick.color": INK,
}


def main() -> None:
    """Makes the pictures that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(PICTURES))
    wanted = parser.parse_args().names or PICTURES
    FOLDER.mkdir(exist_ok=True)
    with mpl.rc_context(STYLE):
        for name in wanted:
            path = FOLDER / f"{name.rstrip('_')}.svg"
            PICTURES[name]().savefig(
                path, transparent=True, dpi=150, metadata={"Date": None}
            )
            print(path)


if __name__ == "__main__":
    main()
