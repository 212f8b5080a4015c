"""What the base makes of its share at each angle of the arm (Kwon et al., fig. 3)."""

import math

import numpy as np
from matplotlib.figure import Figure

from drake_mobman import signals
from drake_mobman.decomposers.projection import base_speed, radial_weight
from drake_mobman.figures.law import law_of
from drake_mobman.figures.run_figure import RunFigure
from drake_mobman.figures.style import (
    BASE,
    COMMAND,
    END_EFFECTOR,
    draw_limits_across,
    finish,
    label_axes,
    new_figure,
)
from drake_mobman.simulation.run import Run


def draw_kappa(run: Run) -> Figure:
    """Draws the weight kappa and the base's speed over the angle psi [rad].

    kappa is that of eq. 11, and the speed v_b / v_bm = kappa / cos(psi) that of eq. 10.
    The angles of the run are shaded.
    """
    projection = law_of(run.scenario).projection
    seen = run[signals.EE_CYLINDRICAL][:, 1]
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
        seen.min(),
        seen.max(),
        color=END_EFFECTOR,
        alpha=0.15,
        label=r"$\psi$ in this run",
    )
    draw_limits_across(axes, {r"-\pi/2": -math.pi / 2, r"\pi/2": math.pi / 2})
    axes.set_xlim(first, last)
    title = rf"Base speed from its share, $\sigma$ = {projection.sigma:g} rad"
    return finish(figure, title)


KAPPA = RunFigure(
    "kappa", draw_kappa, lambda run: hasattr(law_of(run.scenario), "projection")
)
