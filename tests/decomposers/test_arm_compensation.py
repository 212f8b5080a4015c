"""The exact rest: what the base does to the hand, and what the arm adds to it."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.autodiffutils import InitializeAutoDiff
from pydrake.symbolic import Evaluate, MakeVectorVariable

from drake_mobman.decomposers.arm_compensation import (
    arm_compensation,
    base_induced_rates,
)
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.spatial import Spatial

ROUNDING = 1e-12
"""[m/s]: some twenty operations on numbers of up to 4, and a chain of transforms."""

SLOPE = 1e-7
"""Of central differences: a step of 1e-6, squared, times a third derivative of up to
1e2; and rounding over the step."""

LEAST_REACH = 0.01
"""The law's own: a shorter reach counts as this much [m]."""

ROBOTS = {
    "planar": Planar(shoulder_ahead=0.25),
    "planar, shoulder behind": Planar(upper_link=0.8, shoulder_ahead=-0.1),
    "planar, shoulder above": Planar(),
    "planar, shoulder to the left": Planar(shoulder_ahead=0.1, shoulder_aside=0.3),
    "spatial": Spatial(),
    "spatial, shoulder to the right": Spatial(shoulder_aside=-0.25),
}
MODELS = {name: RobotModel(robot) for name, robot in ROBOTS.items()}

SPEED = st.floats(-1.0, 1.0)
ANGLE = st.floats(-math.pi, math.pi)
PLACE = st.floats(-0.5, 0.5)
"""Of a shoulder, ahead of the base's centre or left of it [m]."""

P_BS = 0.15, -0.1, 0.7


def random_hand(name, rng):
    """Returns a place of the hand, neither stretched nor folded, at any bearing."""
    psi = rng.uniform(-2.5, 2.5)
    if name.startswith("spatial"):
        return rng.uniform(0.6, 1.7), psi, rng.uniform(-0.5, 0.5)
    return rng.uniform(0.4, 1.6), psi, 0.0


def hand_velocity(name, hand, base, arm_rates, theta):
    """Returns the hand's velocity along and across the reach, and up [m/s].

    As `MultibodyPlant` has it, with the base at heading `theta` [rad], slipping.
    """
    robot, model = ROBOTS[name], MODELS[name]
    q = robot.arm().inverse(hand)
    v, v_y, omega = base
    c, s = math.cos(theta), math.sin(theta)
    rolls = [v * c - v_y * s, v * s + v_y * c, omega]
    model.set_state(np.array([0.7, -0.4, theta, *q]), np.array([*rolls, *arm_rates(q)]))
    x, y, z = model.v_W("tool")
    c, s = math.cos(theta + hand[1]), math.sin(theta + hand[1])
    return x * c + y * s, y * c - x * s, z


@pytest.mark.parametrize("name", ROBOTS)
def test_base_carries_a_hand_that_keeps_still_on_it_as_drake_has_it(name):
    rng = np.random.default_rng(0)
    arm = ROBOTS[name].arm()
    for _ in range(100):
        hand, base = random_hand(name, rng), rng.uniform(-1, 1, 3)
        v, v_y, omega = base
        along, turning = base_induced_rates(hand, v, omega, arm.p_BS, v_y)
        still = np.zeros(arm.num_joints)
        found = hand_velocity(
            name, hand, base, lambda _, v=still: v, rng.uniform(-3, 3)
        )
        expected = (along, hand[0] * turning, 0.0)
        np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


@settings(max_examples=50)
@given(
    d=PLACE,
    e=PLACE,
    l=st.floats(0.4, 1.6),
    psi=ANGLE,
    v_b=SPEED,
    v_y=SPEED,
    omega_b=SPEED,
)
def test_base_carries_the_hand_of_any_shoulder_as_drake_has_it(
    d, e, l, psi, v_b, v_y, omega_b
):
    robot = Planar(shoulder_ahead=d, shoulder_aside=e)
    model, q = RobotModel(robot), robot.arm().inverse((l, psi, 0.0))
    model.set_state([0.0, 0.0, 0.0, *q], [v_b, v_y, omega_b, 0.0, 0.0])
    v, c, s = model.v_W("tool"), math.cos(psi), math.sin(psi)
    along, turning = base_induced_rates((l, psi, 0.0), v_b, omega_b, (d, e, 0.5), v_y)
    expected = c * v[0] + s * v[1], c * v[1] - s * v[0]
    np.testing.assert_allclose((along, l * turning), expected, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("name", ROBOTS)
def test_with_the_rest_the_hand_moves_just_as_commanded(name):
    rng = np.random.default_rng(1)
    arm = ROBOTS[name].arm()
    for _ in range(100):
        hand = random_hand(name, rng)
        command, base = rng.uniform(-0.4, 0.4, 3), rng.uniform(-1, 1, 3)
        if not name.startswith("spatial"):
            command[2] = 0.0  # A planar arm does not go up.
        rest = arm_compensation(command, hand, base, arm.p_BS)
        found = hand_velocity(
            name,
            hand,
            base,
            lambda q, rest=rest: arm.rates(q, rest),
            rng.uniform(-3, 3),
        )
        v_c, omega_c, v_z = command
        expected = (v_c, hand[0] * omega_c, v_z)
        np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize(
    ("psi", "e", "along", "turning"),
    [
        (0.0, 0.0, 0.3, 0.4 * (0.8 + 0.2) / 0.8),
        (math.pi / 2, 0.0, 0.4 * 0.2, (0.4 * 0.8 - 0.3) / 0.8),
        (math.pi, 0.0, -0.3, 0.4 * (0.8 - 0.2) / 0.8),
        (-math.pi / 2, 0.0, -0.4 * 0.2, (0.4 * 0.8 + 0.3) / 0.8),
        # Turning left takes a shoulder on the left backwards, at 0.4 times 0.5 m/s.
        (0.0, 0.5, 0.3 - 0.2, 0.4 * (0.8 + 0.2) / 0.8),
        (math.pi / 2, 0.5, 0.4 * 0.2, (0.4 * 0.8 - (0.3 - 0.2)) / 0.8),
        (0.0, -0.5, 0.3 + 0.2, 0.4 * (0.8 + 0.2) / 0.8),
    ],
)
def test_base_induced_rates_are_as_worked_out_by_hand(psi, e, along, turning):
    # v_b = 0.3 m/s, omega_b = 0.4 rad/s, l = 0.8 m, d = 0.2 m.
    found = base_induced_rates((0.8, psi, 0.1), 0.3, 0.4, (0.2, e, 0.5))
    np.testing.assert_allclose(found, (along, turning), rtol=0, atol=ROUNDING)


def test_a_base_at_rest_leaves_the_whole_command_to_the_arm():
    command = (0.1, -0.2, 0.3)
    assert arm_compensation(command, (0.7, 1.1, 0.2), (0.0, 0.0, 0.0), P_BS) == command


@given(psi=ANGLE, l=st.floats(0.0, 0.1), v_b=SPEED, v_y=SPEED, omega_b=SPEED)
def test_near_the_shoulders_axis_the_rest_stays_bounded(psi, l, v_b, v_y, omega_b):
    base = v_b, v_y, omega_b
    rest = arm_compensation((0.0, 0.0, 0.0), (l, psi, 0.0), base, P_BS)
    fastest = abs(v_b) + abs(v_y) + abs(omega_b) * (l + math.hypot(*P_BS[:2]))
    assert abs(rest[0]) <= fastest + ROUNDING
    assert abs(rest[1]) <= fastest / LEAST_REACH + ROUNDING
    assert all(map(math.isfinite, rest))


@given(psi=ANGLE, v_b=SPEED, v_y=SPEED, omega_b=SPEED)
def test_rest_does_not_jump_where_its_bound_sets_in(psi, v_b, v_y, omega_b):
    step = 1e-9
    inside, outside = (
        arm_compensation(
            (0.0, 0.0, 0.0), (LEAST_REACH + d, psi, 0.0), (v_b, v_y, omega_b), P_BS
        )
        for d in (-step, step)
    )
    steepest = 3 / LEAST_REACH**2  # Of 1/l, times speeds of up to 3 m/s.
    np.testing.assert_allclose(inside, outside, rtol=0, atol=2 * step * steepest)


GIVEN = np.array([0.2, -0.3, 0.1, 0.7, 0.4, -0.2, 0.25, 0.05, 0.5])
"""A command, a place of the hand and the base's velocity, one after the other."""


def rest_of(x):
    return np.array(arm_compensation(x[:3], x[3:6], x[6:], P_BS))


def test_gradient_is_that_of_finite_differences():
    found = [
        value.derivatives() for value in rest_of(InitializeAutoDiff(GIVEN).ravel())
    ]
    h = 1e-6
    for i, one in enumerate(np.eye(len(GIVEN))):
        slope = (rest_of(GIVEN + h * one) - rest_of(GIVEN - h * one)) / (2 * h)
        np.testing.assert_allclose([d[i] for d in found], slope, rtol=0, atol=SLOPE)


@pytest.mark.parametrize("l", [0.7, 0.01])
def test_expression_has_the_values_of_floats(l):
    given = GIVEN.copy()
    given[3] = l
    x = MakeVectorVariable(len(given), "x")
    found = Evaluate(rest_of(x), dict(zip(x, given, strict=True))).ravel()
    np.testing.assert_allclose(found, rest_of(given), rtol=0, atol=ROUNDING)
