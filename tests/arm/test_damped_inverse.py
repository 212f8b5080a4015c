"""The hand's rates as joint rates by the Jacobian, within limits that can be kept."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from pydrake.autodiffutils import AutoDiffXd, InitializeAutoDiff
from pydrake.symbolic import Variable

from drake_mobman.arm.damped_inverse import DampedInverse, rates_within_limits
from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.limits import (
    ArmStatus,
    JointLimits,
    bounded_rates,
    braking_rate,
    filled_rates,
)
from drake_mobman.arm.pseudo_inverse import Damping
from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.franka_tiago import POSTURE, FrankaTiago

PERIOD = 0.01

SLACK = 1e-9
"""How far past its limit rounding may push a joint [rad], as `limits` has it."""

CREEP = 1e-15
"""What a joint without room may still do [rad/s], as `limits` has it."""

ROUNDING = 1e-12
"""Relative; sums of a hundred terms."""

SAME = 1e-9
"""[rad/s], [m/s]: what the inverse of a Jacobian is off by, as its own test has it."""

ARM = FrankaTiago().arm()
LIMITS = RobotModel(FrankaTiago()).joint_limits
BLOCK = DampedInverse(ARM, LIMITS, PERIOD)

SPEED = st.floats(-0.5, 0.5)
COMMAND = st.tuples(SPEED, SPEED, SPEED)
HELD = st.lists(COMMAND, min_size=1, max_size=4)

SWUNG = np.add(POSTURE, [-0.3, 0.1, 0.4, 0.1, -0.3, 0.1, 0.2])
"""Off the posture, so that there is something to do in the null space."""


@pytest.fixture(scope="module")
def asked(fed):
    """A function that returns rates and status of a block."""

    def rates_and_status(command, q, block=BLOCK):
        context = fed(block, arm_command=command, arm_position=q)
        rates = block.GetOutputPort("arm_velocity_command").Eval(context)
        return rates, ArmStatus(int(block.GetOutputPort("arm_status").Eval(context)[0]))

    return rates_and_status


def with_limits(lower=LIMITS.lower, upper=LIMITS.upper, velocity=LIMITS.velocity):
    return JointLimits(lower, upper, velocity, LIMITS.acceleration)


# The block.


def test_ports_are_those_of_the_closed_form_inverse():
    inputs = [BLOCK.get_input_port(i) for i in range(BLOCK.num_input_ports())]
    found = [BLOCK.get_output_port(i) for i in range(BLOCK.num_output_ports())]
    assert [(p.get_name(), p.size()) for p in inputs] == [
        ("arm_command", 3),
        ("arm_position", 7),
    ]
    assert [(p.get_name(), p.size()) for p in found] == [
        ("arm_velocity_command", 7),
        ("arm_status", 1),
    ]
    assert all(BLOCK.HasDirectFeedthrough(i, o) for i in (0, 1) for o in (0, 1))


@given(command=COMMAND)
def test_where_nothing_binds_the_rates_are_the_arms(asked, command):
    rates, status = asked(command, SWUNG)
    np.testing.assert_allclose(rates, ARM.rates(SWUNG, command), atol=1e-15)
    assert status == ArmStatus.OK


def test_two_contexts_do_not_disturb_each_other(fed):
    """They share the arm, and with it the context that it asks its model in."""
    port = BLOCK.GetOutputPort("arm_velocity_command")
    inputs = [((0.1, 0.2, 0.3), SWUNG), ((-0.2, 0.1, 0.0), np.array(POSTURE))]
    contexts = [fed(BLOCK, arm_command=c, arm_position=q) for c, q in inputs]
    for context, (command, q) in [*zip(contexts, inputs, strict=True)] * 2:
        BLOCK.GetInputPort("arm_position").FixValue(context, q)
        np.testing.assert_array_equal(port.Eval(context), ARM.rates(q, command))


def test_outputs_follow_their_inputs(fed):
    context = fed(BLOCK, arm_command=(0.1, 0.0, 0.0), arm_position=POSTURE)
    port = BLOCK.GetOutputPort("arm_velocity_command")
    before = port.Eval(context)
    BLOCK.GetInputPort("arm_command").FixValue(context, np.array([0.2, 0.0, 0.0]))
    np.testing.assert_allclose(port.Eval(context), 2 * before, atol=1e-14)


@pytest.mark.parametrize("command", [(0.1, -0.2, 0.1), (0.5, 3.0, 0.5)])
def test_its_derivatives_are_those_of_differences(asked, fed, command):
    block = BLOCK.ToAutoDiffXd()
    x = np.append(command, SWUNG)
    ad = InitializeAutoDiff(x).ravel()
    context = fed(block, arm_command=ad[:3], arm_position=ad[3:])
    found = block.GetOutputPort("arm_velocity_command").Eval(context)
    status = block.GetOutputPort("arm_status").Eval(context)[0].value()
    value, flags = asked(command, SWUNG)
    np.testing.assert_allclose([y.value() for y in found], value, rtol=0, atol=SAME)
    assert status == flags == (ArmStatus.OK if command[1] < 1 else ArmStatus.JOINT_RATE)
    h = 1e-6
    for i, e in enumerate(np.eye(10)):
        ends = [asked((x + d * e)[:3], (x + d * e)[3:])[0] for d in (h, -h)]
        slope = (ends[0] - ends[1]) / (2 * h)
        ours = [y.derivatives()[i] for y in found]
        # h^2 times a third derivative; and rounding over h.
        np.testing.assert_allclose(ours, slope, rtol=0, atol=1e-6)


def test_a_period_that_is_none_is_refused():
    with pytest.raises(ParameterError, match=r"^period: "):
        DampedInverse(ARM, LIMITS, 0.0)


# Limits of the arm.


@given(held=HELD, l=st.floats(0.3, 0.78), z=st.floats(-0.7, 0.4))
def test_held_commands_break_no_limit_and_leave_room_to_brake(held, l, z):
    q = np.array(ARM.inverse((l, 0.0, z)))
    lower, upper = np.array(LIMITS.lower), np.array(LIMITS.upper)
    for command in held:
        for _ in range(40):
            rates, _ = rates_within_limits(ARM, q, command, LIMITS, PERIOD)
            rates = np.array(rates)
            assert (np.abs(rates) <= np.array(LIMITS.velocity) * (1 + ROUNDING)).all()
            q = q + PERIOD * rates
            assert (q <= upper + 1.1 * SLACK).all()
            assert (q >= lower - 1.1 * SLACK).all()
            # From here, each joint brakes as hard as it can.
            p, v = q.copy(), rates.copy()
            while v.any():
                less = np.maximum(np.abs(v) - PERIOD * LIMITS.acceleration, 0.0)
                v = np.sign(v) * less
                p = p + PERIOD * v
            assert (p <= upper + 1.1 * SLACK).all()
            assert (p >= lower - 1.1 * SLACK).all()


@given(command=COMMAND)
def test_the_hand_keeps_its_direction_where_rates_are_bound(asked, command):
    assume(np.linalg.norm(command) > 0.1)
    q = np.array(POSTURE)
    block = DampedInverse(ARM, with_limits(velocity=[0.05] * 7), PERIOD)
    full, _, _ = ARM.ee_and_posture_rates(q, command)
    rates, status = asked(command, q, block)
    assert status == ArmStatus.JOINT_RATE
    assert np.abs(rates).max() == pytest.approx(0.05)
    factor = 0.05 / np.abs(full).max()
    np.testing.assert_allclose(rates, factor * np.array(full), rtol=0, atol=SAME)


@given(command=COMMAND)
def test_a_limit_that_stops_the_posture_does_not_stop_the_hand(asked, command):
    hand, posture, _ = (np.array(x) for x in ARM.ee_and_posture_rates(SWUNG, command))
    # The joint that the posture moves most, and the hand not at all or away, is at
    # its limit.
    blocked = np.where(hand * posture <= 0, np.abs(posture), 0.0)
    joint = int(np.argmax(blocked))
    assume(blocked[joint] > 0.01)
    lower, upper = list(LIMITS.lower), list(LIMITS.upper)
    (upper if posture[joint] > 0 else lower)[joint] = SWUNG[joint]
    block = DampedInverse(ARM, with_limits(lower, upper), PERIOD)
    rates, status = asked(command, SWUNG, block)
    assert status == ArmStatus.OK
    # Whatever is left of the posture's part lies in the null space: the hand goes on.
    h = 1e-6
    after, before = (np.array(ARM.ee_cylindrical(SWUNG + d * rates)) for d in (h, -h))
    moved = (after - before) / (2 * h)
    np.testing.assert_allclose(moved, command, rtol=0, atol=1e-8)
    share = (rates - hand) @ posture / (posture @ posture)
    assert -SAME <= share <= 1 + SAME
    np.testing.assert_allclose(rates - hand, share * posture, rtol=0, atol=SAME)


def test_the_hand_turns_on_where_the_posture_is_blocked_outright(asked):
    # The hand is turned by the first joint alone; the third has no room to swing.
    q = SWUNG
    blind = Damping(level_gain=0.0)
    arm = JacobianArm(RobotModel(FrankaTiago()).plant, POSTURE, blind)
    _, posture, _ = arm.ee_and_posture_rates(q, (0.0, 0.3, 0.0))
    assert abs(posture[2]) > 0.05
    lower, upper = list(LIMITS.lower), list(LIMITS.upper)
    (upper if posture[2] > 0 else lower)[2] = q[2]
    block = DampedInverse(arm, with_limits(lower, upper), PERIOD)
    rates, status = asked((0.0, 0.3, 0.0), q, block)
    # A slack of 1e-9 rad is 1e-7 rad/s over a period, and this the others follow.
    np.testing.assert_allclose(rates, [0.3, 0, 0, 0, 0, 0, 0], rtol=0, atol=1e-6)
    assert status == ArmStatus.OK


def test_a_limit_in_the_hands_way_stops_the_hand_and_says_so(asked):
    # Drawn in, the arm folds its elbow: the limit is put there.
    q, command = np.array(POSTURE), (-0.3, 0.0, 0.0)
    hand, _, _ = ARM.ee_and_posture_rates(q, command)
    assert hand[3] < -0.1
    lower = list(LIMITS.lower)
    lower[3] = q[3]
    block = DampedInverse(ARM, with_limits(lower=lower), PERIOD)
    rates, status = asked(command, q, block)
    np.testing.assert_allclose(rates, 0.0, atol=2e-6)
    assert status == ArmStatus.JOINT_LIMIT


def test_status_says_singular_where_rates_are_damped(asked):
    stretched = np.array([0.0, 0.4, 0.0, -0.467, 0.0, 2.0, 0.7])
    _, status = asked((-0.1, 0.0, 0.0), stretched)
    assert ArmStatus.SINGULAR in status


def test_the_hand_comes_to_rest_at_the_end_of_its_reach_and_comes_back():
    q = np.array(POSTURE)
    speeds = []
    for command in [(0.3, 0.0, 0.0)] * 300 + [(-0.3, 0.0, 0.0)] * 200:
        rates, _ = rates_within_limits(ARM, q, command, LIMITS, PERIOD)
        before = ARM.ee_cylindrical(q)
        q = q + PERIOD * np.array(rates)
        speeds.append((ARM.ee_cylindrical(q)[0] - before[0]) / PERIOD)
    assert max(speeds) < 0.31
    assert abs(speeds[299]) < 0.02
    assert speeds[-1] == pytest.approx(-0.3, abs=0.01)


# Filling what is left.


RATES = st.lists(st.floats(-4.0, 4.0), min_size=3, max_size=3)
NARROW = JointLimits([-1.0] * 3, [1.0] * 3, [2.0, 1.0, 3.0], [5.0, math.inf, 20.0])


@given(rates=RATES, extra=RATES, q=st.tuples(*[st.floats(-1.0, 1.0)] * 3))
def test_filled_rates_are_within_the_limits_and_as_full_as_they_let(rates, extra, q):
    rates, _ = bounded_rates(rates, q, NARROW, PERIOD)
    found = np.array(filled_rates(rates, extra, q, NARROW, PERIOD))
    _, status = bounded_rates(found * (1 - 1e-9), q, NARROW, PERIOD)
    largest = int(np.argmax(np.abs(extra)))
    share = (found - rates)[largest] / extra[largest] if extra[largest] else 1.0
    assert -SAME <= share <= 1 + SAME
    np.testing.assert_allclose(found - rates, share * np.array(extra), atol=1e-8)
    if status:
        # Only where there was no room to begin with: creep.
        assert share * np.abs(extra).max() <= 1e-6
    if share < 1 - 1e-6 and np.abs(extra).max() > 1e-3:
        more = np.array(rates) + (share + 1e-5) * np.array(extra)
        assert bounded_rates(more, q, NARROW, PERIOD)[1] != 0


# Braking.


ACCELERATION = st.floats(0.1, 50.0)
STEP = st.sampled_from([0.001, 0.01, 0.1])
ROOM = st.floats(1e-8, 3.0)


def braked(room, v, acceleration, period):
    """Returns what is left after `v` for a period, then less by a h in each."""
    while v > 0:
        room -= v * period
        v -= acceleration * period
    return room


@given(room=ROOM, acceleration=ACCELERATION, period=STEP)
def test_a_joint_that_brakes_as_it_can_does_not_cross_its_limit(
    room, acceleration, period
):
    v = braking_rate(room, acceleration, period)
    assert braked(room, v, acceleration, period) >= -ROUNDING * room


@given(room=ROOM, acceleration=ACCELERATION, period=STEP)
def test_no_more_is_given_away_than_an_eighth_of_a_step(room, acceleration, period):
    """Against the exact bound, linear between whole multiples of a h."""
    s = room / (acceleration * period**2)
    n = math.floor((math.sqrt(8 * s + 1) - 1) / 2)
    exact = (s / (n + 1) + n / 2) * acceleration * period
    v = braking_rate(room, acceleration, period)
    tolerance = 1e-9 * exact
    assert exact - acceleration * period / 8 - tolerance <= v <= exact + tolerance


@given(room=ROOM, acceleration=ACCELERATION, period=STEP)
def test_followed_to_the_limit_it_asks_for_no_more_than_the_joint_can(
    room, acceleration, period
):
    v = braking_rate(room, acceleration, period)
    for _ in range(1000):
        room -= v * period
        slower = braking_rate(room, acceleration, period)
        assert v - slower <= acceleration * period * (1 + 1e-9)
        assert room >= -1000 * CREEP * period - ROUNDING
        v = slower


@given(
    held=st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=5),
    acceleration=ACCELERATION,
    period=STEP,
)
def test_whatever_is_held_a_joint_can_always_be_brought_to_rest(
    held, acceleration, period
):
    limits = JointLimits([-0.5], [0.5], [4.0], [acceleration])
    q = 0.0
    for asked_rate in held:
        for _ in range(20):
            (rate,), _ = bounded_rates([asked_rate], [q], limits, period)
            room = 0.5 + SLACK - abs(q) if rate * q > 0 else 0.5 + abs(q)
            assert braked(room, abs(rate), acceleration, period) >= -2 * SLACK
            q += period * rate
            assert abs(q) <= 0.5 + 1.1 * SLACK


def test_braking_is_as_worked_out_by_hand():
    # a h = 0.1 rad/s: from 0.3 it takes 3, 2 and 1 mrad, in all 6; and 5.9 more to
    # have 2 a r = (0.35 rad/s)^2 exactly.
    assert braking_rate(0.35**2 / 20, 10.0, 0.01) == pytest.approx(0.3)
    # The last step: all of it, at half a step's room and below.
    assert braking_rate(0.0005, 10.0, 0.01) == pytest.approx(0.05)
    assert braking_rate(0.0002, 10.0, 0.01) == pytest.approx(0.02)


@pytest.mark.parametrize("room", [0.5, 1e-6, 0.0, -0.1])
def test_without_a_limit_on_acceleration_a_joint_uses_its_room_in_a_period(room):
    expected = max(room / PERIOD, CREEP)
    assert braking_rate(room, math.inf, PERIOD) == expected


@pytest.mark.parametrize("acceleration", [10.0, math.inf])
def test_a_joint_past_its_limit_may_go_no_further(acceleration):
    assert braking_rate(-0.1, acceleration, PERIOD) == CREEP


@pytest.mark.parametrize("room", [0.4, 0.0003, 0.0, -0.1])
@pytest.mark.parametrize("acceleration", [10.0, math.inf])
def test_braking_is_the_same_for_all_scalars(room, acceleration):
    expected = braking_rate(room, acceleration, PERIOD)
    r = Variable("r")
    formula = braking_rate(r + 0.0, acceleration, PERIOD)
    assert formula.Evaluate({r: room}) == pytest.approx(expected, rel=1e-14)
    ad = braking_rate(AutoDiffXd(room, np.ones(1)), acceleration, PERIOD)
    if isinstance(ad, AutoDiffXd):
        assert ad.value() == pytest.approx(expected, rel=1e-14)
        h = 1e-8
        ends = (braking_rate(room + d, acceleration, PERIOD) for d in (h, -h))
        slope = -np.subtract(*reversed(list(ends))) / (2 * h)
        if room > 0:
            assert ad.derivatives()[0] == pytest.approx(slope, rel=1e-6)
    else:
        assert ad == expected == CREEP


def test_limits_of_acceleration_come_from_the_model():
    np.testing.assert_array_equal(LIMITS.acceleration, [15, 7.5, 10, 12.5, 15, 20, 20])


def test_a_model_without_them_has_none():
    assert JointLimits([0.0] * 2, [1.0] * 2, [1.0] * 2).acceleration == [math.inf] * 2
