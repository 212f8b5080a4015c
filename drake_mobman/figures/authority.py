"""How authority passes between arm and base at the limits of the reach (fig. 7)."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drake_mobman.decomposers.blending import Blending
from drake_mobman.figures.law import law_of, name_of
from drake_mobman.figures.run_figure import RunFigure
from drake_mobman.figures.style import (
    ARM,
    BASE,
    TEXT,
    draw_limits_across,
    finish,
    label_axes,
    new_figure,
)
from drake_mobman.robot_model import WorkspaceLimits
from drake_mobman.simulation.run import Run

SHARPNESSES = (5.0, 10.0, 21.0, 50.0)
"""Values of alpha drawn for comparison [1/m]."""

_TRANSITION = 0.35  # Range drawn on either side of a limit [m].


def draw_authority(run: Run) -> Figure:
    """Draws the shares of v_c over l [m] about the limit that the command counts for.

    The base's share is mu (line), the arm's 1 - mu (dash-dot). Blending with several
    alpha is grey; the scenario's own law is coloured.
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
        mu = linear_share(own, limits, v_c, l)
        axes.plot(l, mu, color=BASE, lw=2.0, label=r"base, $\mu$")
        axes.plot(l, 1.0 - mu, color=ARM, lw=2.0, ls="-.", label=r"arm, $1 - \mu$")
        draw_limits_across(axes, {name: limit})
        axes.set_xlim(l[0], l[-1])
        label_axes(axes, f"$l$ [m],  ${direction}$")
    panels[0].set_ylabel("share of $v_c$  [–]", fontsize=TEXT)
    return finish(figure, f"Authority at the limits of the reach, {name_of(own)}")


def linear_share(
    law: Any, limits: WorkspaceLimits, v_c: float, l: np.ndarray
) -> np.ndarray:
    """Returns the base's share of `v_c` [m/s] at each `l` (N,) [m]."""
    return np.array([law.shares(limits, (v_c, 0.0), (x, 0.0, 0.0))[0] for x in l])


AUTHORITY = RunFigure(
    "blending", draw_authority, lambda run: hasattr(law_of(run.scenario), "shares")
)
