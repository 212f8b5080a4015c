"""A robot rolls in each engine as it is told; its faults do the same in both."""

import math

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from drake_mobman.engines import Drake, Mujoco
from drake_mobman.robot_model import RobotSetup
from drake_mobman.robots.franka_tiago import POSTURE, FrankaTiago
from drake_mobman.robots.wheels import Wheels
from drake_mobman.robots.wheels.drive import Drive
from drake_mobman.robots.wheels.floor import Bump, Floor, Patch
from drake_mobman.robots.wheels.sensors import Sensors
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate

ENGINES = {"drake": Drake(), "mujoco": Mujoco()}

PERIOD = 0.01

START = [0.0, 0.0, 0.5, *POSTURE]

TRACK = 0.4044
"""Of the TIAGo base [m]."""

MASS = 48.81
"""Of the robot [kg]."""

G = 9.81
"""[m/s^2]."""

FOLLOWS = 2e-4
"""[m/s]: by which a base may miss a steady command on a good floor."""

SLIP = 1e-3
"""Largest sideways speed that the project allows [m/s]."""

AT_REST = 1e-6
"""[m/s], [rad/s]: of a robot that stands, also in its first tenth of a second."""


class Robot:
    """A robot on wheels in an engine, its commands held for as long as told."""

    def __init__(self, engine, wheels=None, start=START, *, free_arm=False):
        wheels = wheels or Wheels()
        make = wheels.build_guided if free_arm else wheels.build
        setup = RobotSetup.of(FrankaTiago(), PERIOD, engine=engine)
        self.diagram = make(setup, start)
        self.simulator = Simulator(self.diagram)
        self.context = self.simulator.get_mutable_context()
        self.time = 0.0
        self.command("base_command_smoothed", [0.0, 0.0])
        if not free_arm:
            self.command("arm_velocity_command", np.zeros(7))

    def command(self, port, value):
        self.diagram.GetInputPort(port).FixValue(self.context, value)

    def read(self, port):
        return self.diagram.GetOutputPort(port).Eval(self.context).copy()

    def advance(self, seconds):
        """Goes on, to just before a tick; returns the base's velocity."""
        self.time += seconds
        self.simulator.AdvanceTo(self.time - 1e-4)
        return self.read("base_velocity")

    def ramp(self, v, omega, hold=0.5):
        """Drives up to a velocity in half a second, and on; returns the base's."""
        for share in np.arange(1, 51) / 50:
            self.command("base_command_smoothed", [v * share, omega * share])
            self.advance(PERIOD)
        return self.advance(hold)


@pytest.fixture(params=ENGINES.values(), ids=ENGINES.keys())
def engine(request):
    return request.param


def test_it_starts_where_it_is_told_and_at_rest(engine):
    robot = Robot(engine)
    assert robot.read("base_pose") == pytest.approx(START[:3], abs=1e-12)
    for _ in range(10):
        assert np.abs(robot.advance(PERIOD)).max() < AT_REST
        assert np.abs(robot.read("arm_velocity")).max() < AT_REST


def test_the_engines_press_the_tyres_in_alike():
    # Heights of B, that the floor's patches leave as they are.
    level = [
        Robot(e, Wheels(floor=Floor(patches=patches))).read("robot_state")
        for e in ENGINES.values()
        for patches in ([], [Patch(x_min=1.0)])
    ]
    sunk = level[0][5]
    assert -1e-4 < sunk < -1e-5
    assert level[2][5] != sunk  # Each is let down in its own engine.
    for state in level[1:]:
        assert state[5] == pytest.approx(sunk, rel=1e-2)
        assert state[:2] == pytest.approx(level[0][:2], abs=1e-6)


@pytest.mark.parametrize(
    ("v", "omega"), [(0.5, 0.0), (-0.4, 0.0), (0.0, 1.0), (0.4, 0.8)]
)
def test_base_follows_and_does_not_slide(engine, v, omega):
    robot = Robot(engine)
    forward, aside, turn = robot.ramp(v, omega)
    assert forward == pytest.approx(v, abs=FOLLOWS)
    assert turn == pytest.approx(omega, abs=2 * FOLLOWS / TRACK)
    # MuJoCo's contacts do not see their own axes turn, see `contact._BRAKING`.
    assert abs(aside) < SLIP + abs(v * omega) / 200.0
    assert robot.read("base_odometry") == pytest.approx((v, omega), abs=FOLLOWS)


def test_the_arm_moves_as_told_and_its_weight_is_carried(engine):
    robot = Robot(engine)
    rates = 0.1 * np.cos(np.pi * np.arange(7))
    robot.command("arm_velocity_command", rates)
    robot.advance(1.0)
    assert robot.read("arm_velocity") == pytest.approx(rates, abs=1e-4)
    moved = robot.read("arm_position") - POSTURE
    assert moved == pytest.approx(rates, abs=5e-4)


def test_a_free_arm_stays_where_it_is_let_go(engine):
    robot = Robot(engine, free_arm=True)
    robot.advance(1.0)
    assert robot.read("arm_position") == pytest.approx(POSTURE, abs=1e-4)


def test_the_floor_bears_the_weight_and_braking_moves_where(engine):
    robot = Robot(engine)
    robot.advance(0.1)
    x, y, up = robot.read("floor_force")
    assert up == pytest.approx(MASS * G, rel=1e-4)
    robot.ramp(0.4, 0.0)
    for k in range(20):  # At 1 m/s^2.
        robot.command("base_command_smoothed", [0.4 - PERIOD * (k + 1), 0.0])
        robot.advance(PERIOD)
    ahead, aside, up = robot.read("floor_force")
    assert up == pytest.approx(MASS * G, rel=1e-2)
    # The centre of mass is some 0.4 m high.
    assert 0.02 < ahead - x < 0.06
    assert aside == pytest.approx(y, abs=2e-3)


def test_on_a_good_floor_a_wheels_torque_is_bounded(engine):
    robot = Robot(engine)
    robot.command("base_command_smoothed", [1.0, 0.0])  # At once.
    v, _, _ = robot.advance(0.2)
    most = 2 * 6.0 / 0.0985 / MASS * 0.2
    assert 0.8 * most < v < most


def test_on_ice_the_wheels_spin_and_the_base_is_slow(engine):
    # The casters bear some of the weight, and drive nothing.
    robot = Robot(engine, Wheels(floor=Floor(friction=0.03)))
    robot.command("base_command_smoothed", [0.5, 0.0])
    v, _, _ = robot.advance(0.3)
    assert 0.3 * 0.03 * G * 0.3 < v < 0.03 * G * 0.3
    assert robot.read("base_odometry")[0] > 0.2


def test_a_patch_of_ice_is_where_it_is(engine):
    floor = Floor(patches=[Patch(x_min=-0.5, x_max=0.5, friction=0.03)])
    speeds = []
    for x in (0.0, 1.0):
        start = [x, 0.0, 0.0, *POSTURE]
        robot = Robot(engine, Wheels(floor=floor), start)
        robot.command("base_command_smoothed", [0.3, 0.0])
        speeds.append(robot.advance(0.2)[0])
    assert speeds[0] < 0.1
    assert speeds[1] == pytest.approx(0.3, abs=5e-3)


@pytest.mark.parametrize(("friction", "slides"), [(0.05, True), (0.9, False)])
def test_on_a_slope_it_slides_down_where_the_floor_is_too_smooth(
    engine, friction, slides
):
    floor = Floor(friction=friction, slope=0.1)
    start = [0.0, 0.0, 0.0, *POSTURE]
    robot = Robot(engine, Wheels(floor=floor), start)
    v, _, _ = robot.advance(0.5)
    if slides:
        assert -0.1 * G * 0.5 < v < -0.01
    else:
        # A servo gives way by its gain.
        assert v == pytest.approx(-MASS * G * 0.1 * 0.0985**2 / 2e3, abs=FOLLOWS)


@pytest.mark.parametrize(
    ("drive", "v", "omega"),
    [
        (Drive(left_radius=1.03), 0.3 * 1.015, -0.3 * 0.03 / TRACK),
        (Drive(right_radius=1.02), 0.3 * 1.01, 0.3 * 0.02 / TRACK),
        (Drive(track=1.1), 0.3, 0.0),
    ],
)
def test_wheels_that_are_not_as_believed_drive_elsewhere(engine, drive, v, omega):
    robot = Robot(engine, Wheels(drive=drive))
    forward, _, turn = robot.ramp(0.3, 0.0)
    assert (forward, turn) == pytest.approx((v, omega), abs=5e-4)
    # The encoders do not know.
    assert robot.read("base_odometry") == pytest.approx((0.3, 0.0), abs=3e-4)


def test_a_wide_track_turns_a_base_by_less(engine):
    robot = Robot(engine, Wheels(drive=Drive(track=1.1)))
    assert robot.ramp(0.0, 0.5)[2] == pytest.approx(0.5 / 1.1, abs=5e-4)


def test_delay_and_lag_come_late(engine):
    late = Robot(engine, Wheels(drive=Drive(delay=0.05)))
    late.command("base_command_smoothed", [0.02, 0.0])
    assert abs(late.advance(0.05)[0]) < 1e-5
    assert late.advance(0.03)[0] == pytest.approx(0.02, abs=1e-3)
    lagging = Robot(engine, Wheels(drive=Drive(bandwidth=5.0)))
    lagging.command("base_command_smoothed", [0.02, 0.0])
    v = lagging.advance(0.06)[0]
    expected = 0.02 * (1 - math.exp(-2 * math.pi * 5.0 * 0.056))
    assert v == pytest.approx(expected, abs=3e-4)


def test_a_cable_cover_lifts_one_wheel_and_a_step_lets_both_down(engine):
    start = [0.0, 0.0, 0.0, *POSTURE]
    bump = Floor(bumps=[Bump(x=0.15, y=0.2, width=0.2, height=0.01)])
    robot = Robot(engine, Wheels(floor=bump), start)
    leans = []
    robot.ramp(0.3, 0.0, hold=0.0)
    for _ in range(30):
        robot.advance(PERIOD)
        leans.append(robot.read("robot_state")[0])
    # Up on the left: about x, by its height over the track.
    assert max(leans) == pytest.approx(0.01 / TRACK, rel=0.5)
    down = Floor(patches=[Patch(x_min=0.25, height=-0.01)])
    robot = Robot(engine, Wheels(floor=down), start)
    robot.ramp(0.3, 0.0, hold=2.0)
    assert robot.read("robot_state")[5] == pytest.approx(-0.01, abs=1e-3)


def test_sensors_have_their_faults(engine):
    sensors = Sensors(
        encoder_resolution=1000,
        gyro_bias=0.01,
        measured_noise=0.002,
        measured_latency=0.02,
    )
    robot = Robot(engine, Wheels(sensors=sensors))
    _, _, turn = robot.ramp(0.1, 0.1)
    assert robot.read("base_gyro")[0] == pytest.approx(turn + 0.01, abs=1e-12)
    counts = robot.read("base_odometry")[0] * PERIOD / (math.pi * 0.0985 / 1000)
    assert counts == pytest.approx(round(counts), abs=1e-6)
    errors = []
    for _ in range(20):
        robot.advance(PERIOD)
        errors.append(robot.read("base_measured")[0] - 0.1)
    assert 5e-4 < np.std(errors) < 5e-3


def test_a_robot_that_tips_over_ends_the_run_in_mujoco_too():
    step = "fidelity.floor.patches=[{x_min: 0.25, height: -0.15}]"
    given = ["fidelity=wheels", "engine=mujoco", "duration=6", step]
    run = simulate(load_scenario("kwon_franka", given))
    assert "the robot tips over" in run.died
    assert all(np.isfinite(run[name]).all() for name in run.signals)
