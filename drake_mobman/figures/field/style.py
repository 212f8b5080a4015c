"""Colours and lines of a velocity field's figures."""

from typing import Any

from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap

from drake_mobman.figures.style import BASE, SMALL

ORANGE, PURPLE = "#fdb863", "#b2abd2"

# As in the paper: purple backward, white at rest, orange forward.
COLOURS = LinearSegmentedColormap.from_list(
    "field", ["#5e3c99", PURPLE, "white", ORANGE, "#e66101"]
)

OUT_OF_REACH = "0.94"

RAYS: dict[str, Any] = {
    "color": BASE,
    "lw": 1.1,
    "ls": (0, (1, 1.2)),
    "label": r"rotation, $\varphi_\mathrm{min}$, $\varphi_\mathrm{max}$",
}
"""Of the bearings where the rotation zone begins, and where it is full."""


def note(
    axes: Axes,
    text: str,
    at: tuple[float, float],
    away: tuple[float, float],
    coordinates: Any = "data",
    **how: Any,
) -> None:
    """Writes `text` at a distance `away` [pt] from a point."""
    axes.annotate(
        text,
        at,
        xycoords=coordinates,
        xytext=away,
        textcoords="offset points",
        fontsize=SMALL,
        **how,
    )
