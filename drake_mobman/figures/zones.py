"""The zones of the velocity field that T was in (Petric & Zlajpah, fig. 1)."""

import numpy as np
from matplotlib.figure import Figure

from drake_mobman import signals
from drake_mobman.base.velocity_field import (
    Zone,
    bearing,
    field_zone,
    signed_distances,
)
from drake_mobman.figures.law import law_of, name_of
from drake_mobman.figures.run_figure import RunFigure
from drake_mobman.figures.style import (
    ARM,
    BASE,
    EE_LINE,
    FORWARD,
    RETREAT,
    ROTATION,
    TIME,
    draw_band,
    draw_limits,
    finish,
    label_axes,
    new_figure,
    span,
    symmetric,
)
from drake_mobman.simulation.run import Run

ZONES = {
    "forward": (Zone.FORWARD, FORWARD),
    "retreat": (Zone.RETREAT, RETREAT),
    "rotation": (Zone.ROTATION, ROTATION),
}
"""Flag and colour of each zone; the passive zone is left white."""


def draw_zones(run: Run) -> Figure:
    """Draws the zones that T was in over time, and the quantities that decide it.

    T's distance from c and from the capsule's axis [m], between the thresholds of the
    forward and retreat zones (a); its bearing phi [rad], between those of the rotation
    zone (b).
    """
    time, points = run.time, run[signals.P_BT]
    field, reach = law_of(run.scenario), run.scenario.robot.reach()
    d_f, d_r = np.array([signed_distances(p, reach, field.b_d) for p in points]).T
    zone = np.array([field_zone(p, field, reach) for p in points]).astype(int)
    phi = np.array([bearing(p, reach) for p in points])
    figure = new_figure(3.9)
    distance, angle = figure.subplots(2, 1, sharex=True)

    distances = {
        "r_f": reach.r_f,
        r"r_f - \Delta_f": reach.r_f - field.Delta_f,
        r"b_d + \Delta_r": field.b_d + field.Delta_r,
        "b_d": field.b_d,
    }
    from_centre, from_axis = reach.r_f - d_f, d_r + field.b_d
    distance.plot(time, from_centre, **EE_LINE, label="from $c$")
    dashed = {"color": BASE, "lw": 1.2, "ls": "--"}
    distance.plot(time, from_axis, **dashed, label="from the body's axis")
    distance.set_ylim(span(from_centre, from_axis, [*distances.values()]))
    draw_limits(distance, distances)
    label_axes(distance, "", "distance of $T$ [m]", "a")

    angles = symmetric(r"\varphi_\mathrm{min}", field.phi_min)
    angles |= symmetric(r"\varphi_\mathrm{max}", field.phi_max)
    angle.plot(time, phi, color=ARM, lw=1.2, label=r"$\varphi$")
    angle.set_ylim(span(phi, [*angles.values()]))
    draw_limits(angle, angles)
    label_axes(angle, TIME, r"bearing $\varphi$ [rad]", "b")

    for name, (flag, colour) in ZONES.items():
        axes = angle if flag == Zone.ROTATION else distance
        draw_band(axes, time, zone & flag > 0, colour, name)
    return finish(figure, f"Zones of $T$, {name_of(field)}, passive where white")


ZONES_OF_T = RunFigure(
    "zones", draw_zones, lambda run: hasattr(law_of(run.scenario), "Delta_f")
)
