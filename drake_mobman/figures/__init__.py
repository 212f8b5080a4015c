"""The figures of a run: what the papers show of a scenario, and the true motion.

A new figure is a file beside this one with a `RunFigure`, and a line that imports it
here.
"""

from collections.abc import Iterator

from matplotlib.figure import Figure

from drake_mobman.figures.run_figure import RunFigure
from drake_mobman.simulation.run import Run

# In the order in which figures are drawn.
# isort: off
from drake_mobman.figures.kappa import KAPPA
from drake_mobman.figures.authority import AUTHORITY
from drake_mobman.figures.zones import ZONES_OF_T
from drake_mobman.figures.velocities import LINEAR_VELOCITY, ANGULAR_VELOCITY
from drake_mobman.figures.decomposition import DECOMPOSITION
from drake_mobman.figures.ee_velocity import EE_VELOCITY
from drake_mobman.figures.strip import STRIP
from drake_mobman.figures.hand_force import HAND_FORCE
from drake_mobman.figures.path import PATH
from drake_mobman.figures.base_commands import BASE_COMMANDS
from drake_mobman.figures.manipulability import MANIPULABILITY

# isort: on

__all__ = ["FIGURES", "RunFigure", "draw_figures", "figures_of"]

FIGURES = [figure for figure in [*globals().values()] if isinstance(figure, RunFigure)]
"""All figures of a run: those imported above, in their order."""


def figures_of(run: Run) -> list[RunFigure]:
    """Returns the figures that apply to a run of one sample or more."""
    return [figure for figure in FIGURES if figure.applies(run)]


def draw_figures(run: Run) -> Iterator[tuple[str, Figure]]:
    """Yields the names and figures of a run; none where nothing was logged.

    Each is drawn when the iterator gets to it. A run that died may have one sample.
    """
    if len(run.time):
        for figure in figures_of(run):
            yield figure.name, figure.draw(run)
