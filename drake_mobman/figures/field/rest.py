"""How far from a hand at rest the base comes to rest, which the paper leaves out."""

import itertools
import math
from collections.abc import Sequence
from string import ascii_lowercase
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drake_mobman.base import Smoothing
from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.figures.field.approach import DURATION, distances
from drake_mobman.figures.field.style import ORANGE, OUT_OF_REACH, PURPLE, RAYS, note
from drake_mobman.figures.style import (
    COMMAND_LINE,
    END_EFFECTOR,
    TEXT,
    finish,
    label_axes,
    new_figure,
)
from drake_mobman.robot_model import Reach

BEARINGS: Sequence[float] = np.linspace(-math.pi, math.pi, 73).tolist()
"""From the base to the hand, at the start [rad]."""

_AMID: dict[str, Any] = {"ha": "center", "va": "center", "color": "0.3"}
_BETWEEN: dict[str, Any] = {"color": END_EFFECTOR, "alpha": 0.3, "lw": 0}


def draw_rest(
    fields: Sequence[VelocityField],
    reach: Reach,
    smoother: Smoothing,
    bearings: Sequence[float] = BEARINGS,
) -> Figure:
    """Draws how far from a hand at rest the base gets, and where it ends [m].

    Over the hand's bearing at the start [rad]. A row for each of `fields`, which differ
    in their law; a column for each distance at the start, at the shoulder's height.
    """
    starts = _starts(fields[0], reach)
    figure = new_figure(4.4)
    panels = figure.subplots(len(fields), len(starts), sharex=True, sharey=True)
    cases = itertools.product(fields, starts.values())
    for axes, letter, (params, start) in zip(
        panels.flat, ascii_lowercase, cases, strict=False
    ):
        _draw_zones(axes, params, reach)
        found = [distances(start, phi, params, reach, smoother) for phi in bearings]
        nearest, farthest, last = np.array(found).T
        axes.axhline(start, **COMMAND_LINE, label="at the start")
        axes.fill_between(bearings, nearest, farthest, label="meanwhile", **_BETWEEN)
        label = f"after {DURATION:g} s"
        axes.plot(bearings, last, color=END_EFFECTOR, lw=1.4, label=label)
        label_axes(axes, letter=letter)
    for axes, (where, start) in zip(panels[0], starts.items(), strict=True):
        axes.set_title(f"{where}, {start:.3g} m", fontsize=TEXT)
    for axes in panels[-1]:
        axes.set_xlabel(r"$\varphi$ at the start [rad]", fontsize=TEXT)
    for axes, params in zip(panels[:, 0], fields, strict=True):
        axes.set_ylabel(f"distance [m], {params.law}", fontsize=TEXT)
        _name_zones(axes, params, reach)
    axes.set_xlim(-math.pi, math.pi)
    axes.set_ylim(bottom=0)
    axes.set_xticks(
        [-math.pi, -math.pi / 2, 0, math.pi / 2, math.pi],
        [r"$-\pi$", r"$-\pi/2$", "0", r"$\pi/2$", r"$\pi$"],
    )
    return finish(figure, "Distance from the shoulder to a hand at rest")


def _starts(params: VelocityField, reach: Reach) -> dict[str, float]:
    """Returns the distances at the start [m], by name."""
    retreat, forward = _thresholds(params, reach)
    return {
        "retreat zone": retreat - params.Delta_r / 2,
        "forward zone": forward + params.Delta_f / 2,
        "arm stretched": reach.r_f,
    }


def _thresholds(params: VelocityField, reach: Reach) -> tuple[float, float]:
    """Returns where the retreat zone ends and the forward zone begins [m]."""
    return params.b_d + params.Delta_r, reach.r_f - params.Delta_f


def _draw_zones(axes: Axes, params: VelocityField, reach: Reach) -> None:
    retreat, forward = _thresholds(params, reach)
    axes.set_facecolor(OUT_OF_REACH)
    axes.axhspan(0, reach.r_f, color="white", lw=0)
    axes.axhspan(forward, reach.r_f, color=ORANGE, alpha=0.4, lw=0)
    axes.axhspan(0, retreat, color=PURPLE, alpha=0.4, lw=0)
    for phi in (params.phi_min, params.phi_max):
        for side in (phi, -phi):
            axes.axvline(side, **RAYS)


def _name_zones(axes: Axes, params: VelocityField, reach: Reach) -> None:
    retreat, forward = _thresholds(params, reach)
    for zone, height in (
        ("retreat", retreat / 2),
        ("forward", (forward + reach.r_f) / 2),
        ("out of reach", 1.3 * reach.r_f),
    ):
        note(axes, zone, (-2.0, height), (0, 0), **_AMID)
