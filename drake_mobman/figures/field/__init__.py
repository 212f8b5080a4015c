"""The figures of a velocity field, under both of its laws."""

import dataclasses as dc
from collections.abc import Iterator, Sequence

from matplotlib.figure import Figure

from drake_mobman.base import Smoothing
from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.figures.field.rest import BEARINGS, draw_rest
from drake_mobman.figures.field.slices import PIXELS, draw_side, draw_top
from drake_mobman.robot_model import Reach

LAWS = ("printed", "projected")


def field_figures(
    params: VelocityField,
    reach: Reach,
    smoother: Smoothing,
    *,
    pixels: int = PIXELS,
    bearings: Sequence[float] = BEARINGS,
) -> Iterator[tuple[str, Figure]]:
    """Yields the names and figures of a field under both laws, whatever its own is.

    Each is drawn when the iterator gets to it.

    Args:
        params: of the field.
        reach: of the arm.
        smoother: of the base commands.
        pixels: of a slice, along either side.
        bearings: from the base to a hand at rest, at the start [rad].
    """
    fields = [dc.replace(params, law=law) for law in LAWS]
    for field in fields:
        yield f"field_side_{field.law}", draw_side(field, reach, smoother, pixels)
    for field in fields:
        yield f"field_top_{field.law}", draw_top(field, reach, smoother, pixels)
    yield "field_rest", draw_rest(fields, reach, smoother, bearings)
