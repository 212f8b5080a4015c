"""Commands of several decomposers, and the time of a tick (Kwon et al., fig. 11)."""

from collections.abc import Mapping
from string import ascii_lowercase

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drake_mobman import signals
from drake_mobman.figures.components import ANGULAR, LINEAR, Component
from drake_mobman.figures.law import smoothed_limits
from drake_mobman.figures.style import (
    ARM_LINE,
    BASE_LINE,
    COMMAND_LINE,
    END_EFFECTOR,
    SMALL,
    TIME,
    draw_limits,
    finish,
    label_axes,
    new_figure,
)
from drake_mobman.scenario import AnyScenario
from drake_mobman.simulation.run import Run

_THIN = {"lw": 0.8}
"""Panels are narrow, and a peak may be a single tick."""


def draw_comparison(runs: Mapping[str, Run]) -> Figure:
    """Draws a row of panels for each run, by the name of its variant.

    Of two runs, linear velocities [m/s] are a and b, angular ones [rad/s] c and d: the
    command, and what the decomposer sends to base and arm for it, sample by sample.
    Then the time [us] of each control tick that was timed, e and f. The limits are
    those of the base where its command is smoothed, else those of the operator's
    command; for the time, it is the control period. A column has one scale.
    """
    figure = new_figure(0.8 + 1.3 * len(runs))
    panels = figure.subplots(len(runs), 3, sharex="col", sharey="col", squeeze=False)
    letters = iter(ascii_lowercase)
    for column, part in zip(panels.T, (LINEAR, ANGULAR, None), strict=True):
        for axes, (name, run) in zip(column, runs.items(), strict=True):
            title = f"({next(letters)}) {name}"
            if part:
                _draw_velocities(axes, run, part)
                title += ", died" if run.died else ""
            else:
                _draw_times(axes, run)
                if len(run.tick_times):
                    median = 1e6 * float(np.median(run.tick_times))
                    title += f", median {median:.3g} µs"
            axes.set_title(title, fontsize=SMALL, loc="left")
        column[-1].set_xlabel(TIME)
    return finish(figure, "Commands to base and arm, and the time of a tick")


def _draw_velocities(axes: Axes, run: Run, part: Component) -> None:
    """Draws the command, and the commands to base and arm, before any smoothing."""
    log, i = run.log, part.index
    for signal, name, line in (
        (signals.EE_COMMAND, "command", COMMAND_LINE),
        (signals.BASE_COMMAND, "base", BASE_LINE | _THIN),
        (signals.ARM_COMMAND, "arm", ARM_LINE | _THIN),
    ):
        if signal in log:  # Led by hand, only the base is commanded.
            axes.plot(log["time"], log[signal][:, i], **line, label=name)
    symbol, most = rf"{part.rate}_\mathrm{{max}}", _limit(run.scenario, part)
    draw_limits(axes, {symbol: most, f"-{symbol}": -most})
    label_axes(axes, "", f"${part.rate}$ [{part.rate_unit}]")


def _limit(scenario: AnyScenario, part: Component) -> float:
    limits = smoothed_limits(scenario)
    if limits:
        return (limits.max_speed, limits.max_yaw_rate)[part.index]
    return scenario.guard.largest[part.index]


def _draw_times(axes: Axes, run: Run) -> None:
    """Draws how long ticks took, from the command to those of base and joints."""
    period, times = run.scenario.period, run.tick_times * 1e6
    axes.set_yscale("log")
    axes.plot(
        period * np.arange(len(times)), times, color=END_EFFECTOR, lw=0.6, label="tick"
    )
    draw_limits(axes, {r"\mathrm{period}": period * 1e6})
    label_axes(axes, "", "time of a tick [µs]")
