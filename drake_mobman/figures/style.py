"""What all figures have in common: size, colours, axes, limits, legend.

Everything is set on the figure itself: matplotlib's global state is left alone.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.decomposers.blending import Blending
from drake_mobman.scenario import AnyScenario, Guided

TIME = "time [s]"

WIDTH = 6.7  # Of a page's text [in].
TEXT = 8  # [pt].
SMALL = 7  # [pt].

# Okabe & Ito's colours, which the colour-blind tell apart.
COMMAND = "black"
BASE = "#0072B2"
ARM = "#D55E00"
HAND = "#009E73"
ERROR = "#CC79A7"
LIMIT = "0.45"
FORWARD = "#E69F00"
RETREAT = "#6A3D9A"
ROTATION = "#56B4E9"

# Dashed as in the paper's fig. 10, so that lines that lie on each other are all seen.
COMMAND_LINE: dict[str, Any] = {"color": COMMAND, "lw": 3.0, "alpha": 0.3}
BASE_LINE: dict[str, Any] = {"color": BASE, "lw": 1.2, "ls": "-."}
ARM_LINE: dict[str, Any] = {"color": ARM, "lw": 1.2, "ls": "--"}
HAND_LINE: dict[str, Any] = {"color": HAND, "lw": 1.2}
ERROR_LINE: dict[str, Any] = {"color": ERROR, "lw": 1.2}
LIMIT_LINE: dict[str, Any] = {"color": LIMIT, "lw": 0.8, "ls": (0, (6, 3))}


def new_figure(height: float) -> Figure:
    """Returns an empty figure of `height` [in]."""
    return Figure(figsize=(WIDTH, height), dpi=150, layout="constrained")


def law_of(scenario: AnyScenario) -> Any:
    """Returns what tells the base where to go: a field, or a decomposer."""
    return scenario.field if isinstance(scenario, Guided) else scenario.decomposer


def name_of(decomposer: Any) -> str:
    """Returns a decomposer's or field's name as a title says it."""
    if isinstance(decomposer, VelocityField):
        return f"{decomposer.law} field"
    if isinstance(decomposer, Blending):
        return (
            rf"blending, $\alpha$ = {decomposer.alpha:g} 1/m,"
            rf" $\beta$ = {decomposer.beta:g} 1/rad"
            + (", smoothstep" if decomposer.share == "smoothstep" else "")
        )
    return type(decomposer).__name__.lower()


def label_axes(axes: Axes, x: str = "", y: str = "", letter: str = "") -> None:
    """Names the axes, and the panel where it has a letter."""
    axes.set_xlabel(x, fontsize=TEXT)
    axes.set_ylabel(y, fontsize=TEXT)
    axes.tick_params(labelsize=SMALL)
    axes.grid(color="0.92", lw=0.6)
    axes.set_axisbelow(True)
    if letter:
        # Above the tick labels, where no limit's name comes.
        axes.annotate(
            f"({letter})",
            (0.0, 1.0),
            xytext=(-8, 5),
            xycoords="axes fraction",
            textcoords="offset points",
            ha="right",
            fontsize=TEXT,
        )


def near(limits: Mapping[str, float], x: np.ndarray) -> dict[str, float]:
    """Returns the limits by which the data `x` are worth seeing.

    A limit far beyond the range of the data would shrink them to a line; where all are,
    they stay.
    """
    low, high = float(np.min(x)), float(np.max(x))
    air = 2.0 * (high - low)
    seen = {k: at for k, at in limits.items() if low - air <= at <= high + air}
    return seen or dict(limits)


def draw_limits(axes: Axes, limits: Mapping[str, float], inside: bool = False) -> None:
    """Draws limits of the coordinate that stands upwards, each with its symbol.

    The symbols stand right of the axes, or `inside`, in the margin left of the data.
    """
    for symbol, value in limits.items():
        axes.axhline(value, **LIMIT_LINE)
        axes.annotate(
            f"${symbol}$",
            (0.0 if inside else 1.0, value),
            xycoords=("axes fraction", "data"),
            xytext=(4, 0),
            textcoords="offset points",
            va="center",
            fontsize=SMALL,
            color=LIMIT,
            bbox={"fc": "white", "ec": "none", "pad": 0.5},
        )


def draw_limits_across(axes: Axes, limits: Mapping[str, float]) -> None:
    """Draws limits of the coordinate that runs across, each with its symbol on top."""
    for symbol, value in limits.items():
        axes.axvline(value, **LIMIT_LINE)
        axes.annotate(
            f"${symbol}$",
            (value, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, 3),
            textcoords="offset points",
            ha="center",
            fontsize=SMALL,
            color=LIMIT,
        )


def finish(figure: Figure, title: str) -> Figure:
    """Returns the figure with its title and one legend, each label once, on top."""
    entries: dict[str, Any] = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    figure.legend(
        entries.values(),
        entries.keys(),
        title=title,
        loc="outside upper center",
        ncols=len(entries),
        handlelength=2.4,
        columnspacing=1.4,
        fontsize=TEXT,
        title_fontsize=TEXT + 1,
        frameon=False,
    )
    figure.align_ylabels()
    return figure


def span(
    *data: ArrayLike, air: float = 0.05, least: float = 0.01
) -> tuple[float, float]:
    """Returns the range of all data and `air` of it to either side, `least` wide.

    What is not a number is not drawn, and does not count.
    """
    x = np.concatenate([np.ravel(part) for part in data])
    low, high = float(np.nanmin(x)), float(np.nanmax(x))
    more = max(air * (high - low), 0.5 * (least - (high - low)))
    return low - more, high + more
