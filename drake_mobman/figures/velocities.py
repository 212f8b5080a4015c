"""The velocity that the base makes, and the arm's (Kwon et al., fig. 9)."""

from matplotlib.figure import Figure

from drake_mobman import signals
from drake_mobman.figures.components import ANGULAR, LINEAR, Component, limits_of
from drake_mobman.figures.law import law_of, name_of
from drake_mobman.figures.run_figure import RunFigure
from drake_mobman.figures.style import (
    ARM_LINE,
    BASE_LINE,
    COMMAND_LINE,
    EE_LINE,
    TIME,
    draw_limits,
    draw_limits_across,
    finish,
    label_axes,
    new_figure,
    span,
)
from drake_mobman.simulation.run import Run


def draw_linear(run: Run) -> Figure:
    """Draws l [m] and v_c, v_b, v_m [m/s] over time, and these over l (fig. 9 a-d)."""
    return _draw_component(run, LINEAR)


def draw_angular(run: Run) -> Figure:
    """Draws psi [rad] and omega_c, omega_b, omega_m [rad/s], as fig. 9 e-h."""
    return _draw_component(run, ANGULAR)


def _draw_component(run: Run, part: Component) -> Figure:
    i, time = part.index, run.time
    at, limits = run[signals.EE_CYLINDRICAL][:, i], limits_of(run, part)
    of_position = f"${part.coordinate}$ [{part.unit}]"
    of_rate = f"${part.rate}$ [{part.rate_unit}]"
    figure = new_figure(3.4)
    panels = figure.subplot_mosaic([["at", "over"], ["rates", "over"]])
    panels["at"].plot(time, at, **EE_LINE, label=f"${part.coordinate}$")
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
            axes.plot(x, run[signal][:, i], **line, label=label)
    panels["rates"].sharex(panels["at"])
    panels["at"].tick_params(labelbottom=False)
    label_axes(panels["at"], "", of_position, "a")
    label_axes(panels["rates"], TIME, of_rate)
    label_axes(panels["over"], of_position, of_rate, "b")
    return finish(figure, f"{part.name} velocity, {name_of(law_of(run.scenario))}")


LINEAR_VELOCITY = RunFigure("linear", draw_linear, LINEAR.commanded)
ANGULAR_VELOCITY = RunFigure("angular", draw_angular, ANGULAR.commanded)
