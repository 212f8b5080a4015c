"""The force of the guiding hand, and its distance from the tool."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drake_mobman import signals
from drake_mobman.analysis.motion import holding
from drake_mobman.figures.law import law_of, name_of
from drake_mobman.figures.run_figure import RunFigure, logged
from drake_mobman.figures.style import (
    ARM,
    ERROR_LINE,
    LIMIT,
    TIME,
    draw_band,
    draw_limits,
    finish,
    label_axes,
    new_figure,
)
from drake_mobman.simulation.run import Run

_NEAR = 0.3  # Share of the largest force allowed from which that limit is drawn.


def draw_hand_force(run: Run) -> Figure:
    """Draws the hand's force [N] (a), and its distance from the tool [mm] (b).

    Both are norms, over time. There is no distance while the hand lets go.
    """
    scenario: Any = run.scenario  # Of a kind that has a hand.
    hand, time = scenario.hand, run.time
    force = np.linalg.norm(run[signals.HAND_FORCE], axis=1)
    held = holding(run)
    gap = run[signals.HAND_POSITION] - run[signals.TOOL_POSITION]
    error = 1e3 * np.linalg.norm(gap, axis=1)
    error[~held] = np.nan
    figure = new_figure(3.3)
    panels = figure.subplots(2, 1, sharex=True)
    largest = f"largest {np.max(force):.3g} N of {hand.max_force:g} N allowed"
    panels[0].plot(time, force, color=ARM, lw=1.2, label=f"force, {largest}")
    if np.max(force) > _NEAR * hand.max_force:
        draw_limits(panels[0], {r"f_\mathrm{max}": hand.max_force})
    largest = f"largest {np.max(error, initial=0.0, where=held):.3g} mm"
    panels[1].plot(time, error, **ERROR_LINE, label=f"distance, {largest}")
    for axes in panels:
        axes.set_ylim(bottom=0.0)
        draw_band(axes, time, ~held, LIMIT, "hand lets go")
    label_axes(panels[0], "", "force [N]", "a")
    label_axes(panels[1], TIME, r"$|p_{WH} - p_{WE}|$ [mm]", "b")
    return finish(figure, f"Guiding hand, {name_of(law_of(run.scenario))}")


HAND_FORCE = RunFigure("hand_force", draw_hand_force, logged(signals.HAND_FORCE))
