"""The robot at fidelity `wheels`: it rolls as it is told, held by its tyres alone."""

import math

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant

from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import RobotModel, RobotSetup
from drake_mobman.robots.franka_tiago import POSTURE, FrankaTiago
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.servo import Servo
from drake_mobman.robots.wheels import Wheels

PERIOD = 0.01

START = [0.4, -0.3, 0.5, *POSTURE]
"""Neither x nor y is ahead."""

RADIUS, TRACK = 0.0985, 0.4044
"""Of the TIAGo base's wheels, as its maker publishes them [m]."""

FOLLOWS = 1e-4
"""[m/s]: by which base and wheels may miss a steady command on a good floor."""

SLIP = 1e-3
"""Largest sideways speed that the project allows [m/s]."""

AT_REST = 1e-6
"""[m/s], [rad/s]: of a robot that stands, also in its first tenth of a second."""


@pytest.fixture(scope="module")
def on_an_arc(bench):
    """A robot on an arc, its arm moving, and how it slid meanwhile [m/s]."""
    robot = bench()
    robot.command("arm_velocity_command", 0.1 * np.cos(np.pi * np.arange(7)))
    slip = []
    for k in range(100):
        share = min((k + 1) / 50, 1.0)
        robot.command("base_command_smoothed", [0.4 * share, 0.8 * share])
        robot.advance()
        slip.append(robot.read("base_velocity")[1])
    return robot, np.array(slip)


@pytest.mark.parametrize("free_arm", [False, True])
def test_its_ports_are_those_of_a_servo_robot_and_more(free_arm):
    start = [0.0] * 3 + [*POSTURE]
    setup = RobotSetup.of(FrankaTiago(), PERIOD)

    def ports(fidelity):
        make = fidelity.build_guided if free_arm else fidelity.build
        diagram = make(setup, start)
        given = map(diagram.get_input_port, range(diagram.num_input_ports()))
        made = map(diagram.get_output_port, range(diagram.num_output_ports()))
        sizes = {port.get_name(): port.size() for port in (*given, *made)}
        del sizes["robot_state"]  # That of each one's plant.
        return sizes

    measured = {"base_odometry": 2, "base_gyro": 1, "base_measured": 3}
    truth = {"tool_position": 3, "tool_velocity": 3, "floor_force": 3}
    assert ports(Wheels()) == ports(Servo()) | measured | truth


def test_it_starts_where_it_is_told_and_at_rest(bench):
    robot = bench()
    np.testing.assert_allclose(robot.read("base_pose"), START[:3], atol=1e-12)
    np.testing.assert_allclose(robot.read("arm_position"), POSTURE, atol=1e-12)
    for _ in range(10):
        robot.advance()
        assert np.abs(robot.read("base_velocity")).max() < AT_REST
        assert np.abs(robot.read("arm_velocity")).max() < AT_REST
        assert np.abs(robot.read("tool_velocity")).max() < AT_REST


def test_its_whole_weight_is_on_the_floor(bench):
    robot = bench()
    robot.advance(5)
    port = robot.plant.get_contact_results_output_port()
    found = port.Eval(robot.plant_context)
    forces = [
        found.point_pair_contact_info(i) for i in range(found.num_point_pair_contacts())
    ]
    up = sum(abs(info.contact_force()[2]) for info in forces)
    mass = robot.plant.CalcTotalMass(robot.plant_context)
    assert up == pytest.approx(9.81 * mass, rel=1e-4)
    assert len(forces) >= 3


def test_base_follows_and_does_not_slide_while_the_arm_moves(on_an_arc):
    robot, slip = on_an_arc
    assert np.abs(slip).max() < SLIP
    v, _, omega = robot.read("base_velocity")
    assert v == pytest.approx(0.4, abs=FOLLOWS)
    assert omega == pytest.approx(0.8, abs=2 * FOLLOWS / TRACK)


@pytest.mark.parametrize(("v", "omega"), [(0.5, 0.0), (-0.4, 0.0), (0.0, 1.0)])
def test_base_follows_ahead_back_and_in_place(bench, v, omega):
    robot = bench()
    robot.ramp(v, omega)
    forward, aside, turn = robot.read("base_velocity")
    assert forward == pytest.approx(v, abs=FOLLOWS)
    assert turn == pytest.approx(omega, abs=2 * FOLLOWS / TRACK)
    assert abs(aside) < SLIP


def test_odometry_is_that_of_wheels_that_turn(on_an_arc):
    robot, _ = on_an_arc
    left, right = (
        robot.plant.GetJointByName(f"{side}_wheel").get_angular_rate(
            robot.plant_context
        )
        for side in ("left", "right")
    )
    expected = RADIUS * (left + right) / 2, RADIUS * (right - left) / TRACK
    np.testing.assert_allclose(robot.read("base_odometry"), expected, rtol=1e-9)
    assert robot.read("base_odometry") == pytest.approx((0.4, 0.8), abs=FOLLOWS)


def test_without_faults_gyroscope_and_tracker_measure_the_truth(on_an_arc):
    robot, _ = on_an_arc
    truth = robot.read("base_velocity")
    np.testing.assert_array_equal(robot.read("base_measured"), truth)
    np.testing.assert_array_equal(robot.read("base_gyro"), truth[2:])


def test_end_effector_is_where_a_robot_on_rails_would_have_it(on_an_arc):
    # On a good floor the base hardly leans.
    robot, _ = on_an_arc
    model = RobotModel(FrankaTiago())
    v, aside, omega = robot.read("base_velocity")
    x, y, theta = robot.read("base_pose")
    c, s = math.cos(theta), math.sin(theta)
    rates = [c * v - s * aside, s * v + c * aside, omega]
    model.set_state(
        [x, y, theta, *robot.read("arm_position")],
        [*rates, *robot.read("arm_velocity")],
    )
    np.testing.assert_allclose(
        robot.read("tool_position"), model.p_W("tool"), atol=1e-3
    )
    np.testing.assert_allclose(
        robot.read("tool_velocity"), model.v_W("tool"), atol=1e-3
    )


def test_a_free_arm_stays_where_it_is_let_go(bench):
    robot = bench(free_arm=True)
    robot.advance(100)
    np.testing.assert_allclose(robot.read("arm_position"), POSTURE, atol=1e-4)


def test_bodies_have_the_indices_that_forces_on_them_name():
    kinematic, rolling = RobotModel(FrankaTiago()).plant, MultibodyPlant(0.002)
    FrankaTiago().add_rolling_to(rolling)
    names = [
        [plant.get_body(i).name() for i in plant.GetBodyIndices(instance)]
        for plant in (kinematic, rolling)
        for instance in [plant.GetModelInstanceByName("franka_tiago")]
    ]
    assert names[0] == names[1]


def test_a_robot_without_wheels_is_refused_by_name():
    setup = RobotSetup.of(Planar(), PERIOD)
    with pytest.raises(ParameterError, match="!Planar has no wheels"):
        Wheels().build(setup, [0.0] * 3 + [0.5, -1.0])


def test_same_commands_give_the_same_bits(bench):
    first, again = bench(), bench()
    for robot in (first, again):
        robot.ramp(0.4, 0.5, 0.1, 0.1)
    for port in ("base_pose", "base_velocity", "tool_velocity", "base_odometry"):
        assert first.read(port).tobytes() == again.read(port).tobytes(), port
