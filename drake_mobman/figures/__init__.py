"""The figures of a run: what the paper shows of a scenario, and how the hand moved."""

from collections.abc import Callable, Iterator

from matplotlib.figure import Figure

from drake_mobman import signals
from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.decomposers.blending import Blending
from drake_mobman.decomposers.exact import Exact
from drake_mobman.decomposers.switching import Switching
from drake_mobman.figures.end_effector import draw_hand_velocity, draw_path
from drake_mobman.figures.guided import (
    draw_base_commands,
    draw_hand_force,
    draw_manipulability,
    draw_zones,
)
from drake_mobman.figures.laws import draw_blending, draw_kappa
from drake_mobman.figures.strip import draw_strip
from drake_mobman.figures.style import law_of
from drake_mobman.figures.velocities import (
    draw_angular,
    draw_decomposition,
    draw_linear,
)
from drake_mobman.simulation.simulate import Run

Figures = dict[str, Callable[[Run], Figure | None]]
"""What draws each figure; None where the run has nothing to show in it."""

LAWS: dict[type, Figures] = {
    Blending: {"kappa": draw_kappa, "blending": draw_blending},
    Switching: {"kappa": draw_kappa, "blending": draw_blending},
    Exact: {"blending": draw_blending},
    VelocityField: {"zones": draw_zones},
}
"""What is drawn of the law that the base follows."""

COMMANDED: Figures = {
    "linear": draw_linear,
    "angular": draw_angular,
    "decomposition": draw_decomposition,
    "hand_velocity": draw_hand_velocity,
}
"""Where the hand is commanded."""

GUIDED: Figures = {"strip": draw_strip, "hand_force": draw_hand_force}
"""Where a hand pulls."""

ALWAYS: Figures = {
    "path": draw_path,
    "base_commands": draw_base_commands,
    "manipulability": draw_manipulability,
}


def draw_figures(run: Run) -> Iterator[tuple[str, Figure]]:
    """Yields the names and figures of a run, as wide as a page's text.

    Each is drawn when it is asked for. A run that died may be as short as one sample;
    of one that logged nothing there is nothing to draw.
    """
    if not len(run.log["time"]):
        return
    for name, draw in figures_of(run).items():
        figure = draw(run)
        if figure:
            yield name, figure


def figures_of(run: Run) -> Figures:
    """Returns what draws the figures of a run that has logged something."""
    law = LAWS.get(type(law_of(run.scenario)), {})
    hand = GUIDED if signals.HAND_FORCE in run.log else COMMANDED
    return law | hand | ALWAYS
