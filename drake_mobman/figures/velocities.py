"""Who makes the commanded velocity, base or arm: the paper's figs. 9 and 10."""

import dataclasses as dc
from string import ascii_lowercase

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drake_mobman import signals
from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.figures.style import (
    ARM_LINE,
    BASE_LINE,
    COMMAND_LINE,
    HAND,
    HAND_LINE,
    TIME,
    draw_limits,
    draw_limits_across,
    finish,
    label_axes,
    law_of,
    name_of,
    near,
    new_figure,
    span,
)
from drake_mobman.simulation.log import Log
from drake_mobman.simulation.simulate import Run


@dc.dataclass(frozen=True)
class Component:
    """One of the commands, and the coordinate of `workspace` that it changes."""

    index: int  # In `ee_command`, `workspace` and `arm_command`.
    name: str
    rate: str  # Symbol of the velocity.
    rate_unit: str
    coordinate: str  # Symbol of the coordinate.
    unit: str  # Of the coordinate.

    def commanded(self, log: Log) -> bool:
        """Returns whether the operator ever asks for it."""
        return bool(np.any(log[signals.EE_COMMAND][:, self.index]))


LINES = {"command": COMMAND_LINE, "sum": HAND_LINE, "base": BASE_LINE, "arm": ARM_LINE}

LINEAR = Component(0, "Linear", "v", "m/s", "l", "m")
ANGULAR = Component(1, "Angular", r"\omega", "rad/s", r"\psi", "rad")
VERTICAL = Component(2, "Vertical", "v_z", "m/s", "z", "m")


def draw_linear(run: Run) -> Figure | None:
    """Draws l [m] and v_c, v_b, v_m [m/s] over time, and these over l (fig. 9 a-d)."""
    return _draw_component(run, LINEAR)


def draw_angular(run: Run) -> Figure | None:
    """Draws psi [rad] and omega_c, omega_b, omega_m [rad/s], as fig. 9 e-h."""
    return _draw_component(run, ANGULAR)


def _draw_component(run: Run, part: Component) -> Figure | None:
    log, i = run.log, part.index
    if not part.commanded(log):
        return None
    time, at = log["time"], log[signals.EE_CYLINDRICAL][:, i]
    limits = _limits(run, part)
    of_hand = f"${part.coordinate}$ [{part.unit}]"
    of_rate = f"${part.rate}$ [{part.rate_unit}]"
    figure = new_figure(3.4)
    panels = figure.subplot_mosaic([["at", "over"], ["rates", "over"]])
    panels["at"].plot(time, at, **HAND_LINE, label=f"${part.coordinate}$")
    panels["at"].set_ylim(span(at, [*limits.values()]))
    draw_limits(panels["at"], limits)
    draw_limits_across(panels["over"], limits)
    for axes, x in ((panels["rates"], time), (panels["over"], at)):
        for signal, symbol, line in (
            (signals.EE_COMMAND, "c", COMMAND_LINE),
            (signals.BASE_COMMAND_SMOOTHED, "b", BASE_LINE),
            (signals.ARM_COMMAND, "m", ARM_LINE),
        ):
            label = f"${part.rate}_{symbol}$"
            axes.plot(x, log[signal][:, i], **line, label=label)
    panels["rates"].sharex(panels["at"])
    panels["at"].tick_params(labelbottom=False)
    label_axes(panels["at"], "", of_hand, "a")
    label_axes(panels["rates"], TIME, of_rate)
    label_axes(panels["over"], of_hand, of_rate, "b")
    return finish(figure, f"{part.name} velocity, {name_of(law_of(run.scenario))}")


def draw_decomposition(run: Run) -> Figure | None:
    """Draws what is commanded and what base and arm make of it, over time (fig. 10).

    A panel for each command, v_c [m/s] with l [m] and omega_c [rad/s] with psi [rad]
    (a, b), then one for each with the base's share, the arm's and their sum (c, d),
    then v_z [m/s] with z [m], all the arm's. What is never commanded is left out.
    """
    asked = [part for part in (LINEAR, ANGULAR, VERTICAL) if part.commanded(run.log)]
    split = [part for part in asked if part is not VERTICAL]
    rows: list[tuple[Component, tuple[str, ...]]] = [
        (part, ("command",)) for part in split
    ]
    rows += [(part, tuple(LINES)) for part in split]
    rows += [(part, ("command", "arm")) for part in asked if part is VERTICAL]
    if not rows:
        return None
    figure = new_figure(0.9 + 1.25 * len(rows))
    panels = figure.subplots(len(rows), 1, sharex=True, squeeze=False)[:, 0]
    for axes, letter, (part, names) in zip(panels, ascii_lowercase, rows, strict=False):
        lines = _outputs(run.log, part)
        for name in names:
            axes.plot(run.log["time"], lines[name], **LINES[name], label=name)
        x = TIME if axes is panels[-1] else ""
        rate = f"{part.rate}_c" if names == ("command",) else part.rate
        label_axes(axes, x, f"${rate}$ [{part.rate_unit}]", letter)
        if "base" not in names:
            _draw_coordinate(axes.twinx(), run, part)
    return finish(figure, f"Command and outputs, {name_of(law_of(run.scenario))}")


def _outputs(log: Log, part: Component) -> dict[str, np.ndarray]:
    """Returns what is asked for and what comes of it (N,), by names of `LINES`."""
    arm = log[signals.ARM_COMMAND][:, part.index]
    lines = {"command": log[signals.EE_COMMAND][:, part.index], "arm": arm}
    if part is not VERTICAL:
        base = log[signals.BASE_CONTRIBUTION][:, part.index]
        lines |= {"base": base, "sum": base + arm}
    return lines


def _draw_coordinate(axes: Axes, run: Run, part: Component) -> None:
    at = run.log[signals.EE_CYLINDRICAL][:, part.index]
    limits = _limits(run, part)
    axes.plot(
        run.log["time"], at, color=HAND, lw=1.2, ls=":", label="position, right axis"
    )
    # Room for the limits' symbols.
    axes.set_ylim(span(at, [*limits.values()], air=0.14))
    label_axes(axes, "", f"${part.coordinate}$ [{part.unit}]")
    axes.yaxis.label.set_color(HAND)
    axes.tick_params(axis="y", labelcolor=HAND)
    axes.grid(visible=False)
    draw_limits(axes, limits, inside=True)


def _limits(run: Run, part: Component) -> dict[str, float]:
    """Returns the limits to draw for a coordinate, by their symbols.

    There are none of z, and none that a field goes by.
    """
    workspace = run.scenario.workspace
    if isinstance(law_of(run.scenario), VelocityField):
        return {}
    if part is LINEAR:
        symbol, low, high = "L", workspace.l_min, workspace.l_max
    elif part is ANGULAR:
        symbol, low, high = r"\Psi", workspace.psi_min, workspace.psi_max
    else:
        return {}
    limits = {rf"{symbol}_\mathrm{{min}}": low, rf"{symbol}_\mathrm{{max}}": high}
    return near(limits, run.log[signals.EE_CYLINDRICAL][:, part.index])
