"""What all figures have in common: size, colours, axes, limits, legend.

Everything is set on the figure itself; matplotlib's global state is not touched.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

TIME = "time [s]"

WIDTH = 6.7  # Of a page's text [in].
TEXT = 8  # [pt].
SMALL = 7  # [pt].

# Okabe & Ito's colours, which colour-blind people can distinguish.
COMMAND = "black"
BASE = "#0072B2"
ARM = "#D55E00"
END_EFFECTOR = "#009E73"  # And the hand that guides it.
ERROR = "#CC79A7"
LIMIT = "0.45"
FORWARD = "#E69F00"
RETREAT = "#6A3D9A"
ROTATION = "#56B4E9"

TINT = 0.3  # Opacity of a band.

# Dashed as in the paper's fig. 10, so that lines on top of each other are all visible.
COMMAND_LINE: dict[str, Any] = {"color": COMMAND, "lw": 3.0, "alpha": 0.3}
BASE_LINE: dict[str, Any] = {"color": BASE, "lw": 1.2, "ls": "-."}
ARM_LINE: dict[str, Any] = {"color": ARM, "lw": 1.2, "ls": "--"}
EE_LINE: dict[str, Any] = {"color": END_EFFECTOR, "lw": 1.2}
ERROR_LINE: dict[str, Any] = {"color": ERROR, "lw": 1.2}
LIMIT_LINE: dict[str, Any] = {"color": LIMIT, "lw": 0.8, "ls": (0, (6, 3))}


def new_figure(height: float) -> Figure:
    """Returns an empty figure of `height` [in]."""
    return Figure(figsize=(WIDTH, height), dpi=150, layout="constrained")


def label_axes(axes: Axes, x: str = "", y: str = "", letter: str = "") -> None:
    """Labels the axes, and the panel if it has a letter."""
    axes.set_xlabel(x, fontsize=TEXT)
    axes.set_ylabel(y, fontsize=TEXT)
    axes.tick_params(labelsize=SMALL)
    axes.grid(color="0.92", lw=0.6)
    axes.set_axisbelow(True)
    if letter:
        # Above the tick labels, out of the way of the limits' symbols.
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
    """Returns the limits near enough to the data `x` to be drawn with them.

    A limit far away would shrink the data to a flat line. If all are far away, all are
    returned.
    """
    low, high = float(np.min(x)), float(np.max(x))
    air = 2.0 * (high - low)
    seen = {k: at for k, at in limits.items() if low - air <= at <= high + air}
    return seen or dict(limits)


def draw_limits(axes: Axes, limits: Mapping[str, float], inside: bool = False) -> None:
    """Draws limits of the vertical coordinate as lines, each with its symbol.

    The symbols are to the right of the axes, or `inside`, in the left margin.
    """
    x = 0.0 if inside else 1.0
    for symbol, value in limits.items():
        axes.axhline(value, **LIMIT_LINE)
        label = _name_limit(axes, symbol, (x, value), ("axes fraction", "data"), (4, 0))
        label.set(va="center", bbox={"fc": "white", "ec": "none", "pad": 0.5})


def draw_limits_across(axes: Axes, limits: Mapping[str, float]) -> None:
    """Draws limits of the horizontal coordinate, each with its symbol on top."""
    for symbol, value in limits.items():
        axes.axvline(value, **LIMIT_LINE)
        at = (value, 1.0), ("data", "axes fraction"), (0, 3)
        _name_limit(axes, symbol, *at).set(ha="center")


def _name_limit(
    axes: Axes,
    symbol: str,
    at: tuple[float, float],
    coordinates: tuple[str, str],
    offset: tuple[float, float],
) -> Any:
    """Returns a limit's symbol, drawn some points off a place in `coordinates`."""
    how: Any = {"textcoords": "offset points", "fontsize": SMALL, "color": LIMIT}
    return axes.annotate(f"${symbol}$", at, offset, xycoords=coordinates, **how)


def finish(figure: Figure, title: str) -> Figure:
    """Returns the figure with its title and one legend on top, each label once."""
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
    """Returns the range of all data, NaN excepted, for the limits of an axis.

    Args:
        data: arrays of any shape.
        air: margin on either side, as a share of the range.
        least: smallest range.
    """
    x = np.concatenate([np.ravel(part) for part in data])
    low, high = float(np.nanmin(x)), float(np.nanmax(x))
    more = max(air * (high - low), 0.5 * (least - (high - low)))
    return low - more, high + more


def draw_between(axes: Axes, limits: Mapping[str, float], *data: np.ndarray) -> None:
    """Draws those limits that the data come near, and scales the axes to both."""
    limits = near(limits, np.concatenate(data))
    axes.set_ylim(span(*data, [*limits.values()]))
    draw_limits(axes, limits)


def symmetric(symbol: str, limit: float) -> dict[str, float]:
    """Returns a limit that holds in both directions, by its symbols."""
    return {symbol: limit, f"-{symbol}": -limit}


def draw_band(
    axes: Axes, time: np.ndarray, inside: np.ndarray, colour: str, label: str
) -> None:
    """Colours the axes from bottom to top where `inside` (N,) is true."""
    axes.fill_between(
        time,
        0.0,
        1.0,
        where=inside,
        step="post",
        transform=axes.get_xaxis_transform(),
        color=colour,
        alpha=TINT,
        lw=0,
        label=label if inside.any() else None,
    )
