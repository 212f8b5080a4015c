"""The commands to the base before and after smoothing."""

import numpy as np
from matplotlib.figure import Figure

from drake_mobman import signals
from drake_mobman.figures.law import law_of, name_of, smoothed_limits
from drake_mobman.figures.run_figure import RunFigure
from drake_mobman.figures.style import (
    BASE,
    COMMAND_LINE,
    TIME,
    draw_between,
    finish,
    label_axes,
    new_figure,
    symmetric,
)
from drake_mobman.simulation.run import Run


def draw_base_commands(run: Run) -> Figure:
    """Draws the base command before and after smoothing, over time.

    v_b [m/s] and omega_b [rad/s] (a, b), and the rate of change of the smoothed ones
    [m/s^2], [rad/s^2] (c, d), between the smoother's limits.
    """
    time, most = run.time, smoothed_limits(run.scenario)
    smoothed = run[signals.BASE_COMMAND_SMOOTHED]
    # Before the start, the base is at rest.
    change = np.diff(smoothed, axis=0, prepend=np.zeros((1, 2))) / run.scenario.period
    figure = new_figure(3.6)
    panels = figure.subplots(2, 2, sharex=True)
    for i, (symbol, unit) in enumerate((("v", "m/s"), (r"\omega", "rad/s"))):
        at, slope = panels[:, i]
        raw = run[signals.BASE_COMMAND][:, i]
        at.plot(time, raw, **COMMAND_LINE, label="raw")
        at.plot(time, smoothed[:, i], color=BASE, lw=1.2, label="smoothed")
        slope.plot(time, change[:, i], color=BASE, lw=1.0)
        label_axes(at, "", f"${symbol}_b$ [{unit}]", "ab"[i])
        rate = rf"\dot{{{symbol}}}_b"
        label_axes(slope, TIME, f"${rate}$ [{unit}$^2$]", "cd"[i])
        if most:
            fastest = (most.max_speed, most.max_yaw_rate)[i]
            steepest = (most.max_acceleration, most.max_yaw_acceleration)[i]
            limits = symmetric(rf"{symbol}_\mathrm{{max}}", fastest)
            draw_between(at, limits, raw, smoothed[:, i])
            limits = symmetric(rf"\dot{{{symbol}}}_\mathrm{{max}}", steepest)
            draw_between(slope, limits, change[:, i])
    law = name_of(law_of(run.scenario))
    return finish(figure, f"Base commands before and after smoothing, {law}")


def _applies(run: Run) -> bool:
    """Returns whether no other figure shows the base commands already."""
    return (
        smoothed_limits(run.scenario) is not None or signals.EE_COMMAND not in run.log
    )


BASE_COMMANDS = RunFigure("base_commands", draw_base_commands, _applies)
