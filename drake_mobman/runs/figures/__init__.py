"""The figures of a run: what the paper shows of a scenario, and how the hand moved."""

from collections.abc import Callable, Iterator

from matplotlib.figure import Figure

from drake_mobman.runs.figures.hand import draw_hand_velocity, draw_path
from drake_mobman.runs.figures.laws import draw_blending, draw_kappa
from drake_mobman.runs.figures.velocities import (
    draw_angular,
    draw_decomposition,
    draw_linear,
)
from drake_mobman.runs.simulate import Run

FIGURES: dict[str, Callable[[Run], Figure | None]] = {
    "kappa": draw_kappa,
    "blending": draw_blending,
    "linear": draw_linear,
    "angular": draw_angular,
    "decomposition": draw_decomposition,
    "hand_velocity": draw_hand_velocity,
    "path": draw_path,
}
"""What draws each figure; None where the run has nothing to show in it."""


def draw_figures(run: Run) -> Iterator[tuple[str, Figure]]:
    """Yields the names and figures of a run, as wide as a page's text.

    Each is drawn when it is asked for. A run that died may be as short as one sample;
    of one that logged nothing there is nothing to draw.
    """
    if not len(run.log["time"]):
        return
    for name, draw in FIGURES.items():
        figure = draw(run)
        if figure:
            yield name, figure
