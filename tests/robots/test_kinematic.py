"""The robot at fidelity `kinematic`: it does what it is told, by Euler steps."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.systems.analysis import Simulator

from drake_mobman.robots.kinematic import KinematicRobot

PERIOD = 0.01

ROUNDING = 1e-15
"""A few operations on numbers of up to 4."""

SLIP = 1e-9
"""Largest `lateral_slip_max` that the project allows at this fidelity [m/s]."""

START = [1.0, -2.0, math.pi / 3, 0.5, -1.0]

SPEED = st.floats(-2.0, 2.0)
HELD = st.lists(
    st.tuples(SPEED, SPEED, SPEED, SPEED, st.integers(1, 20)), min_size=1, max_size=6
)
"""v_b, omega_b, two joint rates, and for how many periods they are held."""


@pytest.fixture(scope="module")
def robot():
    return KinematicRobot(START, PERIOD)


def test_an_euler_step_is_as_worked_out_by_hand(robot, fed, outputs, step):
    context = fed(
        robot, base_command_smoothed=[0.5, 0.2], arm_velocity_command=[-0.3, 0.4]
    )
    found = outputs(robot, context)
    np.testing.assert_array_equal(found["base_pose"], START[:3])
    np.testing.assert_array_equal(found["arm_position"], START[3:])
    np.testing.assert_array_equal(found["arm_velocity"], [-0.3, 0.4])
    np.testing.assert_allclose(found["base_velocity"], [0.5, 0, 0.2], atol=ROUNDING)
    step(robot, context)
    found = outputs(robot, context)
    # 5 mm along 60 degrees: 2.5 mm in x, 2.5 sqrt(3) mm in y. The heading counts as it
    # was before the step.
    pose = [1.0025, -2.0 + 0.0025 * math.sqrt(3), math.pi / 3 + 0.002]
    np.testing.assert_allclose(found["base_pose"], pose, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(found["arm_position"], [0.497, -0.996], atol=ROUNDING)


def test_simulated_it_steps_once_a_period(robot, fed):
    inputs = {"base_command_smoothed": [0.5, 0.0], "arm_velocity_command": [0.1, -0.1]}
    simulator = Simulator(robot, fed(robot, **inputs))
    for k in range(1, 9):  # Eight quarters of a period: two steps, at 0 and 0.01 s.
        simulator.AdvanceTo(k * PERIOD / 4)
    arm = robot.GetOutputPort("arm_position").Eval(simulator.get_context())
    np.testing.assert_allclose(arm, [0.502, -1.002], rtol=0, atol=ROUNDING)


def test_a_circle_closes_as_euler_has_it(robot, fed, step):
    # 100 steps that turn by 2 pi / 100 each: a regular polygon, which closes.
    turn = 2 * math.pi / 100 / PERIOD
    context = fed(
        robot, base_command_smoothed=[0.5, turn], arm_velocity_command=[0.0, 0.0]
    )
    for _ in range(100):
        step(robot, context)
    pose = robot.GetOutputPort("base_pose").Eval(context)
    np.testing.assert_allclose(pose[:2], START[:2], atol=100 * ROUNDING)
    assert pose[2] - START[2] == pytest.approx(2 * math.pi, abs=100 * ROUNDING)


@given(held=HELD, theta=st.floats(-7.0, 7.0))
def test_it_never_slides_sideways(fed, outputs, step, held, theta):
    robot = KinematicRobot([0.0, 0.0, theta, 0.0, 0.0], PERIOD)
    context = fed(
        robot, base_command_smoothed=[0.0, 0.0], arm_velocity_command=[0.0, 0.0]
    )
    for v_b, omega_b, *rates, periods in held:
        robot.GetInputPort("base_command_smoothed").FixValue(context, [v_b, omega_b])
        robot.GetInputPort("arm_velocity_command").FixValue(context, rates)
        for _ in range(periods):
            before = outputs(robot, context)
            step(robot, context)
            x, y, theta = before["base_pose"]
            moved = (outputs(robot, context)["base_pose"] - [x, y, theta]) / PERIOD
            ahead = np.array([math.cos(theta), math.sin(theta)])
            # Told from where it went, apart from what its port says of it.
            assert abs(moved[:2] @ [-ahead[1], ahead[0]]) <= SLIP
            assert moved[:2] @ ahead == pytest.approx(v_b, abs=SLIP)
            assert moved[2] == pytest.approx(omega_b, abs=SLIP)
            forward, sideways, yaw = before["base_velocity"]
            assert abs(sideways) <= ROUNDING
            assert (forward, yaw) == pytest.approx((v_b, omega_b), abs=ROUNDING)


@pytest.mark.parametrize("port", ["base_command_smoothed", "arm_velocity_command"])
@pytest.mark.parametrize("index", [0, 1])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_command_not_finite_raises_and_the_state_stays(fed, port, index, value):
    robot = KinematicRobot(START, PERIOD)
    commands = {"base_command_smoothed": [0.1, 0.2], "arm_velocity_command": [0.3, 0.4]}
    simulator = Simulator(robot, fed(robot, **commands))
    simulator.AdvanceTo(0.095)  # Ten steps, at 0 to 0.09 s.
    context = simulator.get_mutable_context()
    before = context.get_discrete_state_vector().CopyToVector()
    commands[port][index] = value
    robot.GetInputPort(port).FixValue(context, commands[port])
    with pytest.raises(RuntimeError, match="not finite"):
        simulator.AdvanceTo(0.2)
    after = context.get_discrete_state_vector().CopyToVector()
    np.testing.assert_array_equal(after, before)
    assert np.isfinite(after).all()


def test_state_starts_where_it_is_told():
    robot = KinematicRobot([1, 2, 3, 4, 5, 6, 7, 8, 9], PERIOD)
    context = robot.CreateDefaultContext()
    assert list(robot.GetOutputPort("base_pose").Eval(context)) == [1, 2, 3]
    arm = robot.GetOutputPort("arm_position").Eval(context)
    assert list(arm) == [4, 5, 6, 7, 8, 9]
