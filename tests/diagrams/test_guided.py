"""The Franka arm on the TIAGo base, pulled by hand or commanded, with its masses."""

import dataclasses as dc
import functools
import math

import numpy as np
import pytest
from drake_mobman.diagrams import make_diagram
from pydrake.systems.analysis import Simulator

from drake_mobman.analysis.metrics import metrics
from drake_mobman.base.velocity_field import Zone, signed_distances
from drake_mobman.guidance import guiding_hand
from drake_mobman.parameters import Range
from drake_mobman.robot_model import BASE_JOINTS
from drake_mobman.scenario import ScenarioError, load_scenario
from drake_mobman.simulation.simulate import simulate

EVERY = (
    "petric_guided",
    "petric_hold",
    "petric_behind",
    "petric_behind_near",
    "petric_teleop",
    "kwon_franka",
)

HAND_ERROR, HAND_FORCE, SLIP = 0.02, 15.0, 1e-3
"""What issue and contract allow [m], [N], [m/s]."""

MANIPULABILITY = 0.05
"""The floor on the tour; at the start it is 0.08, and 0 where a direction is lost."""

JOINT_MARGIN = 0.3
"""How near to a limit a joint comes on the tour, at most [rad]."""

AT_REST = 2e-3
"""[m/s], [rad/s]. Where the yaw rate begins, at phi_min, it does so with a slope of 0:
the base never quite stops turning, but slows down as 1 / time^2."""

EDGE = 1e-4
"""How far T may still be from the passive zone [m]; it nears it as exp(-4 s^-1 t)."""

EDGE_OF_ROTATION = 0.02
"""The same of its bearing [rad], which nears phi_min as 1 / time."""

ROUNDING = 1e-12
"""[m/s], [rad/s], [rad]: of positions of up to 5 m, by a loop that damps it."""


@functools.cache
def run_of(name, *overrides):
    return simulate(load_scenario(name, overrides))


@functools.cache
def metrics_of(name, *overrides):
    return metrics(run_of(name, *overrides))


def at(log, signal, time):
    return log[signal][round(time / 0.01)]


def zones(log):
    return log["field_zone"][:, 0].astype(int)


# --- The tour -----------------------------------------------------------------------


def test_hand_is_never_refused_on_the_tour():
    numbers = metrics_of("petric_guided")
    assert run_of("petric_guided").died == ""
    assert numbers["hand_error_max"] < HAND_ERROR
    assert numbers["hand_force_max"] < HAND_FORCE


def test_hand_goes_nearly_as_fast_as_the_robot_is_made_for():
    run = run_of("petric_guided")
    assert 0.30 < guiding_hand.peak_speed(run.scenario.hand) <= 0.35
    tool = np.linalg.norm(run.log["tool_velocity"], axis=1)
    assert 0.30 < tool.max() <= 0.35


def test_base_does_not_slide_on_the_tour():
    assert metrics_of("petric_guided")["lateral_slip_max"] < SLIP


def test_arm_loses_no_direction_and_no_joint_is_at_its_limit_on_the_tour():
    numbers = metrics_of("petric_guided")
    assert numbers["manipulability_min"] > MANIPULABILITY
    assert numbers["joint_margin_min"] > JOINT_MARGIN


def test_base_is_sent_no_more_than_the_smoothers_limits_on_the_tour():
    run = run_of("petric_guided")
    p, sent = run.scenario.smoother, run.log["base_command_smoothed"]
    speeds = p.max_speed, p.max_yaw_rate
    accelerations = p.max_acceleration, p.max_yaw_acceleration
    assert (np.abs(sent).max(0) <= speeds).all()
    steps = np.abs(np.diff(sent, axis=0, prepend=np.zeros((1, 2)))).max(0)
    assert (steps <= np.array(accelerations) * run.scenario.period + ROUNDING).all()


def test_tour_visits_all_zones():
    seen = zones(run_of("petric_guided").log)
    assert (seen == Zone.PASSIVE).any()
    for zone in (Zone.FORWARD, Zone.RETREAT, Zone.ROTATION):
        assert (seen & zone).any(), zone
        assert not (seen & zone).all(), zone


def test_base_comes_along_ahead_turns_and_gives_way():
    run = run_of("petric_guided")
    log, field = run.log, run.scenario.field
    # Pulled ahead by 3 m, it has come as far, but for what the passive zone is wide.
    x, y, theta = at(log, "base_pose", 15.5)
    assert x == pytest.approx(3.0, abs=0.2)
    assert (y, theta) == pytest.approx((0.0, 0.0), abs=0.01)
    # Pulled through a right angle, it faces +y but for what it leaves to the arm.
    assert abs(at(log, "base_pose", 29.0)[2] - math.pi / 2) < field.phi_max
    assert (log["base_command_smoothed"][:2900, 0] >= 0).all()
    # Pushed back, it backs off; the hand has come 1 m nearer to where it stood.
    before, after = (at(log, "base_pose", time)[:2] for time in (29.0, 36.0))
    assert np.linalg.norm(after - before) > 0.3
    assert log["base_command_smoothed"][2900:3600, 0].min() < -0.1


def test_hand_goes_above_the_shoulder_and_below_it():
    run = run_of("petric_guided")
    shoulder = run.scenario.robot.reach().l_0
    height = run.log["p_BT"][:, 2] - shoulder
    assert height.max() > 0.3
    assert height.min() < -0.15


def test_base_comes_to_rest_at_the_end_of_the_tour():
    log = run_of("petric_guided").log
    assert np.abs(log["base_command_smoothed"][-1]).max() < AT_REST


# --- What the base knows ------------------------------------------------------------


def source_of(diagram, system, port):
    """Returns system and port that an input port of a system in a diagram gets."""
    index = system.GetInputPort(port).get_index()
    source, number = diagram.connection_map()[(system, index)]
    return source, source.get_output_port(number).get_name()


def test_all_that_the_field_takes_is_told_from_the_joint_angles_alone():
    diagram = make_diagram(load_scenario("petric_guided"), logged=False)
    field, smoother, robot = map(
        diagram.GetSubsystemByName, ("field", "smoother", "robot")
    )
    assert source_of(diagram, robot, "base_command_smoothed") == (
        smoother,
        "base_command_smoothed",
    )
    assert smoother.num_input_ports() == 1
    assert source_of(diagram, smoother, "base_command") == (field, "base_command")
    assert field.num_input_ports() == 2
    assert source_of(diagram, field, "p_BT") == (robot, "p_BT")
    assert source_of(diagram, field, "arm_position") == (robot, "arm_position")
    # Inside the robot, p_BT is the sensor's, which gets the arm's positions alone.
    sensor, port = robot.get_output_port_locator(
        robot.GetOutputPort("p_BT").get_index()
    )
    assert (sensor.get_name(), sensor.get_output_port(port).get_name()) == (
        "sensor",
        "p_BT",
    )
    assert sensor.num_input_ports() == 1
    parts, taken = source_of(robot, sensor, "arm_position")
    told, port = robot.get_output_port_locator(
        robot.GetOutputPort("arm_position").get_index()
    )
    assert (told, told.get_output_port(port).get_name()) == (parts, taken)
    plant, port = source_of(robot, parts, "u0")
    assert (plant.get_name(), port) == ("plant", "state")
    # The state's part that it gets is the arm's positions and no more: the block's
    # other input is not even asked for.
    context = parts.CreateDefaultContext()
    n = plant.num_positions()
    state = np.arange(float(n + plant.num_velocities()))
    parts.GetInputPort("u0").FixValue(context, state)
    found = parts.GetOutputPort(taken).Eval(context)
    np.testing.assert_array_equal(found, state[BASE_JOINTS:n])


def placed(scenario, x, y, theta):
    """Returns a scenario with the robot's start and the hand's path moved in W."""
    c, s = math.cos(theta), math.sin(theta)
    path = [
        dc.replace(p, x=x + c * p.x - s * p.y, y=y + s * p.x + c * p.y)
        for p in scenario.hand.path
    ]
    return dc.replace(
        scenario,
        start=dc.replace(scenario.start, x=x, y=y, theta=theta),
        hand=dc.replace(scenario.hand, path=path),
    )


ONE_LEG = "hand.path=[{x: 0.58, z: 0.523}, {time: 5, x: 1.2, y: 0.5, z: 0.6}]"


@pytest.mark.parametrize(
    ("overrides", "pose"),
    [
        # A path through many points is the same one only in axes that are parallel to
        # W's: a coordinate's cubics are not linear in its points.
        (("duration=22",), (1.3, -2.1, 0.0)),
        (("duration=22",), (1.3, -2.1, math.pi / 2)),
        (("duration=6", ONE_LEG), (0.4, 5.0, 2.0)),
        (("duration=6", ONE_LEG), (-3.0, 0.1, -2.7)),
    ],
)
def test_where_the_robot_stands_in_the_world_makes_no_difference(overrides, pose):
    scenario = load_scenario("petric_guided", overrides)
    here, there = (simulate(placed(scenario, *at)).log for at in ((0, 0, 0), pose))
    assert np.abs(here["base_command_smoothed"]).max() > 0.1
    for signal in ("base_command_smoothed", "arm_position"):
        np.testing.assert_allclose(here[signal], there[signal], rtol=0, atol=ROUNDING)


def test_hand_that_is_commanded_leaves_the_base_to_the_joint_angles_too():
    diagram = make_diagram(load_scenario("petric_teleop"), logged=False)
    decomposer = diagram.GetSubsystemByName("decomposer")
    robot = diagram.GetSubsystemByName("robot")
    assert source_of(diagram, decomposer, "arm_position") == (robot, "arm_position")
    context = decomposer.CreateDefaultContext()
    q = run_of("petric_teleop").log["arm_position"][600]
    decomposer.GetInputPort("arm_position").FixValue(context, q)
    # None of the other inputs is connected here, and none is asked for.
    base_command = decomposer.GetOutputPort("base_command").Eval(context)
    np.testing.assert_array_equal(
        base_command, run_of("petric_teleop").log["base_command"][600]
    )


# --- Hands that hold still, or let go -----------------------------------------------


def assert_rests_with_the_hand_in_the_passive_zone(run):
    log, field = run.log, run.scenario.field
    forward, _, yaw = np.abs(log["base_velocity"][-100:]).max(0)
    assert forward < AT_REST
    assert yaw < AT_REST
    p_BT = log["p_BT"][-1]
    d_f, d_r = signed_distances(p_BT, run.scenario.robot.reach(), field.b_d)
    assert d_f > field.Delta_f - EDGE
    assert d_r > field.Delta_r - EDGE
    phi = math.atan2(p_BT[1], p_BT[0])
    assert abs(phi) < field.phi_min + EDGE_OF_ROTATION


def test_released_in_mid_tour_the_base_comes_to_rest():
    run = run_of("petric_hold")
    (release,) = run.scenario.hand.releases
    assert np.abs(at(run.log, "base_command_smoothed", release.start)).max() > 0.2
    assert not run.log["hand_force"][round(release.start / 0.01) + 1 :].any()
    assert_rests_with_the_hand_in_the_passive_zone(run)


@pytest.mark.parametrize("name", ["petric_behind", "petric_behind_near"])
def test_hand_still_behind_the_base_gets_a_base_that_turns_and_rests(name):
    run = run_of(name)
    assert abs(run.log["base_pose"][-1, 2]) > 2.0  # It was behind at 2.7 rad.
    assert_rests_with_the_hand_in_the_passive_zone(run)
    numbers = metrics_of(name)
    assert numbers["hand_error_max"] < HAND_ERROR
    assert numbers["hand_force_max"] < HAND_FORCE
    assert numbers["lateral_slip_max"] < SLIP
    assert numbers["joint_margin_min"] > 0


@pytest.mark.parametrize("name", ["petric_behind", "petric_behind_near"])
def test_with_the_projected_law_the_base_goes_no_farther_than_it_must(name):
    def farthest(run):
        return np.linalg.norm(run.log["base_pose"][:, :2], axis=1).max()

    projected, printed = run_of(name), run_of(name, "field.law=printed")
    assert farthest(projected) < 0.15
    assert farthest(printed) > 0.5


def test_as_printed_the_law_tears_the_arm_from_a_hand_far_behind():
    run = run_of("petric_behind", "field.law=printed")
    numbers = metrics_of("petric_behind", "field.law=printed")
    assert run.died == ""
    # "Forward" is away from it: base at full speed, arm stretched, hand overpowered.
    assert numbers["base_speed_max"] == run.scenario.smoother.max_speed
    assert numbers["hand_force_max"] == pytest.approx(run.scenario.hand.max_force)
    assert numbers["hand_error_max"] > 0.3
    assert numbers["manipulability_min"] < 1e-3


# --- A hand that is commanded -------------------------------------------------------


def test_commanded_hand_moves_as_told_and_the_base_follows_by_the_field():
    run, numbers = run_of("petric_teleop"), metrics_of("petric_teleop")
    assert numbers["ee_error_rms"] < 0.01
    assert numbers["lateral_slip_max"] < SLIP
    assert numbers["manipulability_min"] > MANIPULABILITY
    assert numbers["joint_margin_min"] > JOINT_MARGIN
    assert not run.log["arm_status"].any()
    assert not run.log["guard_status"].any()
    # It has gone farther than the arm is long, and turned farther than phi_max.
    pose = run.log["base_pose"]
    assert np.linalg.norm(pose[:, :2], axis=1).max() > 2.0
    assert np.ptp(pose[:, 2]) > 1.0
    assert (run.log["base_command_smoothed"][:, 0] < -0.1).any()
    assert np.abs(run.log["base_command_smoothed"][-1]).max() < AT_REST


def test_base_rests_while_the_hand_is_in_the_passive_zone():
    log = run_of("petric_teleop", "duration=4").log
    moves = np.abs(log["base_command_smoothed"]).max(1) > 0
    first = int(np.argmax(moves))
    assert at(log, "ee_command", 1.5)[0] > 0.1  # The hand moves from 1 s on,
    assert log["time"][first] > 1.4  # the base does not, until the zone's end,
    assert moves[first:].all()  # and then comes along.


@pytest.mark.parametrize("decomposer", ["exact", "blending"])
def test_kwons_stick_works_on_this_robot(decomposer):
    chosen = {"exact": [], "blending": ["decomposer=!Blending {alpha: 60.0}"]}
    run = simulate(load_scenario("kwon_franka", chosen[decomposer]))
    numbers = metrics(run)
    assert run.died == ""
    assert not run.log["arm_status"].any()
    assert not run.log["guard_status"].any()
    assert numbers["lateral_slip_max"] < SLIP
    assert numbers["joint_margin_min"] > JOINT_MARGIN
    assert numbers["manipulability_min"] > MANIPULABILITY
    assert np.linalg.norm(run.log["base_pose"][-1, :2]) > 1.0
    # Both limits of the reach were come to; by blending passed, by as little as a law
    # does that never quite stops the arm.
    l, psi = run.log["ee_cylindrical"][:, 0], run.log["ee_cylindrical"][:, 1]
    limits = run.scenario.workspace
    near = 0.002
    assert l.min() < limits.l_min + near
    assert l.max() > limits.l_max - near
    if decomposer == "blending":
        assert min(numbers["authority_flips"].values()) > 0
        assert psi.min() < limits.psi_min
        assert psi.max() > limits.psi_max
        assert l.min() < limits.l_min
        assert l.max() > limits.l_max
        assert max(numbers["workspace_excess_max"].values()) < 0.1
    else:
        assert max(numbers["workspace_excess_max"].values()) == 0.0
        assert numbers["ee_error_max"] < 0.005


# --- All of them --------------------------------------------------------------------


@pytest.mark.parametrize("name", EVERY)
def test_same_scenario_gives_the_same_log_bit_for_bit(name):
    first, again = (simulate(load_scenario(name, ["duration=4"])).log for _ in "12")
    assert first.keys() == again.keys()
    for signal, values in first.items():
        assert values.tobytes() == again[signal].tobytes(), signal


@pytest.mark.parametrize("name", ["petric_guided", "petric_teleop"])
def test_two_contexts_of_one_diagram_do_not_disturb_each_other(name):
    diagram = make_diagram(load_scenario(name), logged=False)
    first, second = Simulator(diagram), Simulator(diagram)
    first.AdvanceTo(3.0)
    signals = ("base_pose", "arm_position", "base_command_smoothed")

    def values(simulator):
        context = simulator.get_context()
        return [diagram.GetOutputPort(name).Eval(context).copy() for name in signals]

    at_3 = values(first)
    second.AdvanceTo(3.0)
    for one, other, before in zip(values(first), values(second), at_3, strict=True):
        np.testing.assert_array_equal(one, other)
        np.testing.assert_array_equal(one, before)


# --- Runs that die ------------------------------------------------------------------


def assert_ended_with_its_log(run, time):
    assert run.died.startswith(f"died at t = {time}")
    assert "\n" not in run.died
    assert len(run.log["time"]) == pytest.approx(time / 0.01, abs=2)
    assert all(np.isfinite(values).all() for values in run.log.values())
    assert metrics(run)["died"] == run.died


def test_hand_force_gone_non_finite_ends_the_run_and_keeps_the_log(monkeypatch):
    true_force = guiding_hand.hand_force
    ticks = []

    def failing(p_WE, v_WE, *others):
        ticks.append(p_WE)
        factor = math.nan if len(ticks) > 151 else 1.0
        return true_force(p_WE, [factor * v for v in v_WE], *others)

    monkeypatch.setattr(guiding_hand, "hand_force", failing)
    overrides = ["duration=4", "compiled=false"]
    run = simulate(load_scenario("petric_guided", overrides))
    assert_ended_with_its_log(run, 1.5)
    assert "the hand's force is not finite: p_WE = [" in run.died


@pytest.mark.parametrize(("compiled", "time"), [("false", 0.002), ("true", 0)])
def test_hand_too_stiff_for_the_plant_ends_the_run_and_keeps_the_log(
    compiled, time, monkeypatch
):
    # No scenario may have it; but a plant that does not keep up may look like that.
    for key in ("STIFFNESS", "FORCE"):
        monkeypatch.setattr(guiding_hand, key, Range(0.0, math.inf))
    overrides = ["hand.stiffness=1e300", "hand.max_force=1e300", "duration=4"]
    overrides.append(f"compiled={compiled}")
    run = simulate(load_scenario("petric_guided", overrides))
    assert_ended_with_its_log(run, time)


# --- Bad input ----------------------------------------------------------------------

START = "{x: 0.58, z: 0.523}"


@pytest.mark.parametrize(
    ("override", "says"),
    [
        ("field.K_f=-1", "field.K_f: -1.0 is not valid; must be within [0, 1000] 1/s"),
        ("field.K_r=-1", "field.K_r: -1.0 is not valid; must be within [0, 1000] 1/s"),
        (
            "field.K_omega=-1",
            "field.K_omega: -1.0 is not valid; must be within [0, 20] rad/s",
        ),
        ("field.K_omega=.nan", "field.K_omega: nan is not valid; must be a finite num"),
        ("hand.damping=130", "hand.damping: 130.0 is not valid; must be at most 120"),
        ("drag.damping=50", "drag.damping: 50.0 is not valid; must be at most 45"),
        (
            "hand.path=[{x: 0.58, z: 0.523}, {time: 1, x: 3.58, z: 0.523}]",
            "hand.path: '4.5 m/s' is not valid; out of reach; the base follows at most",
        ),
        ("field.law=foo", "field.law: 'foo' is not valid; must be one of printed, pro"),
        # Both thresholds by themselves leave nothing of the arm's 0.72 m.
        ("field.Delta_f=0.5", "field.b_d: 0.3 is not valid; must be below r_f - Delta"),
        ("field.Delta_f=0.9", "field.Delta_f: 0.9 is not valid; must be below r_f = 0"),
        ("field.b_d=0.9", "field.b_d: 0.9 is not valid; must be below r_f - Delta_f ="),
        ("field.b_d=0", "field.b_d: 0.0 is not valid; must be within [0.001, 10] m"),
        ("field.Delta_r=0.3", "field.Delta_r: 0.3 is not valid; must be below r_f - D"),
        ("field.phi_min=0.7", "field.phi_min: 0.7 is not valid; must be below phi_max"),
        (
            "field.phi_min=-0.1",
            "field.phi_min: -0.1 is not valid; must be within [0, 3.14159] rad",
        ),
        (
            "field.phi_max=4",
            "field.phi_max: 4.0 is not valid; must be within [0, 3.14159] rad",
        ),
        ("field.phi=1", "field.phi: 1 is not valid; valid keys are: law, K_f, K_r"),
        (
            "hand.stiffness=-1",
            "hand.stiffness: -1.0 is not valid; must be within [0.1, 1e+06] N/m",
        ),
        (
            "hand.damping=0",
            "hand.damping: 0.0 is not valid; must be within [0.001, 1e+06] N s/m",
        ),
        ("hand.max_force=.inf", "hand.max_force: inf is not valid; must be a finite"),
        ("hand.path=[]", "hand.path: [] is not valid; must hold one waypoint or more"),
        (
            f"hand.path=[{START}, {{time: 9, x: 0.58, z: 2.5}}]",
            "hand.path[1].z: 2.5 is not valid; out of reach; must be within [-0.19",
        ),
        (
            f"hand.path=[{START}, {{time: 9, x: 0.58, z: -0.5}}]",
            "hand.path[1].z: -0.5 is not valid; out of reach; must be within [-0.19",
        ),
        (
            "hand.path=[{x: 0.7, z: 0.523}]",
            "hand.path[0]: {'x': 0.7, 'y': 0.0, 'z': 0.523} is not valid; must be "
            "where the tool starts, x = 0.5800, y = 0.0000, z = 0.5230, within 0.05 m",
        ),
        ("start.psi=1", "hand.path[0]: {'x': 0.58, 'y': 0.0, 'z': 0.523} is not valid"),
        (
            f"hand.path=[{START}, {{time: 2, x: 0.6}}, {{time: 2, x: 0.7}}]",
            "hand.path[2].time: 2.0 is not valid; must be above path[1].time = 2.0",
        ),
        (
            "hand.path=[{time: 3, x: 0.58, z: 0.523}, {time: 2, x: 0.6, z: 0.523}]",
            "hand.path[1].time: 2.0 is not valid; must be above path[0].time = 3.0",
        ),
        (
            "hand.releases=[{start: 2, end: 1}]",
            "hand.releases[0].end: 1.0 is not valid; must be above start = 2.0",
        ),
        (
            "hand.releases=[{start: 1, end: 3}, {start: 2, end: 4}]",
            "hand.releases[1].start: 2.0 is not valid; must be releases[0].end = 3.0",
        ),
        ("fidelity=kinematic", "fidelity: '!Kinematic' is not valid; must be !Servo"),
        (
            "fidelity=!Servo {step: 0.003}",
            "fidelity.step: 0.003 is not valid; must divide the control period of 0",
        ),
        # The default's own field, with no tag: the default is !Servo.
        (
            "fidelity.step=0.003",
            "fidelity.step: 0.003 is not valid; must divide the control period of 0",
        ),
        (
            "robot.mount=-1",
            "robot.mount: -1.0 is not valid; must be within [0.01, 2] m",
        ),
        ("period=0.003", "fidelity.step: 0.002 is not valid; must divide the control"),
        ("start.l=0.9", "out of reach; the nearest is l = 0.85"),
        ("decomposer=blending", "decomposer: 'blending' is not valid; valid keys are:"),
        ("smoother.max_acceleration=0", "smoother.max_acceleration: 0.0 is not valid"),
    ],
)
def test_bad_value_is_refused_in_one_line(override, says):
    with pytest.raises(ScenarioError) as refusal:
        load_scenario("petric_guided", [override])
    message = str(refusal.value)
    assert message.startswith(("petric_guided.yaml with --set: ", "--set: "))
    assert says in message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("override", "says"),
    [
        (
            "decomposer.K_f=-1",
            "decomposer.K_f: -1.0 is not valid; must be within [0, 1000] 1/s",
        ),
        ("decomposer.law=foo", "decomposer.law: 'foo' is not valid; must be one of pr"),
        ("decomposer.Delta_f=0.5", "decomposer.b_d: 0.3 is not valid; must be below r"),
        ("decomposer.phi_min=0.7", "decomposer.phi_min: 0.7 is not valid; must be bel"),
        ("fidelity.step=0.003", "fidelity.step: 0.003 is not valid; must divide the c"),
    ],
)
def test_bad_field_of_a_commanded_hand_is_refused_in_one_line(override, says):
    with pytest.raises(ScenarioError) as refusal:
        load_scenario("petric_teleop", [override])
    assert says in str(refusal.value)
    assert "\n" not in str(refusal.value)
