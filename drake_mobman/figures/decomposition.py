"""The command and what base and arm make of it (Kwon et al., fig. 10)."""

from string import ascii_lowercase
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drake_mobman import signals
from drake_mobman.figures.components import (
    ANGULAR,
    LINEAR,
    VERTICAL,
    Component,
    limits_of,
)
from drake_mobman.figures.law import law_of, name_of
from drake_mobman.figures.run_figure import RunFigure
from drake_mobman.figures.style import (
    ARM_LINE,
    BASE_LINE,
    COMMAND_LINE,
    EE_LINE,
    END_EFFECTOR,
    TIME,
    draw_limits,
    finish,
    label_axes,
    new_figure,
    span,
)
from drake_mobman.simulation.run import Run

COMPONENTS = (LINEAR, ANGULAR, VERTICAL)

LINES = {"command": COMMAND_LINE, "sum": EE_LINE, "base": BASE_LINE, "arm": ARM_LINE}


def draw_decomposition(run: Run) -> Figure:
    """Draws the command and the contributions of base and arm, over time.

    A panel for each command, v_c [m/s] with l [m] and omega_c [rad/s] with psi [rad]
    (a, b); then one for each with the base's contribution, the arm's and their sum
    (c, d); then v_z [m/s] with z [m], which the arm makes alone. Components that are
    never commanded are left out.
    """
    given = [part for part in COMPONENTS if part.commanded(run)]
    split = [part for part in given if part is not VERTICAL]
    rows: list[tuple[Component, tuple[str, ...]]] = [
        (part, ("command",)) for part in split
    ]
    rows += [(part, tuple(LINES)) for part in split]
    rows += [(part, ("command", "arm")) for part in given if part is VERTICAL]
    figure = new_figure(0.9 + 1.25 * len(rows))
    panels = figure.subplots(len(rows), 1, sharex=True, squeeze=False)[:, 0]
    for axes, letter, (part, names) in zip(panels, ascii_lowercase, rows, strict=False):
        lines = _contributions(run, part)
        for name in names:
            axes.plot(run.time, lines[name], **LINES[name], label=name)
        x = TIME if axes is panels[-1] else ""
        rate = f"{part.rate}_c" if names == ("command",) else part.rate
        label_axes(axes, x, f"${rate}$ [{part.rate_unit}]", letter)
        if "base" not in names:
            _draw_coordinate(axes.twinx(), run, part)
    return finish(figure, f"Command and contributions, {name_of(law_of(run.scenario))}")


def _contributions(run: Run, part: Component) -> dict[str, np.ndarray]:
    """Returns the command and what base and arm make of it (N,), as in `LINES`."""
    arm = run[signals.ARM_COMMAND][:, part.index]
    lines = {"command": run[signals.EE_COMMAND][:, part.index], "arm": arm}
    if part is not VERTICAL:
        base = run[signals.BASE_CONTRIBUTION][:, part.index]
        lines |= {"base": base, "sum": base + arm}
    return lines


def _draw_coordinate(axes: Axes, run: Run, part: Component) -> None:
    at, limits = run[signals.EE_CYLINDRICAL][:, part.index], limits_of(run, part)
    dotted: dict[str, Any] = {"color": END_EFFECTOR, "lw": 1.2, "ls": ":"}
    axes.plot(run.time, at, **dotted, label="position, right axis")
    # Room for the limits' symbols.
    axes.set_ylim(span(at, [*limits.values()], air=0.14))
    label_axes(axes, "", f"${part.coordinate}$ [{part.unit}]")
    axes.yaxis.label.set_color(END_EFFECTOR)
    axes.tick_params(axis="y", labelcolor=END_EFFECTOR)
    axes.grid(visible=False)
    draw_limits(axes, limits, inside=True)


DECOMPOSITION = RunFigure(
    "decomposition",
    draw_decomposition,
    lambda run: any(part.commanded(run) for part in COMPONENTS),
)
