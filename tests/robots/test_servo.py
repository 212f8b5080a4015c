"""The robot at fidelity `servo`: servos, held commands, bounded force, mechanics."""

import dataclasses as dc
import functools
import math
import re

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import RobotSetup
from drake_mobman.robots.franka_tiago import POSTURE, FrankaTiago
from drake_mobman.robots.kinematic import Kinematic
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.servo import Servo
from drake_mobman.robots.spatial import Spatial
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate

PERIOD, STEP = 0.01, 0.002

HEADING = 0.3
"""Of the base at the start [rad]: neither x nor y is ahead."""

ROBOTS = {
    "planar": (Planar(), Planar().arm().inverse((1.2, 0.3, 0.0))),
    "spatial": (Spatial(), Spatial().arm().inverse((1.2, 0.3, -0.2))),
    "franka_tiago": (FrankaTiago(), POSTURE),
}

SLIP = 1e-3
"""Largest sideways speed that the project allows [m/s]."""

SERVO_ERROR = 2e-4
"""[m/s], [rad/s]: 200 N over 1e6 N s/m, 20 N m over 1e5 N m s, 2 N m over 1e4 N m s; of
an arm's joint five times as much. All is steady."""

STARTED = 5
"""Control periods in which the arm's servos bring it from rest to its rates, at their
limits of effort."""

JOLTED = 1e-3
"""[m/s], [rad/s]: what a servo lacks in the one step in which a base with the arm on it
is brought to the next command, 0.01 m/s and 0.02 rad/s more: 10 times as much force."""

NEWTON = 2.0
"""[N]: what a step leaves of the balance of momentum and force, some 1e-3 of the
efforts, as forces of inertia are those of the step's start."""

SOLVED = 1e-6
"""Relative: the solver's own tolerance, by which a servo may pass its limit."""

ENERGY_DRIFT = 4e-3
"""Relative, over 10 s by steps of 2 ms, of an arm with joints at up to 0.6 rad/s: the
stepping is of first order, so it is half as much at half the step."""

FIRST_ORDER = 0.1
"""What a halved drift may be off by, relative: the step's second power."""


class Bench:
    """A robot that a test commands by hand."""

    def __init__(self, name, servo=None, *, free_arm=False, robot=None):
        known, arm = ROBOTS[name]
        self.n = len(arm)
        start = [0.0, 0.0, HEADING, *arm]
        servo = servo or Servo()
        make = servo.build_guided if free_arm else servo.build
        self.diagram = make(RobotSetup.of(robot or known, PERIOD), start)
        self.simulator = Simulator(self.diagram)
        self.context = self.simulator.get_mutable_context()
        self.plant = self.diagram.GetSubsystemByName("plant")
        self.plant_context = self.plant.GetMyMutableContextFromRoot(self.context)
        self.step, self.steps = servo.step, 0
        self.command("base_command_smoothed", np.zeros(2))
        if not free_arm:
            self.command("arm_velocity_command", np.zeros(self.n))

    def command(self, port, value):
        self.diagram.GetInputPort(port).FixValue(self.context, value)

    def advance(self, steps=1):
        """Takes some of the plant's steps, to the middle between two of them."""
        self.steps += steps
        self.simulator.AdvanceTo((self.steps - 0.5) * self.step)

    def read(self, port):
        return self.diagram.GetOutputPort(port).Eval(self.context)

    def momentum(self):
        """Returns mass times the velocity of the centre of mass (3,) [N s]."""
        v = self.plant.CalcCenterOfMassTranslationalVelocityInWorld(self.plant_context)
        return self.plant.CalcTotalMass(self.plant_context) * v

    def efforts(self):
        """Returns what the servos exert in the next step (3 + n,), and their limits."""
        exerted = self.plant.get_net_actuation_output_port().Eval(self.plant_context)
        actuators = map(
            self.plant.get_joint_actuator, self.plant.GetJointActuatorIndices()
        )
        return exerted, np.array([actuator.effort_limit() for actuator in actuators])

    def kinetic_energy(self):
        return self.plant.CalcKineticEnergy(self.plant_context)


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("free_arm", [False, True])
def test_ports_are_those_of_the_contract(name, free_arm):
    bench = Bench(name, free_arm=free_arm)
    diagram, n = bench.diagram, bench.n
    given = [diagram.get_input_port(i) for i in range(diagram.num_input_ports())]
    made = [diagram.get_output_port(i) for i in range(diagram.num_output_ports())]
    rates = {} if free_arm else {"arm_velocity_command": n}
    forces = {"spatial_forces": 0}  # An abstract value has no size.
    assert {port.get_name(): port.size() for port in given} == (
        {"base_command_smoothed": 2} | rates | forces
    )
    assert {port.get_name(): port.size() for port in made} == {
        "base_pose": 3,
        "base_velocity": 3,
        "arm_position": n,
        "arm_velocity": n,
        "ee_cylindrical": 3,
        "p_BT": 3,
        "robot_state": 2 * (3 + n),
    }


@pytest.mark.parametrize("name", ROBOTS)
def test_all_signals_of_the_kinematic_robot_are_there_too(name):
    robot, arm = ROBOTS[name]
    start = [0.0, 0.0, 0.0, *arm]

    def ports(fidelity):
        diagram = fidelity.build(RobotSetup.of(robot, PERIOD), start)
        given = map(diagram.get_input_port, range(diagram.num_input_ports()))
        made = map(diagram.get_output_port, range(diagram.num_output_ports()))
        return {port.get_name(): port.size() for port in (*given, *made)}

    assert ports(Kinematic()).items() <= ports(Servo()).items()


@pytest.mark.parametrize("name", ROBOTS)
def test_it_starts_where_it_is_told_and_at_rest(name):
    robot, arm = ROBOTS[name]
    bench = Bench(name)
    np.testing.assert_array_equal(bench.read("base_pose"), [0.0, 0.0, HEADING])
    np.testing.assert_array_equal(bench.read("arm_position"), arm)
    np.testing.assert_array_equal(
        bench.read("ee_cylindrical"), robot.arm().ee_cylindrical(arm)
    )
    np.testing.assert_array_equal(bench.read("p_BT"), robot.arm().p_BT(arm))
    assert not bench.read("base_velocity").any()
    assert not bench.read("arm_velocity").any()
    state = [0.0, 0.0, HEADING, *arm, *np.zeros(3 + bench.n)]
    np.testing.assert_array_equal(bench.read("robot_state"), state)


class Asked(LeafSystem):
    """Puts out a command that changes with time, and notes when it is asked for it."""

    def __init__(self, name, size):
        super().__init__()
        self.times = []
        self.DeclareVectorOutputPort(name, size, self._calc)

    def _calc(self, context, output):
        self.times.append(context.get_time())
        output.SetFromVector(np.full(output.size(), 0.1 * context.get_time()))


@pytest.mark.parametrize("free_arm", [False, True])
def test_nothing_outside_is_asked_but_once_a_control_period(free_arm):
    _, arm = ROBOTS["franka_tiago"]
    builder = DiagramBuilder()
    make = Servo().build_guided if free_arm else Servo().build
    setup = RobotSetup.of(FrankaTiago(), PERIOD)
    robot = builder.AddSystem(make(setup, [0.0] * 3 + [*arm]))
    sources = {"base_command_smoothed": 2} | (
        {} if free_arm else {"arm_velocity_command": 7}
    )
    asked = []
    for name, size in sources.items():
        asked.append(builder.AddSystem(Asked(name, size)))
        builder.Connect(asked[-1].get_output_port(), robot.GetInputPort(name))
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.2)
    for source in asked:
        # Drake's own initialisation may ask once more at the start.
        times = sorted(set(source.times))
        np.testing.assert_allclose(times, PERIOD * np.arange(20), atol=1e-12)
        assert len(source.times) <= 21


def test_a_command_that_changes_between_two_samples_changes_nothing():
    steady, fickle = Bench("planar"), Bench("planar")
    for bench in (steady, fickle):
        bench.command("base_command_smoothed", [0.01, 0.0])
        bench.advance(2)
    fickle.command("base_command_smoothed", [0.5, 1.0])
    fickle.command("arm_velocity_command", [1.0, 1.0])
    for bench in (steady, fickle):
        bench.advance(2)
    fickle.command("base_command_smoothed", [0.01, 0.0])
    fickle.command("arm_velocity_command", [0.0, 0.0])
    for bench in (steady, fickle):
        bench.advance(10)
        assert bench.read("base_velocity")[0] == pytest.approx(0.01, abs=SERVO_ERROR)
    for port in ("base_pose", "base_velocity", "arm_position", "arm_velocity"):
        np.testing.assert_array_equal(steady.read(port), fickle.read(port))


def arm_rates(bench):
    """Returns rates that turn every joint, to and fro [rad/s]."""
    return 0.3 * np.cos(np.pi * np.arange(bench.n))


@functools.cache
def on_an_arc(name):
    """Returns a bench, and base and arm velocities by steps, from rest to an arc.

    The base gets to 0.5 m/s and 1 rad/s in half a second, by what a smoother sends it,
    and goes on for another, while the arm moves.
    """
    bench = Bench(name)
    bench.command("arm_velocity_command", arm_rates(bench))
    base, arm, sent = [], [], []
    for k in range(100):
        command = np.array([0.5, 1.0]) * min(0.02 * (k + 1), 1.0)
        bench.command("base_command_smoothed", command)
        for _ in range(5):
            bench.advance()
            base.append(bench.read("base_velocity"))
            arm.append(bench.read("arm_velocity"))
            sent.append(command)
    return bench, np.array(base), np.array(arm), np.array(sent)


@pytest.mark.parametrize("name", ROBOTS)
def test_base_rolls_along_an_arc_and_does_not_slide(name):
    _, base, _, _ = on_an_arc(name)
    assert np.abs(base[:, 1]).max() < SLIP


@pytest.mark.parametrize("name", ROBOTS)
def test_base_has_the_speed_it_is_sent_two_plant_steps_later(name):
    # At the tick the servo still has the last command: Drake updates all at once.
    _, base, _, sent = on_an_arc(name)
    late = np.abs(base[:, [0, 2]] - sent).reshape(100, 5, 2)[STARTED:]
    np.testing.assert_allclose(late[:40, 0], [[0.01, 0.02]] * 40, atol=JOLTED)
    assert late[:, 1:].max() < JOLTED
    assert late[60:].max() < SERVO_ERROR


@pytest.mark.parametrize("name", ROBOTS)
def test_arm_makes_the_rates_it_is_told_while_the_base_drives(name):
    bench, _, arm, _ = on_an_arc(name)
    error = np.abs(arm - arm_rates(bench)).reshape(100, 5, -1)[STARTED:]
    assert error.max() < 5 * JOLTED
    assert error[60:].max() < 5 * SERVO_ERROR


@pytest.mark.parametrize("name", ROBOTS)
def test_base_goes_where_a_unicycle_would(name):
    # Half a second of ramp, then half a second of an arc.
    bench, _, _, sent = on_an_arc(name)
    x, y, theta = 0.0, 0.0, HEADING
    for v, omega in sent:
        theta += STEP * omega
        x, y = x + STEP * v * math.cos(theta), y + STEP * v * math.sin(theta)
    # A plant step late throughout, and what the servos lack.
    late = STEP * 1.0 + 1.0 * SERVO_ERROR
    np.testing.assert_allclose(bench.read("base_pose"), [x, y, theta], atol=late)


@pytest.mark.parametrize("name", ROBOTS)
def test_no_servo_exerts_more_than_its_limit_after_a_jump(name):
    bench = Bench(name)
    bench.command("base_command_smoothed", [0.5, 1.0])
    bench.command("arm_velocity_command", arm_rates(bench))
    ever = np.zeros(3 + bench.n)
    for _ in range(100):
        bench.advance()
        exerted, limits = bench.efforts()
        ever = np.maximum(ever, np.abs(exerted))
    assert (ever <= limits * (1 + SOLVED)).all()
    assert ever[:2] == pytest.approx(limits[:2], rel=SOLVED)  # And they do bind.
    base = bench.read("base_velocity")
    np.testing.assert_allclose(base, [0.5, 0.0, 1.0], rtol=0, atol=SERVO_ERROR)


@pytest.mark.parametrize("name", ROBOTS)
def test_momentum_changes_by_what_the_base_servos_exert_and_no_faster(name):
    bench = Bench(name)
    bench.command("base_command_smoothed", [0.5, 1.0])
    bench.command("arm_velocity_command", arm_rates(bench))
    for _ in range(100):
        before = bench.momentum()
        exerted, limits = bench.efforts()
        bench.advance()
        force = (bench.momentum() - before) / STEP
        np.testing.assert_allclose(force[:2], exerted[:2], rtol=0, atol=NEWTON)
        assert (np.abs(force[:2]) <= limits[:2] + NEWTON).all()


def test_a_jump_straight_ahead_takes_as_long_as_force_and_mass_say():
    robot = Planar()
    start = [0.0, 0.0, 0.0, *robot.arm().inverse((1.999, 0.0, 0.0))]
    diagram = Servo().build(RobotSetup.of(robot, PERIOD), start)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    diagram.GetInputPort("base_command_smoothed").FixValue(context, [1.0, 0.0])
    diagram.GetInputPort("arm_velocity_command").FixValue(context, [0.0, 0.0])
    plant = diagram.GetSubsystemByName("plant")
    mass = plant.CalcTotalMass(plant.GetMyContextFromRoot(context))
    forward = []
    for k in range(1, 51):
        simulator.AdvanceTo((k - 0.5) * STEP)
        forward.append(diagram.GetOutputPort("base_velocity").Eval(context)[0])
    gained = np.diff(forward)
    fastest = 1000.0 / mass * STEP
    assert gained.max() == pytest.approx(fastest, rel=1e-3)  # The arm is straight.
    assert forward[-1] == pytest.approx(1.0, abs=SERVO_ERROR)
    reached = np.argmax(np.array(forward) > 1.0 - SERVO_ERROR)
    # A step for the first sample, and the last one is not a whole one.
    assert abs(reached - (1 + 1.0 / fastest)) <= 1


@pytest.mark.parametrize("name", ROBOTS)
def test_a_let_go_arm_hangs_still(name):
    bench = Bench(name, free_arm=True)
    bench.advance(1000)
    # Exactly: gravity is off, and rest is an equilibrium to the last bit.
    np.testing.assert_array_equal(bench.read("arm_position"), ROBOTS[name][1])
    assert not bench.read("arm_velocity").any()
    np.testing.assert_array_equal(bench.read("base_pose"), [0.0, 0.0, HEADING])


def test_a_free_arm_that_moves_is_brought_to_rest_by_its_joints_damping():
    bench = Bench("franka_tiago", free_arm=True)
    bench.plant.SetVelocities(bench.plant_context, np.r_[np.zeros(3), SPIN])
    energies = [bench.kinetic_energy()]
    for _ in range(100):
        bench.advance(25)
        energies.append(bench.kinetic_energy())
    assert (np.diff(energies) < 0).all()
    assert energies[-1] < 0.02 * energies[0]


def test_a_free_arm_with_springs_goes_home_and_the_base_stays():
    bench = Bench("franka_tiago", Servo(joint_stiffness=1.0), free_arm=True)
    away = np.array(POSTURE) + 0.5
    bench.plant.SetPositions(bench.plant_context, np.r_[0.0, 0.0, HEADING, away])
    bench.advance(10_000)
    # The whole arm about its first joint is the slowest: by 1 / e in some 4 s.
    np.testing.assert_allclose(bench.read("arm_position"), POSTURE, rtol=0, atol=0.02)
    assert np.abs(bench.read("base_pose") - [0.0, 0.0, HEADING]).max() < SERVO_ERROR


SPIN = np.array([0.27, -0.46, -0.92, -0.97, 0.63, 0.83, 0.21]) / 2
"""Joint rates at the start [rad/s], any."""


@dc.dataclass
class WithoutStops(FrankaTiago):
    """The same arm, but its joints turn as far as they like: a stop takes energy."""

    def urdf(self):
        urdf = super().urdf()
        urdf, lower = re.subn(r'\blower="-[\d.]+"', 'lower="-1e3"', urdf)
        urdf, upper = re.subn(r'\bupper="-?[\d.]+"', 'upper="1e3"', urdf)
        assert lower == upper == 7
        return urdf


@functools.cache
def energy_drift(step):
    """Returns the largest change of a free, undamped arm's energy in 10 s, relative."""
    servo = Servo(step=step, joint_damping=0.0)
    bench = Bench("franka_tiago", servo, free_arm=True, robot=WithoutStops())
    bench.plant.SetVelocities(bench.plant_context, np.r_[np.zeros(3), SPIN])
    start = bench.kinetic_energy()
    gone = []
    for _ in range(100):
        bench.advance(round(0.1 / step))
        gone.append(abs(bench.kinetic_energy() / start - 1))
        assert np.abs(bench.read("base_velocity")).max() < SLIP  # The base is held.
    moved = np.abs(bench.read("arm_position") - POSTURE)
    assert moved.max() > 1.0  # The arm did not stay where its inertia is the same.
    return max(gone)


def test_a_free_undamped_arm_on_a_held_base_keeps_its_energy():
    assert energy_drift(0.002) < ENERGY_DRIFT


def test_energy_is_kept_better_by_as_much_as_the_step_is_shorter():
    coarse, middle, fine = map(energy_drift, (0.002, 0.001, 0.0005))
    assert middle == pytest.approx(coarse / 2, rel=FIRST_ORDER)
    assert fine == pytest.approx(middle / 2, rel=FIRST_ORDER)


@pytest.mark.parametrize(
    ("servo", "says"),
    [
        ({"step": 0.003}, "step: 0.003 is not valid; must divide the control period"),
        (
            {"step": 0.02},
            "step: 0.02 is not valid; must divide the control period of 0",
        ),
        ({"step": 0.0}, "step: 0.0 is not valid; must be within [1e-05, 0.1] s"),
        ({"step": math.nan}, "step: nan is not valid; must be a finite number"),
        (
            {"base_gain": -1.0},
            "base_gain: -1.0 is not valid; must be within [1, 1e+08] N s/m",
        ),
        (
            {"yaw_gain": 0.0},
            "yaw_gain: 0.0 is not valid; must be within [1, 1e+08] N m s",
        ),
        ({"arm_gain": math.inf}, "arm_gain: inf is not valid; must be a finite number"),
        (
            {"joint_stiffness": -1.0},
            "joint_stiffness: -1.0 is not valid; must be within [0, 1",
        ),
        (
            {"joint_damping": -1.0},
            "joint_damping: -1.0 is not valid; must be within [0, 1",
        ),
    ],
)
def test_servo_that_is_none_is_refused(servo, says):
    with pytest.raises(ParameterError) as refusal:
        Bench("planar", Servo(**servo))
    assert says in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("step", [0.01, 0.005, 0.002, 0.001, 0.0001])
def test_every_step_that_divides_the_period_is_taken(step):
    Servo(step=step).check_period(PERIOD)


@pytest.mark.parametrize("name", ROBOTS)
def test_same_commands_give_the_same_bits(name):
    first, again = Bench(name), Bench(name)
    for bench in (first, again):
        bench.command("base_command_smoothed", [0.5, 1.0])
        bench.command("arm_velocity_command", arm_rates(bench))
        bench.advance(100)
    for port in ("base_pose", "base_velocity", "arm_position", "arm_velocity"):
        assert first.read(port).tobytes() == again.read(port).tobytes(), port


def test_two_contexts_of_one_robot_do_not_disturb_each_other():
    bench = Bench("planar")
    other = bench.diagram.CreateDefaultContext()
    before = bench.diagram.GetOutputPort("base_pose").Eval(other)
    bench.command("base_command_smoothed", [0.5, 1.0])
    bench.advance(50)
    after = bench.diagram.GetOutputPort("base_pose").Eval(other)
    np.testing.assert_array_equal(before, after)


def test_a_run_of_kwon_ends_with_masses_where_it_ends_without():
    kinematic, servo = (
        simulate(load_scenario("kwon_1", [f"fidelity={fidelity}"])).log
        for fidelity in ("kinematic", "servo")
    )
    gap = servo["ee_cylindrical"][-1] - kinematic["ee_cylindrical"][-1]
    assert abs(gap[0]) < 1e-3
    # The base starts after its command by two steps of the plant, at 0.35 m/s at most.
    assert np.abs(servo["base_pose"][-1] - kinematic["base_pose"][-1]).max() < 5e-3
    assert np.abs(servo["base_velocity"][:, 1]).max() < SLIP
