"""The hand's rates as joint rates, by positions and by rates (Kwon, eqs. 4-9)."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_mobman.arm.closed_form_inverse import (
    ClosedFormInverse,
    rates_by_jacobian,
    rates_by_positions,
)
from drake_mobman.arm.limits import ArmStatus
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.spatial import Spatial

PERIOD = 0.01

ROUNDING = 1e-12
"""Of a joint rate by positions [rad/s]: angles' rounding, 1e-15, over the period."""

SLACK = 1.1e-9
"""How far past its limit a joint may be pushed [rad], and a creep of 1e-12 rad/s."""

ROBOTS = {"planar": Planar(), "spatial": Spatial()}
LIMITS = {name: RobotModel(robot).joint_limits for name, robot in ROBOTS.items()}
ARMS = {name: robot.arm() for name, robot in ROBOTS.items()}
HAND = {"planar": 0.0, "spatial": 0.12}

every_arm = pytest.mark.parametrize("name", ROBOTS)
both_ways = pytest.mark.parametrize("by", ["positions", "rates"])

SPEED = st.floats(-0.4, 0.4)
COMMAND = st.tuples(SPEED, SPEED, SPEED)


@pytest.fixture(scope="module")
def asked(fed):
    """A function that returns rates and status of the block at `q` for `command`."""

    def rates_and_status(block, command, q):
        context = fed(block, arm_command=command, arm_position=q)
        rates = block.GetOutputPort("arm_velocity_command").Eval(context)
        return rates, ArmStatus(int(block.GetOutputPort("arm_status").Eval(context)[0]))

    return rates_and_status


@pytest.fixture(scope="module")
def blocks():
    """The block for each arm and way, by both."""
    return {
        (name, by): ClosedFormInverse(ARMS[name], LIMITS[name], PERIOD, by)
        for name in ROBOTS
        for by in ("positions", "rates")
    }


def flat(name, command):
    """Returns the command without v_z, of which the planar arm has none."""
    return (*command[:2], 0.0 if name == "planar" else command[2])


@every_arm
@both_ways
@settings(max_examples=40)
@given(held=st.lists(COMMAND, min_size=1, max_size=3), data=st.data())
def test_held_commands_break_no_limit_of_a_joint(asked, blocks, name, by, held, data):
    limits, arm = LIMITS[name], ARMS[name]
    # From anywhere in reach, also folded or stretched.
    reach = data.draw(st.floats(0.3, 1.95), label="l")
    psi = data.draw(st.floats(-1.0, 1.0), label="psi")
    q = np.array(arm.inverse((reach, psi, 0.0)))
    for command in held:
        for _ in range(40):
            rates, _ = asked(blocks[name, by], command, q)
            assert np.isfinite(rates).all()
            assert (np.abs(rates) <= np.array(limits.velocity) * (1 + 1e-15)).all()
            q = q + PERIOD * rates
            assert (q <= np.array(limits.upper) + SLACK).all()
            assert (q >= np.array(limits.lower) - SLACK).all()


@every_arm
@given(
    command=COMMAND,
    l=st.floats(0.5, 1.8),
    psi=st.floats(-1.0, 1.0),
)
def test_by_positions_the_hand_is_after_a_period_where_it_was_told(
    name, command, l, psi
):
    arm = ARMS[name]
    command = flat(name, command)
    q = np.array(arm.inverse((l, psi, 0.0)))
    rates, status = rates_by_positions(arm, q, command, PERIOD)
    expected = np.add((l, psi, 0.0), PERIOD * np.array(command))
    found = arm.ee_cylindrical(q + PERIOD * np.array(rates))
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)
    assert status == 0


@every_arm
@given(
    command=COMMAND,
    l=st.floats(0.5, 1.8),
    psi=st.floats(-1.0, 1.0),
    period=st.sampled_from([1e-2, 1e-3, 1e-4]),
)
def test_by_positions_and_by_rates_agree_to_the_order_of_the_period(
    name, command, l, psi, period
):
    arm = ARMS[name]
    command = flat(name, command)
    q = np.array(arm.inverse((l, psi, 0.0)))
    by_positions, _ = rates_by_positions(arm, q, command, period)
    by_rates, _ = rates_by_jacobian(arm, q, command)
    # theta_2'' h / 2, with l = 2 cos(theta_2 / 2): at l of 1.8 m, 1 / sin^3 is 12
    # and so theta_2'' below 12 (0.4 sqrt 2)^2 = 4; and rounding over the period.
    np.testing.assert_allclose(
        by_positions, by_rates, rtol=0, atol=10 * period + 1e-14 / period
    )


@both_ways
@given(command=COMMAND, l=st.floats(0.5, 1.8), psi=st.floats(-1.0, 1.0))
def test_hand_keeps_its_direction_where_rates_are_bound(asked, by, command, l, psi):
    # Joints at a hundredth of their speed: rates are scaled, and the hand with them.
    arm, limits = ARMS["spatial"], LIMITS["spatial"]
    slow = type(limits)(limits.lower, limits.upper, np.array(limits.velocity) / 100)
    block = ClosedFormInverse(arm, slow, PERIOD, by)
    q = np.array(arm.inverse((l, psi, 0.0)))
    full, _ = asked(ClosedFormInverse(arm, limits, PERIOD, by), command, q)
    bound, status = asked(block, command, q)
    largest = int(np.argmax(np.abs(full) / slow.velocity))
    factor = min(1.0, slow.velocity[largest] / max(abs(full[largest]), 1e-9))
    np.testing.assert_allclose(bound, factor * full, rtol=1e-9, atol=ROUNDING)
    if abs(factor - 1) > 1e-9:
        assert status == ArmStatus.JOINT_RATE


@every_arm
@pytest.mark.parametrize("command", [(0.3, 0.2, 0.0), (-0.3, -0.2, 0.1), (0, 0, 0)])
@both_ways
def test_status_is_ok_where_nothing_binds(asked, blocks, name, by, command):
    q = ARMS[name].inverse((1.0, 0.2, 0.0))
    assert asked(blocks[name, by], flat(name, command), q)[1] == ArmStatus.OK


@every_arm
def test_status_says_out_of_reach_past_the_stretch(asked, blocks, name):
    q = ARMS[name].inverse((1.999 + HAND[name], 0.2, 0.0))
    block = blocks[name, "positions"]
    rates, status = asked(block, (0.4, 0.0, 0.0), q)
    assert ArmStatus.OUT_OF_REACH in status
    # It goes to the stretch, no further; psi keeps as it is.
    found = ARMS[name].ee_cylindrical(q + PERIOD * rates)
    assert 1.999 <= found[0] - HAND[name] <= 2.0 + ROUNDING
    assert found[1] == pytest.approx(0.2, abs=ROUNDING)
    assert ArmStatus.OUT_OF_REACH not in asked(block, (-0.4, 0.0, 0.0), q)[1]


def test_status_says_out_of_reach_inside_the_fold(asked):
    robot = Planar(upper_link=1.0, lower_link=0.6)
    block = ClosedFormInverse(robot.arm(), LIMITS["planar"], PERIOD)
    q = robot.arm().inverse((0.401, 0.2, 0.0))
    assert ArmStatus.OUT_OF_REACH in asked(block, (-0.4, 0.0, 0.0), q)[1]
    assert ArmStatus.OUT_OF_REACH not in asked(block, (0.4, 0.0, 0.0), q)[1]


@pytest.mark.parametrize("l", [0.0, 1e-3])
def test_told_through_the_shoulder_the_arm_folds_up_and_stays(asked, blocks, l):
    q = np.array(ARMS["planar"].inverse((l, 0.2, 0.0)))
    for _ in range(3):
        rates, _ = asked(blocks["planar", "positions"], (-0.3, 0.0, 0.0), q)
        q = q + PERIOD * rates
    # psi does not turn about to the other side.
    found = ARMS["planar"].ee_cylindrical(q)
    assert found == pytest.approx((0.0, 0.2, 0.0), abs=ROUNDING)


def test_status_says_out_of_reach_through_the_shoulder(asked, blocks):
    # Folded up at l = 0 and told to come in further, the arm stands still.
    q = ARMS["planar"].inverse((0.0, 0.2, 0.0))
    rates, status = asked(blocks["planar", "positions"], (-0.3, 0.0, 0.0), q)
    np.testing.assert_allclose(rates, 0.0, atol=ROUNDING)
    assert ArmStatus.OUT_OF_REACH in status


@every_arm
@pytest.mark.parametrize("distance", [1.9999, 0.02])
def test_status_says_singular_by_rates_where_they_are_damped(
    asked, blocks, name, distance
):
    # sin theta_2 is 0.01 at 1.9999 m, and 0.02 at 0.02 m: l = 2 cos(theta_2 / 2).
    q = ARMS[name].inverse((distance + HAND[name], 0.2, 0.0))
    command = (-0.1, 0.0, 0.0)
    assert ArmStatus.SINGULAR in asked(blocks[name, "rates"], command, q)[1]
    away = ARMS[name].inverse((1.0 + HAND[name], 0.2, 0.0))
    assert asked(blocks[name, "rates"], command, away)[1] == ArmStatus.OK


def test_status_says_joint_rate_near_the_stretch(asked, blocks):
    # l = 2 cos(theta_2 / 2): at 1.99 m theta_2 is -0.200 and turns by v / 0.1.
    q = ARMS["planar"].inverse((1.99, 0.0, 0.0))
    rates, status = asked(blocks["planar", "rates"], (-0.4, 0.0, 0.0), q)
    assert status == ArmStatus.JOINT_RATE
    assert np.abs(rates).max() == pytest.approx(3.0, abs=1e-12)


def test_status_says_joint_limit_at_the_waists_end(asked, blocks):
    q = ARMS["spatial"].inverse((1.0, 2.899, 0.0))
    for by in ("positions", "rates"):
        rates, status = asked(blocks["spatial", by], (0.2, 0.4, 0.0), q)
        assert status == ArmStatus.JOINT_LIMIT
        # 1 mrad of room for 4 mrad a period: the reach grows at a quarter, too. The
        # slack of 1e-9 rad is 1e-7 rad/s.
        assert rates[0] == pytest.approx(0.1, abs=2e-7)
        full, _ = asked(blocks["spatial", by], (0.2, 0.0, 0.0), q)
        np.testing.assert_allclose(rates[1:], full[1:] / 4, atol=1e-6)


@pytest.mark.parametrize("psi", [-0.85, 0.0, 0.85])
def test_by_positions_the_folded_arm_moves_out_as_commanded(asked, blocks, psi):
    """Table 2 begins at l = 0, where the Jacobian has no inverse."""
    arm, block = ARMS["planar"], blocks["planar", "positions"]
    q = np.array(arm.inverse((0.0, psi, 0.0)))
    for k in range(1, 101):
        rates, status = asked(block, (0.35, 0.2, 0.0), q)
        assert status == ArmStatus.OK
        q = q + PERIOD * rates
        l, found, _ = arm.ee_cylindrical(q)
        assert l == pytest.approx(0.0035 * k, abs=ROUNDING)
        assert found == pytest.approx(psi + 0.002 * k, abs=ROUNDING)


def test_by_positions_the_folded_arm_turns_where_it_stands(asked, blocks):
    """Table 2, scenario 3: psi turns at l = 0, and l stays."""
    arm, block = ARMS["planar"], blocks["planar", "positions"]
    q = np.array(arm.inverse((0.0, -0.85, 0.0)))
    for _ in range(100):
        rates, status = asked(block, (0.0, 0.35, 0.0), q)
        assert status == ArmStatus.OK
        q = q + PERIOD * rates
    assert arm.ee_cylindrical(q) == pytest.approx((0.0, -0.5, 0.0), abs=ROUNDING)


def test_by_rates_the_folded_arm_stays_where_it_is(asked, blocks):
    # What eq. 9 divides by is 0 there (erratum to table 2): damped, it gives 0.
    q = ARMS["planar"].inverse((0.0, 0.0, 0.0))
    rates, status = asked(blocks["planar", "rates"], (0.35, 0.0, 0.0), q)
    np.testing.assert_allclose(rates, 0.0, atol=1e-12)
    assert ArmStatus.SINGULAR in status


def test_by_rates_is_as_worked_out_by_hand(asked, blocks):
    # l = sqrt(2), the elbow at a right angle: pushed out by v the links turn by
    # v / sqrt(2) each, and omega_m turns all.
    q = [0.2 + math.pi / 4, -math.pi / 2]
    rates, _ = asked(blocks["planar", "rates"], (0.3, 0.1, 0.0), q)
    expected = [0.1 - 0.3 / math.sqrt(2), 0.6 / math.sqrt(2)]
    np.testing.assert_allclose(rates, expected, atol=ROUNDING)
    # The spatial arm there: up by v_z, its wrist pitches back.
    q = [0.2, math.pi / 4, -math.pi / 2, 0.0, math.pi / 4, 0.0]
    rates, _ = asked(blocks["spatial", "rates"], (0.0, 0.1, 0.3), q)
    up = 0.3 / math.sqrt(2)
    np.testing.assert_allclose(rates, [0.1, up, 0.0, 0.0, -up, 0.0], atol=ROUNDING)
