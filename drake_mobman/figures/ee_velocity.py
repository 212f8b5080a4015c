"""The end effector's true velocity against the commanded one."""

import numpy as np
from matplotlib.figure import Figure

from drake_mobman import signals
from drake_mobman.analysis.motion import ee_motion
from drake_mobman.figures.law import law_of, name_of
from drake_mobman.figures.run_figure import RunFigure, logged
from drake_mobman.figures.style import (
    COMMAND_LINE,
    EE_LINE,
    ERROR_LINE,
    TIME,
    finish,
    label_axes,
    new_figure,
    span,
)
from drake_mobman.simulation.run import Run

_LEAST = 0.024  # Smallest range of an axis, so that rounding looks like zero [m/s].


def draw_ee_velocity(run: Run) -> Figure:
    """Draws the end effector's velocity and the commanded one, over time.

    Along the reach (a), across it (b) and the norm of the error (c), in W [m/s].
    """
    motion = ee_motion(run)
    time, error = run.time, np.linalg.norm(motion.error, axis=1)
    rms, most = np.sqrt(np.mean(error**2)), np.max(error)
    figure = new_figure(4.2)
    panels = figure.subplots(3, 1, sharex=True)
    for i, name in enumerate(("radial", "tangential")):
        axes = panels[i]
        axes.plot(time, motion.commanded[:, i], **COMMAND_LINE, label="command")
        axes.plot(time, motion.velocity[:, i], **EE_LINE, label="end effector")
        axes.set_ylim(span(motion.commanded[:, i], motion.velocity[:, i], least=_LEAST))
        label_axes(axes, "", f"{name} [m/s]", "ab"[i])
    top = max(most, _LEAST / 2)
    note = f"error, rms {rms:.3g} m/s, largest {most:.3g} m/s"
    panels[2].plot(time, error, **ERROR_LINE, label=note)
    panels[2].set_ylim(top * np.array([-0.05, 1.05]))
    label_axes(panels[2], TIME, "error [m/s]", "c")
    law = name_of(law_of(run.scenario))
    return finish(figure, f"Velocity of the end effector, {law}")


EE_VELOCITY = RunFigure(
    "ee_velocity",
    draw_ee_velocity,
    logged(signals.EE_COMMAND, signals.ARM_COMMAND),
)
