"""The laws at work in a run: the paper's figs. 3 and 7."""

import math
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drake_mobman import signals
from drake_mobman.decomposers.blending import Blending
from drake_mobman.decomposers.projection import base_speed, radial_weight
from drake_mobman.figures.style import (
    ARM,
    BASE,
    COMMAND,
    HAND,
    TEXT,
    draw_limits_across,
    finish,
    label_axes,
    law_of,
    name_of,
    new_figure,
)
from drake_mobman.robot_model import WorkspaceLimits
from drake_mobman.simulation.simulate import Run

SHARPNESSES = (5.0, 10.0, 21.0, 50.0)
"""Values of alpha to set the scenario's own law against [1/m]."""

_TRANSITION = 0.35  # Shown to either side of a limit [m].


def draw_kappa(run: Run) -> Figure:
    """Draws what the base makes of its share at each angle of the arm (fig. 3).

    Over psi [rad]: kappa of eq. 11, and v_b / v_bm = kappa / cos(psi) of eq. 10. The
    angles that the run went through are shaded.
    """
    decomposer: Any = law_of(run.scenario)
    projection = decomposer.projection
    seen = run.log[signals.EE_CYLINDRICAL][:, 1]
    first, last = min(-math.pi, seen.min()), max(math.pi, seen.max())
    psi = np.linspace(first, last, 721)
    kappa = [radial_weight(x, projection.sigma) for x in psi]
    speed = [base_speed(1.0, x, projection) for x in psi]
    figure = new_figure(2.6)
    axes = figure.subplots()
    label_axes(axes, r"$\psi$ [rad]", r"$\kappa$,  $v_b\,/\,v_{bm}$  [–]")
    axes.plot(psi, kappa, color=COMMAND, lw=1.2, ls="--", label=r"$\kappa$")
    axes.plot(psi, speed, color=BASE, lw=1.6, label=r"$v_b/v_{bm} = \kappa/\cos\psi$")
    axes.axvspan(
        seen.min(), seen.max(), color=HAND, alpha=0.15, label=r"$\psi$ in this run"
    )
    draw_limits_across(axes, {r"-\pi/2": -math.pi / 2, r"\pi/2": math.pi / 2})
    axes.set_xlim(first, last)
    return finish(figure, rf"Base from its share, $\sigma$ = {projection.sigma:g} rad")


def draw_blending(run: Run) -> Figure:
    """Draws how authority over v_c passes at the limits of l (fig. 7).

    Over l [m]: the base's share mu (line) and the arm's, 1 - mu (dash-dot), about the
    limit that counts for the command's direction. Blending with several alpha is
    grey, the scenario's own law coloured.
    """
    limits, own = run.scenario.workspace, law_of(run.scenario)
    figure = new_figure(2.8)
    panels = figure.subplots(1, 2, sharey=True)
    sides = (
        (-1.0, limits.l_min, r"L_\mathrm{min}", "v_c < 0"),
        (1.0, limits.l_max, r"L_\mathrm{max}", r"v_c \geq 0"),
    )
    for axes, (v_c, limit, name, direction) in zip(panels, sides, strict=True):
        l = np.linspace(max(0.0, limit - _TRANSITION), limit + _TRANSITION, 301)
        for k, alpha in enumerate(SHARPNESSES):
            mu = linear_share(Blending(alpha=alpha), limits, v_c, l)
            grey = {"color": str(0.8 - 0.15 * k), "lw": 0.9}
            axes.plot(l, mu, **grey, label=rf"$\alpha$ = {alpha:g} 1/m")
            axes.plot(l, 1.0 - mu, ls="-.", **grey)
        if hasattr(own, "shares"):
            mu = linear_share(own, limits, v_c, l)
            axes.plot(l, mu, color=BASE, lw=2.0, label=r"base, $\mu$")
            axes.plot(l, 1.0 - mu, color=ARM, lw=2.0, ls="-.", label=r"arm, $1 - \mu$")
        draw_limits_across(axes, {name: limit})
        axes.set_xlim(l[0], l[-1])
        label_axes(axes, f"$l$ [m],  ${direction}$")
    panels[0].set_ylabel("share of $v_c$  [–]", fontsize=TEXT)
    return finish(figure, f"Authority at the limits of the reach, {name_of(own)}")


def linear_share(
    params: Any, limits: WorkspaceLimits, v_c: float, l: np.ndarray
) -> np.ndarray:
    """Returns the base's share of `v_c` [m/s] at each `l` (N,) [m]."""
    return np.array([params.shares(limits, (v_c, 0.0), (x, 0.0, 0.0))[0] for x in l])
