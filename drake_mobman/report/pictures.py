"""The pictures of a run, as files: its figures, and its motion in 3D.

Matplotlib takes half a second to import. A run without figures does not wait for it.
"""

import io
from typing import TYPE_CHECKING, Any

from drake_mobman.simulation.run import Run
from drake_mobman.simulation.run_folder import SCENE, Pictures

if TYPE_CHECKING:
    from drake_mobman.figures import RunFigure

PICTURED = 360_001
"""Largest number of samples shown in pictures: an hour at 0.01 s."""


def figures(run: Run) -> Pictures:
    """Returns functions that draw the figures of a run."""
    if not len(run.time):
        return {}
    from drake_mobman.figures import figures_of
    from drake_mobman.figures.style import SMALL

    shown, note = run.first(PICTURED), shown_of(run)

    def drawn(figure: "RunFigure") -> bytes:
        made = figure.draw(shown)
        if note:
            place: dict[str, Any] = {
                "ha": "right",
                "va": "bottom",
                "fontsize": SMALL,
                "color": "0.45",
            }
            made.text(0.998, 0.002, note, **place)
        return png(made)

    return {
        f"figures/{figure.name}.png": lambda figure=figure: drawn(figure)  # type: ignore[misc]
        for figure in figures_of(shown)
    }


def scenes(run: Run) -> Pictures:
    """Returns a function that makes the 3D scene, if the run has two samples."""
    if len(run.time) < 2:
        return {}
    from drake_mobman.figures.scene import scene

    return {SCENE: lambda: scene(run.first(PICTURED)).encode()}


def shown_of(run: Run) -> str:
    """Returns a note on the part of a run that its pictures show; empty for all."""
    times = run.time
    if len(times) <= PICTURED:
        return ""
    return f"the first {times[PICTURED - 1]:g} of {times[-1]:g} s"


def png(figure: Any) -> bytes:
    """Returns a figure as the content of a file."""
    content = io.BytesIO()
    figure.savefig(content, format="png")
    return content.getvalue()
