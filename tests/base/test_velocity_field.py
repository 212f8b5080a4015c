import dataclasses as dc
import itertools
import math
import time

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from pydrake.autodiffutils import InitializeAutoDiff
from pydrake.symbolic import MakeVectorVariable

from drake_mobman.base.smoother import Smoother, smoothed
from drake_mobman.base.unicycle import unicycle_rates
from drake_mobman.base.velocity_field import (
    VelocityField,
    VelocityFieldController,
    Zone,
    check_zones,
    field_on,
    field_velocity,
    field_zone,
)
from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import Reach
from drake_mobman.scalars import saturated

ROUNDING = 1e-12
"""Of a few operations on numbers of about one."""

PERIOD = 0.01
"""Of the control loop [s]."""

REACH = Reach(l_0=0.8, r_f=0.7)
STUDIED = VelocityField(K_f=2.0, K_r=2.0, K_omega=0.8)
"""The gains at which the printed law was first seen to run away; zones by default."""

FIELDS = [
    dc.replace(gains, law=law)
    for gains, law in itertools.product(
        (STUDIED, VelocityField()), ("printed", "projected")
    )
]
PRINTED, PROJECTED = FIELDS[:2]
every_field = pytest.mark.parametrize(
    "params", FIELDS, ids=lambda p: f"{p.law}-{p.K_f}"
)
projected_fields = pytest.mark.parametrize(
    "params", FIELDS[1::2], ids=lambda p: f"{p.law}-{p.K_f}"
)

FORWARD, RETREAT, ROTATION = Zone.FORWARD, Zone.RETREAT, Zone.ROTATION


def at(distance, phi, height=0.0):
    """A position of the hand by its level distance, bearing and height over S."""
    return distance * math.cos(phi), distance * math.sin(phi), REACH.l_0 + height


def paper(p, k, reach):
    """Eqs. 1-6 with the erratum of eq. 3, written down once more, another way."""
    from_c = np.subtract(p, [reach.ahead, reach.aside, reach.l_0])
    d_f = reach.r_f - np.linalg.norm(from_c)
    d_r = np.linalg.norm(from_c[:2] if p[2] <= reach.l_0 else from_c) - k.b_d
    v = np.select(
        [d_r < k.Delta_r, d_f < k.Delta_f],
        [-k.K_r * (k.Delta_r - d_r), k.K_f * (k.Delta_f - d_f)],
    )
    x, y, _ = from_c
    phi = math.atan2(y, x)
    s = np.clip((np.abs(phi) - k.phi_min) / (k.phi_max - k.phi_min), 0, 1)
    if k.law == "projected":
        v = v * p[0] / math.hypot(p[0], y)
    # How the bearing changes where the base turns at 1 rad/s, T at rest.
    x_dot, y_dot = p[1], -p[0]
    closing = -(x * y_dot - y * x_dot) / (x * x + y * y)
    helps = np.polyval([-2, 3, 0, 0], np.clip(2 * closing, 0, 1))
    return float(v), helps * k.K_omega * np.sign(phi) * np.polyval([-2, 3, 0, 0], s)


@every_field
@pytest.mark.parametrize(("ahead", "aside"), [(0.0, 0.0), (0.15, 0.0), (0.1, -0.2)])
def test_field_is_that_of_the_equations(params, ahead, aside):
    reach = dc.replace(REACH, ahead=ahead, aside=aside)
    points = np.random.default_rng(3).uniform([-1, -1, 0], [1, 1, 1.6], (200, 3))
    for p in points:
        expected = paper(p, params, reach)
        assert field_velocity(p, params, reach) == pytest.approx(expected, abs=ROUNDING)


@pytest.mark.parametrize(
    ("p", "printed", "projected", "omega", "zone"),
    [
        # Ahead at the shoulder's height: at rest, too far, too near.
        ((0.5, 0.0, 0.8), 0.0, 0.0, 0.0, 0),
        ((0.6, 0.0, 0.8), 0.1, 0.1, 0.0, FORWARD),
        ((0.35, 0.0, 0.8), -0.1, -0.1, 0.0, RETREAT),
        # To the left, where 3-4-5 triangles make the cosine 0.6; and to the right.
        ((0.3, 0.4, 0.8), 0.0, 0.0, 0.8, ROTATION),
        ((0.36, -0.48, 0.8), 0.1, 0.06, -0.8, FORWARD | ROTATION),
        # Behind, too far and too near: the projected law turns v round.
        ((-0.6, 0.0, 0.8), 0.1, -0.1, 0.8, FORWARD | ROTATION),
        ((-0.21, 0.28, 0.8), -0.1, 0.06, 0.8, RETREAT | ROTATION),
        # Square to the base.
        ((0.0, 0.36, 1.28), 0.1, 0.0, 0.8, FORWARD | ROTATION),
        # Straight above the shoulder the capsule is round, below it is upright.
        ((0.0, 0.0, 1.15), -0.1, -0.1, 0.0, RETREAT),
        ((0.35, 0.0, 0.6), -0.1, -0.1, 0.0, RETREAT),
        ((0.48, 0.0, 0.44), 0.1, 0.1, 0.0, FORWARD),
        # Low, in both zones: retreat goes first.
        ((0.36, 0.0, 0.32), -0.08, -0.08, 0.0, RETREAT),
        # A quarter, half and three quarters up the activation: 5/32, 1/2, 27/32.
        (at(0.5, 0.3), 0.0, 0.0, 0.125, ROTATION),
        (at(0.5, 0.4), 0.0, 0.0, 0.4, ROTATION),
        (at(0.5, -0.5), 0.0, 0.0, -0.675, ROTATION),
    ],
)
def test_field_is_as_worked_out_by_hand(p, printed, projected, omega, zone):
    assert field_velocity(p, PRINTED, REACH) == pytest.approx(
        (printed, omega), abs=ROUNDING
    )
    assert field_velocity(p, PROJECTED, REACH) == pytest.approx(
        (projected, omega), abs=ROUNDING
    )
    assert field_zone(p, PRINTED, REACH) == zone


@given(
    p=st.tuples(*[st.floats(-1.2, 1.2)] * 2),
    ahead=st.floats(-0.4, 0.4),
    aside=st.floats(-0.3, 0.3),
)
def test_turning_never_takes_a_hand_at_rest_further_aside(p, ahead, aside):
    reach = dc.replace(REACH, ahead=ahead, aside=aside)
    _, omega = field_velocity((*p, REACH.l_0), PROJECTED, reach)
    x, y, step = p[0] - ahead, p[1] - aside, 1e-6
    # Past the shoulder, the bearing jumps by a turn.
    assume(math.hypot(x, y) > 1e-3 and abs(math.atan2(y, x)) < 3.14)
    c, s = math.cos(step * omega), math.sin(step * omega)
    turned = c * p[0] + s * p[1] - ahead, c * p[1] - s * p[0] - aside
    before, after = math.atan2(y, x), math.atan2(turned[1], turned[0])
    assert abs(after) <= abs(before) + ROUNDING


@pytest.mark.parametrize(("ahead", "aside"), [(0.0, 0.2), (0.2, -0.2), (-0.3, 0.1)])
@pytest.mark.parametrize("bearing", [-2.9, -1.5, -0.6, 0.0, 0.8, 2.0, 3.0])
def test_the_base_rests_with_a_hand_at_rest_ahead_of_its_shoulder(
    ahead, aside, bearing
):
    reach = dc.replace(REACH, ahead=ahead, aside=aside)
    x, y, theta = pose = np.zeros(3)
    hand = ahead + 0.6 * math.cos(bearing), aside + 0.6 * math.sin(bearing)
    for _ in range(6000):
        x, y, theta = pose
        c, s = math.cos(theta), math.sin(theta)
        p = c * (hand[0] - x) + s * (hand[1] - y), c * (hand[1] - y) - s * (hand[0] - x)
        v, omega = field_velocity((*p, REACH.l_0), PROJECTED, reach)
        pose = pose + PERIOD * np.array([v * c, v * s, omega])
    phi = math.atan2(p[1] - aside, p[0] - ahead)
    assert abs(phi) < PROJECTED.phi_min + 0.02
    assert abs(v) < 0.01
    assert abs(omega) < 0.01


def jump(params, p, direction):
    """How far v and omega change across `p`, along `direction`."""
    step = 1e-9 * np.array(direction)
    before, after = (
        np.array(field_velocity(np.array(p) + side * step, params, REACH))
        for side in (-1, 1)
    )
    return np.abs(after - before)


SMOOTH = 1e-7
"""A change that no jump explains, over 2 nm in a field as steep as 1 / (5 cm s)."""


@every_field
@pytest.mark.parametrize(
    ("p", "across"),
    [
        (at(0.55, 0.3), at(1, 0.3, -0.8)),  # Into the forward zone, level,
        (at(0.33, 2.0, 0.44), (-0.3, 0.5, 0.8)),  # and above the shoulder.
        (at(0.4, -0.3), at(1, -0.3, -0.8)),  # Into the retreat zone, level,
        (at(0.32, 2.5, 0.24), (-0.5, 0.3, 0.5)),  # above,
        (at(0.4, 0.3, -0.3), at(1, 0.3, -0.8)),  # and below the shoulder.
        (at(0.2, 0.3), (0, 0, 1)),  # From the cylinder into the sphere on it,
        (at(0.4, 0.3), (0, 0, 1)),  # and along the edge of both.
        (at(0.6, 0.2), (0, 1, 0)),  # Into the rotation zone, left,
        (at(0.6, -0.2), (0, 1, 0)),  # and right;
        (at(0.6, 0.6), (0, 1, 0)),  # and to its full rate, left,
        (at(0.6, -0.6), (0, 1, 0)),  # and right.
        (at(0.6, 0.0), (0, 1, 0)),  # From one side to the other, ahead,
        (at(0.6, math.pi / 2), (1, 0, 0)),  # and from ahead to behind.
    ],
)
def test_field_is_continuous_across_the_edge(params, p, across):
    assert jump(params, p, across).max() < SMOOTH


@every_field
def test_yaw_rate_flips_where_the_hand_passes_straight_behind(params):
    v, omega = jump(params, at(0.6, math.pi), (0, 1, 0))
    assert v < SMOOTH
    assert omega == pytest.approx(2 * params.K_omega)


@every_field
def test_speed_jumps_where_retreat_meets_forward_below_the_shoulder(params):
    # At 0.5 m down the end of retreat, 0.4 m, is already outside of 0.55 m.
    v, omega = jump(params, at(0.4, 0.0, -0.5), (1, 0, 0))
    assert v == pytest.approx(params.K_f * (math.hypot(0.4, 0.5) - 0.55), abs=SMOOTH)
    assert omega < SMOOTH


def test_projected_speed_flips_where_the_hand_passes_over_the_shoulder():
    above = at(0.0, 0.0, 0.6)
    assert jump(PRINTED, above, (1, 0, 0))[0] < SMOOTH
    assert jump(PROJECTED, above, (1, 0, 0))[0] == pytest.approx(2 * 0.1)


@every_field
def test_a_hand_that_is_nowhere_makes_no_command_that_looks_like_one(params):
    assert np.isnan(field_velocity((math.nan, 0.0, 0.8), params, REACH)).all()


reachable = st.builds(
    lambda r, elevation, phi: at(r * math.cos(elevation), phi, r * math.sin(elevation)),
    st.floats(0.0, REACH.r_f),
    st.floats(-math.pi / 2, math.pi / 2),
    st.floats(-math.pi, math.pi),
)


@given(p=reachable, params=st.sampled_from(FIELDS[1::2]))
def test_projected_field_goes_after_a_far_hand_and_gives_way_to_a_near_one(p, params):
    v, omega = field_velocity(p, params, REACH)
    zone = Zone(int(field_zone(p, params, REACH)))
    rates = np.array([-v + omega * p[1], -omega * p[0], 0.0])  # Of p, by the base.
    out = np.subtract(p, [0, 0, REACH.l_0])
    if RETREAT in zone and p[2] <= REACH.l_0:
        out[2] = 0.0
    growth = out @ rates  # Distance times its rate.
    assert FORWARD not in zone or growth <= ROUNDING
    assert RETREAT not in zone or growth >= -ROUNDING
    assert zone & (FORWARD | RETREAT) or v == 0


def followed(hand, params, seconds, smoother=None, reach=REACH):
    """Where a hand that is held still is seen from a base that follows it.

    Returns p_BT (N, 3) and the last command sent; without a smoother, commands are
    limited to what the default one would let pass.
    """
    x, y, theta = 0.0, 0.0, 0.0
    limits = Smoother()
    sent = 0.0, 0.0
    seen = []
    for _ in range(round(seconds / PERIOD)):
        dx, dy, c, s = hand[0] - x, hand[1] - y, math.cos(theta), math.sin(theta)
        seen.append((c * dx + s * dy, c * dy - s * dx, hand[2]))
        v, omega = field_velocity(seen[-1], params, reach)
        if smoother is None:
            sent = saturated(v, limits.max_speed), saturated(omega, limits.max_yaw_rate)
        else:
            k, step, turn = (
                smoother.smoothing,
                smoother.max_acceleration * PERIOD,
                smoother.max_yaw_acceleration * PERIOD,
            )
            sent = (
                smoothed(sent[0], v, k, step, smoother.max_speed),
                smoothed(sent[1], omega, k, turn, smoother.max_yaw_rate),
            )
        x_dot, y_dot, theta_dot = unicycle_rates(theta, *sent)
        x, y = x + PERIOD * x_dot, y + PERIOD * y_dot
        theta += PERIOD * theta_dot
    return np.array(seen), sent


def test_printed_field_runs_away_from_a_hand_behind_and_projected_does_not():
    hand = at(0.65, 3.1)
    printed, _ = followed(hand, PRINTED, 10)
    projected, _ = followed(hand, PROJECTED, 10)
    assert 1.4 < np.hypot(*printed.T[:2]).max() < 1.5
    assert np.hypot(*projected.T[:2]).max() == pytest.approx(0.65, abs=ROUNDING)


AT_REST = 1e-3
"""Speed [m/s] or [rad/s] that counts as rest: omega dies away as 1 / t^2 only."""

AT_THE_EDGE = 1e-6
"""Of the passive zone [m]: speed is in proportion to the depth beyond it."""


@projected_fields
@pytest.mark.parametrize("height", [-0.35, 0.0, 0.25, 0.5])
def test_projected_field_brings_any_hand_to_rest_in_the_passive_zone(params, height):
    bearings = np.linspace(-math.pi, math.pi, 13)
    distances = [d for d in (0.02, 0.3, 0.45, 0.6, 0.7) if math.hypot(d, height) <= 0.7]
    for distance, phi in itertools.product(distances, bearings):
        seen, sent = followed(at(distance, phi, height), params, 25, Smoother())
        level = math.hypot(seen[-1][0], seen[-1][1])
        assert math.hypot(level, height) < 0.55 + AT_THE_EDGE
        assert (level if height <= 0 else math.hypot(level, height)) > 0.4 - AT_THE_EDGE
        assert np.abs(sent).max() < AT_REST


@pytest.mark.parametrize(("ahead", "aside"), [(0.2, 0.0), (0.1, 0.15), (0.0, -0.2)])
def test_projected_field_comes_to_rest_with_the_shoulder_off_the_axis(ahead, aside):
    reach = dc.replace(REACH, ahead=ahead, aside=aside)
    for x, y in itertools.product((-0.45, 0.0, 0.1, 0.2, 0.6), (-0.3, 0.0, 0.1)):
        seen, sent = followed((x, y, 0.8), VelocityField(), 15, Smoother(), reach)
        distance = math.hypot(seen[-1][0] - ahead, seen[-1][1] - aside)
        assert 0.4 - 1e-4 < distance < 0.55 + 1e-4  # Turning shifts it, as omega dies.
        assert np.abs(sent).max() < AT_REST


@every_field
def test_figure_holds_what_the_field_says_at_each_point(params):
    points = np.random.default_rng(4).uniform([-1, -1, 0], [1, 1, 1.6], (4, 5, 3))
    v, omega, zone = field_on(points, params, REACH)
    for i in np.ndindex(4, 5):
        assert (v[i], omega[i]) == field_velocity(points[i], params, REACH)
        assert zone[i] == field_zone(points[i], params, REACH)


def test_slice_of_400_by_400_takes_less_than_two_seconds():
    x, y = np.meshgrid(np.linspace(-1, 1, 400), np.linspace(-1, 1, 400))
    start = time.process_time()  # Of this process: others may be busy.
    v, _, _ = field_on(np.stack([x, y, 0.3 + 0 * x], axis=-1), PROJECTED, REACH)
    assert time.process_time() - start < 2
    assert v.shape == (400, 400)


def test_ports_have_the_names_and_sizes_of_the_contract():
    block = VelocityFieldController(VelocityField(), REACH)
    inputs = [block.get_input_port(i) for i in range(block.num_input_ports())]
    outputs = [block.get_output_port(i) for i in range(block.num_output_ports())]
    assert [(port.get_name(), port.size()) for port in inputs] == [("p_BT", 3)]
    assert [(port.get_name(), port.size()) for port in outputs] == [
        ("base_command", 2),
        ("field_zone", 1),
    ]


def told(block, p, context=None):
    """What `block` puts out at `p`: v, omega, zone."""
    context = context or block.CreateDefaultContext()
    block.GetInputPort("p_BT").FixValue(context, p)
    return np.concatenate(
        [
            block.GetOutputPort(name).Eval(context)
            for name in ("base_command", "field_zone")
        ]
    )


INSIDE_ZONES = [
    at(0.5, 0.1),
    at(0.6, 0.1),
    at(0.6, -2.5, 0.1),
    at(0.3, 0.4, -0.1),
    at(0.2, 2.0, 0.3),
    at(0.3, -0.5, -0.3),
    at(0.5, 1.0, -0.4),
]
"""Each well inside its zone, where the field has a derivative."""


@every_field
@pytest.mark.parametrize("p", INSIDE_ZONES)
def test_derivatives_are_those_of_finite_differences(params, p):
    block = VelocityFieldController(params, REACH)
    output = told(block.ToAutoDiffXd(), InitializeAutoDiff(p)[:, 0])
    step = 1e-6
    for i, row in enumerate(step * np.eye(3)):
        slope = (told(block, p + row) - told(block, p - row)) / (2 * step)
        for y, expected in zip(output, slope, strict=True):
            # A constant has no derivatives at all.
            derivative = y.derivatives()[i] if y.derivatives().size else 0.0
            assert derivative == pytest.approx(expected, abs=1e-8)


@every_field
def test_expressions_say_the_same_as_numbers(params):
    block = VelocityFieldController(params, REACH)
    p = MakeVectorVariable(3, "p")
    told_of = told(block.ToSymbolic(), p)
    for point in INSIDE_ZONES:
        values = [e.Evaluate(dict(zip(p, point, strict=True))) for e in told_of]
        assert values == pytest.approx(told(block, point), abs=ROUNDING)


def test_two_contexts_do_not_disturb_each_other():
    block = VelocityFieldController(VelocityField(), REACH)
    near, far = block.CreateDefaultContext(), block.CreateDefaultContext()
    before = told(block, at(0.3, 1.0), near)
    assert (told(block, at(0.6, 0.1), far) != before).all()
    assert (block.GetOutputPort("base_command").Eval(near) == before[:2]).all()


@pytest.mark.parametrize(
    ("key", "value", "valid"),
    [
        ("law", "projektiert", "must be one of printed, projected"),
        ("K_f", -0.1, "must be within [0, 1000] 1/s"),
        ("K_r", -0.1, "must be within [0, 1000] 1/s"),
        ("K_omega", -0.1, "must be within [0, 20] rad/s"),
        ("K_omega", math.nan, "must be a finite number"),
        ("Delta_f", 0.0, "must be within [0.001, 10] m"),
        ("Delta_r", 0.0, "must be within [0.001, 10] m"),
        ("b_d", 0.0, "must be within [0.001, 10] m"),
        ("phi_min", -0.1, "must be within [0, 3.14159] rad"),
        ("phi_min", 0.6, "must be below phi_max = 0.6"),
        ("phi_max", 3.2, "must be within [0, 3.14159] rad"),
        ("Delta_f", 0.7, "must be below r_f = 0.7 to leave a passive zone"),
        ("b_d", 0.6, "must be below r_f - Delta_f = 0.55 to leave a passive zone"),
        (
            "Delta_r",
            0.25,
            "must be below r_f - Delta_f - b_d = 0.25 to leave a passive zone",
        ),
    ],
)
def test_parameter_that_makes_no_field_is_refused(key, value, valid):
    params = dc.replace(VelocityField(), **{key: value})
    with pytest.raises(ParameterError) as refused:
        VelocityFieldController(params, REACH)
    error = refused.value
    assert error.key == key
    assert error.value is value
    assert error.valid == valid


@pytest.mark.parametrize("r_f", [0.0, -0.7, math.inf])
def test_arm_that_reaches_nowhere_is_refused(r_f):
    with pytest.raises(ParameterError) as refused:
        VelocityFieldController(VelocityField(), Reach(l_0=0.8, r_f=r_f))
    assert refused.value.key == "r_f"


def test_zones_of_the_default_field_leave_15_cm_between_them():
    params = VelocityField()
    check_zones(params, REACH)
    room = REACH.r_f - params.Delta_f - params.b_d - params.Delta_r
    assert room == pytest.approx(0.15)
