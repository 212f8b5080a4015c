"""How far the arm is from a singular posture, and from the ends of its joints."""

import numpy as np
from matplotlib.figure import Figure

from drake_mobman import signals
from drake_mobman.analysis.motion import manipulability
from drake_mobman.figures.law import law_of, name_of
from drake_mobman.figures.run_figure import RunFigure
from drake_mobman.figures.style import (
    ARM,
    EE_LINE,
    LIMIT,
    TIME,
    finish,
    label_axes,
    new_figure,
)
from drake_mobman.simulation.run import Run


def draw_manipulability(run: Run) -> Figure:
    """Draws T's manipulability (a), and each joint's distance to its limit [rad] (b).

    Over time; the least value of each is marked.
    """
    time, q = run.time, run[signals.ARM_POSITION]
    model, values = run.model, manipulability(run)
    margins = np.minimum(q - model.joint_limits.lower, model.joint_limits.upper - q)
    nearest = np.min(margins, axis=1)
    joint = model.arm_joints[np.argmin(margins[np.argmin(nearest)])]
    figure = new_figure(3.3)
    panels = figure.subplots(2, 1, sharex=True)
    label = f"manipulability, minimum {np.min(values):.3g}"
    panels[0].plot(time, values, **EE_LINE, label=label)
    # A velocity in space [m/s] by joint rates [rad/s]: m for each direction.
    power = min(q.shape[1], 3)
    unit = "m" if power == 1 else f"m$^{power}$"
    label_axes(panels[0], "", rf"$\sqrt{{\det JJ^T}}$ [{unit}]", "a")
    panels[1].plot(time, margins, color="0.8", lw=0.7)
    panels[1].plot([], [], color="0.8", lw=0.7, label="each joint")
    label = f"nearest to its limit, minimum {np.min(nearest):.3g} rad, {joint}"
    panels[1].plot(time, nearest, color=ARM, lw=1.4, label=label)
    label_axes(panels[1], TIME, "joint margin [rad]", "b")
    for axes, x in zip(panels, (values, nearest), strict=True):
        least = int(np.argmin(x))
        axes.plot(time[least], x[least], "o", color=LIMIT, mfc="white", ms=5)
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    law = name_of(law_of(run.scenario))
    return finish(figure, f"Manipulability of $T$ and margins of the joints, {law}")


MANIPULABILITY = RunFigure("manipulability", draw_manipulability)
