"""Wheels that scrub: what friction makes of it, by a body that settles."""

import numpy as np
import pytest

from drake_mobman.robots.derive.skid import skid_track, wheel_loads

PLACES = np.array([(x, y) for y in (0.3, -0.3) for x in (0.25, -0.25)])

SETTLED = 0.01
"""Share by which a body on smoothed friction turns otherwise."""


def settled_track(places, loads):
    """Returns the track by the motion of a body of 1 kg and 0.1 kg m^2, mu g = 1.

    Its wheels run at 1 m/s, the left ones back.
    """
    V, step, smooth = np.zeros(3), 1e-3, 1e-3
    for _ in range(20_000):
        force = np.zeros(3)
        for (x, y), load in zip(places, loads, strict=True):
            slide = np.array([V[0] - V[2] * y + np.sign(y), V[1] + V[2] * x])
            fx, fy = -load * slide / (np.linalg.norm(slide) + smooth)
            force += [fx, fy, x * fy - y * fx]
        V = V + step * force / [1.0, 1.0, 0.1]
    return 2.0 / V[2]


@pytest.mark.parametrize(
    "loads",
    [
        (0.25, 0.25, 0.25, 0.25),
        (0.3, 0.2, 0.3, 0.2),
        (0.4, 0.1, 0.4, 0.1),
        (0.35, 0.3, 0.2, 0.15),
    ],
)
def test_the_base_turns_as_friction_settles_it(loads):
    found = skid_track(PLACES, np.array(loads))
    assert found == pytest.approx(settled_track(PLACES, loads), rel=SETTLED)


def test_wheels_that_are_loaded_alike_scrub_alike():
    expected = 0.6 + 4 * 0.25**2 / 0.6
    assert skid_track(PLACES, np.full(4, 0.25)) == pytest.approx(expected, rel=1e-9)


def test_wheels_that_carry_nothing_do_not_scrub():
    assert skid_track(PLACES, np.array([0.5, 0.0, 0.5, 0.0])) == pytest.approx(0.6)


@pytest.mark.parametrize("centre", [(0.0, 0.0), (0.1, 0.0), (-0.05, 0.1)])
def test_loads_hold_the_weight_where_it_is(centre):
    loads = wheel_loads(PLACES, np.array(centre))
    assert loads.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(loads @ PLACES, centre, atol=1e-12)


def test_no_wheel_pulls_where_the_weight_is_out_of_their_square():
    assert wheel_loads(PLACES, np.array([0.4, 0.0])).min() >= 0.0
