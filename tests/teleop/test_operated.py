"""An operator in the loop: what he does moves the robot, and without him it stops."""

import functools
import math

import numpy as np
import pytest
from drake_mobman.diagrams import make_diagram
from hypothesis import given
from hypothesis import strategies as st
from pydrake.systems.analysis import Simulator

from drake_mobman.analysis.metrics import metrics
from drake_mobman.analysis.motion import holding
from drake_mobman.guidance.guiding_hand import Hand
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.franka_tiago import FrankaTiago
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.log import read_log
from drake_mobman.simulation.simulate import Run
from drake_mobman.teleop.drag import NOTHING, Drag, Dragged
from drake_mobman.teleop.gate import GateStatus
from drake_mobman.teleop.guard import Guard
from drake_mobman.teleop.led_hand import (
    LedHand,
    commanded_velocity,
    drag_velocity,
    within_distance,
)
from drake_mobman.teleop.live import NOBODY, OperatorSample
from drake_mobman.teleop.stop_ramp import StopRamp, next_share

PERIOD = 0.01
REST = OperatorSample(age=0.0)

SLACK = 0.1
"""What the contract allows over age and braking [s]."""


def driven(name, said, overrides=()):
    """Returns scenario and log of samples, each with a duration [s]."""
    scenario = load_scenario(name, ["source=operator", *overrides])
    diagram = make_diagram(scenario)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    k = 0
    for sample, duration in said:
        for _ in range(round(duration / scenario.period)):
            k += 1
            port = diagram.GetInputPort("operator_input")
            port.FixValue(context, np.array(sample))
            simulator.AdvanceTo(k * scenario.period)
    return scenario, read_log(diagram, context)


def held(*command):
    return OperatorSample(*command, dead_man=1.0, age=0.0)


FOLLOWED = ("decomposer=velocityfield",)
SMOOTHED = ("smoother=smoother",)
LOOPS = [
    ("kwon_arbitrary", ("start.l=1.6",)),
    ("kwon_arbitrary", ("start.l=1.6", *SMOOTHED)),
    ("kwon_spatial", ("start.l=1.55", *SMOOTHED)),
    ("petric_teleop", ()),
    ("petric_guided", ()),
]


@functools.cache
def pushed_and_lost(name, overrides):
    """The operator pushes forward, and is not heard any more after 3.2 s."""
    push = held(0.3, 0.0, 0.0)
    silence = [(push._replace(age=k * PERIOD), PERIOD) for k in range(200)]
    said = [(REST, 0.2), (push, 3.0), *silence]
    return driven(name, said, overrides)


@pytest.mark.parametrize(("name", "overrides"), LOOPS)
def test_base_is_at_rest_in_time_after_the_last_word(name, overrides):
    scenario, log = pushed_and_lost(name, overrides)
    spoken = 3.2
    limits = scenario.smoother.limits()
    braking = limits.max_speed / limits.max_acceleration
    if limits.follows_at_once:
        braking = scenario.guard.stop_time
    late = log["time"] > spoken + scenario.gate.fresh + braking + SLACK
    before = (log["time"] > 2.5) & (log["time"] < spoken)
    assert np.abs(log["base_command_smoothed"][before, 0]).min() > 0.1
    assert late.sum() > 50
    assert not log["base_command_smoothed"][late].any()
    assert not log["ee_command"][late].any()
    assert (log["gate_status"][late] == GateStatus.STALE).all()


@pytest.mark.parametrize(("name", "overrides"), LOOPS)
def test_base_stops_without_more_acceleration_than_it_may_have(name, overrides):
    scenario, log = pushed_and_lost(name, overrides)
    limits = scenario.smoother.limits()
    most = limits.max_acceleration
    if limits.follows_at_once:
        # The gate's ramp, by which the base's share of it goes to rest as well.
        most = 2 * scenario.guard.max_v_c / scenario.guard.stop_time
    stop = log["time"] > 3.2
    change = np.abs(np.diff(log["base_command_smoothed"][stop, 0])).max()
    assert change <= most * PERIOD * (1 + 1e-9)


@pytest.mark.parametrize(("name", "overrides"), LOOPS)
def test_base_never_moves_before_it_is_armed(name, overrides):
    push = held(0.3, 0.2, 0.1)
    _, log = driven(name, [(NOBODY, 0.2), (push, 0.5)], overrides)
    assert not log["base_command_smoothed"].any()
    assert not log["ee_command"].any()
    assert (log["gate_status"] == GateStatus.NOT_ARMED).all()


# --- StopRamp ----------------------------------------------------------------------


def test_base_gets_less_and_less_while_the_gate_is_shut():
    guard = Guard(stop_time=0.04)
    share, shares = 1.0, []
    for _ in range(5):
        share = next_share(share, False, guard, PERIOD)
        shares.append(share)
    np.testing.assert_allclose(shares, [0.75, 0.5, 0.25, 0.0, 0.0], atol=1e-15)
    assert next_share(0.25, True, guard, PERIOD) == 1.0
    assert next_share(1.0, False, Guard(stop_time=0.0), PERIOD) == 0.0


def test_open_gate_lets_the_bases_command_pass_bit_for_bit(fed, outputs):
    block = StopRamp(Guard(), PERIOD)
    context = fed(block, state=[1.0], base_command=[0.1 + 0.2, -0.0], gate_status=[0])
    assert outputs(block, context)["base_command"].tobytes() == (
        np.array([0.1 + 0.2, -0.0]).tobytes()
    )


def test_shut_gate_holds_back_even_what_is_no_number(fed, outputs):
    block = StopRamp(Guard(), PERIOD)
    context = fed(block, base_command=[math.nan, math.inf], gate_status=[5])
    assert (outputs(block, context)["base_command"] == 0).all()


# --- A hand that is led --------------------------------------------------------------

POINTS = st.lists(st.floats(-2, 2), min_size=3, max_size=3)


def test_hand_goes_along_across_and_up_as_worked_out_by_hand():
    # The base looks along y, the arm to its right, along x: across it is along y.
    ee_cylindrical, theta = (0.5, -math.pi / 2, 0.3), math.pi / 2
    v_WH = commanded_velocity((0.3, 0.4, 0.1), ee_cylindrical, theta)
    np.testing.assert_allclose(v_WH, [0.3, 0.2, 0.1], atol=1e-15)


@given(hand=POINTS, tool=POINTS, most=st.floats(0.01, 1.0))
def test_leash_keeps_the_hand_near_and_its_direction(hand, tool, most):
    held_back = np.array(within_distance(hand, tool, most))
    away, before = held_back - tool, np.array(hand) - tool
    assert np.linalg.norm(away) <= most * (1 + 1e-9)
    if np.linalg.norm(before) <= most:
        assert list(held_back) == hand
    else:
        np.testing.assert_allclose(
            away, before * most / np.linalg.norm(before), atol=1e-12
        )


def test_hand_that_pulls_in_vain_does_not_run_away_from_its_tool(fed):
    hand = Hand(stiffness=600.0, max_force=60.0)
    model = RobotModel(FrankaTiago())
    block = LedHand(hand, Drag(), model, PERIOD)
    still = {"drag": NOTHING, "robot_state": np.zeros(20)}
    start = [hand.path[0].x, hand.path[0].y, hand.path[0].z]
    stuck = {"tool_position": start, "tool_velocity": [0.0, 0.0, 0.0]}
    where = {"ee_cylindrical": [0.5, 0.0, 0.0], "base_pose": [0.0, 0.0, 0.0]}
    context = fed(block, ee_command=[0.3, 0.0, 0.0], **stuck, **where, **still)
    Simulator(block, context).AdvanceTo(5.0)
    # As far as the spring alone pulls with all the force that there is.
    away = block.GetOutputPort("hand_position").Eval(context) - start
    np.testing.assert_allclose(away, [0.1, 0.0, 0.0], atol=1e-12)
    force = block.GetOutputPort("hand_force").Eval(context)
    np.testing.assert_allclose(force, [60.0, 0.0, 0.0], atol=1e-12)


@functools.cache
def led():
    """The hand is led ahead, then aside, then up; and then let go."""
    moves = [(0.2, 0.0, 0.0), (0.0, 0.3, 0.0), (0.0, 0.0, 0.05)]
    said = [(REST, 0.2), *((held(*move), 3.0) for move in moves), (REST, 2.0)]
    return driven("petric_guided", said)


def test_tool_goes_as_the_operator_leads_the_hand():
    _, log = led()
    log_at = {name: x[[20, 320, 620, 920]] for name, x in log.items()}
    ahead, aside, up = np.diff(log_at["tool_position"], axis=0)
    assert ahead[0] == pytest.approx(0.6, abs=0.03)
    assert math.hypot(*aside[:2]) > 0.3
    assert abs(aside[2]) < 0.01
    assert up[2] == pytest.approx(0.15, abs=0.01)
    gap = np.linalg.norm(log["hand_position"] - log["tool_position"], axis=1)
    assert gap.max() < 0.03


def test_base_comes_along_and_hand_holds_still_when_let_go():
    scenario, log = led()
    assert log["base_pose"][-1, 0] > 0.3
    assert np.linalg.norm(log["hand_force"], axis=1).max() <= scenario.hand.max_force
    last = log["time"] > 10.2
    assert not log["base_command_smoothed"][last].any()
    assert np.ptp(log["hand_position"][last], axis=0).max() == 0
    assert np.abs(log["tool_velocity"][last]).max() < 0.01


# --- An arm that is dragged ----------------------------------------------------------


@given(
    hand=POINTS,
    target=POINTS,
    most=st.floats(0.01, 1.0),
)
def test_hand_drags_straight_to_its_target_no_faster_than_it_may(hand, target, most):
    v = np.array(drag_velocity(hand, target, most, PERIOD))
    assert np.linalg.norm(v) <= most * (1 + 1e-9)
    away = np.subtract(target, hand)
    if np.linalg.norm(away) <= most * PERIOD:
        np.testing.assert_allclose(hand + PERIOD * v, target, atol=1e-12)
    else:
        assert np.linalg.norm(v) == pytest.approx(most)
        assert np.linalg.norm(np.cross(v, away)) < 1e-9


POINT = (0.0, 0.05, 0.05)  # On the last link, in its own frame [m].
START, LET_GO = 20, 420  # Samples.


@functools.cache
def dragged():
    """The last link is dragged 0.8 m ahead of where it is over the base, and let go."""
    model = RobotModel(FrankaTiago())
    scenario = load_scenario("petric_guided")
    q = scenario.start_position(scenario.setup())
    link = model.arm_bodies["link7"]
    p_WQ, _ = model.point_W(link, POINT, [*q, *np.zeros(10)])
    pull = Dragged(link, *POINT, *np.add(p_WQ, [0.8, 0.0, 0.0]))
    said = held(0.0, 0.0, 0.0)._replace(**pull._asdict())
    return driven("petric_guided", [(REST, 0.2), (said, 4.0), (REST, 2.0)])


def test_dragged_arm_comes_and_the_base_after_it():
    _, log = dragged()
    reach = log["ee_cylindrical"][:, 0]
    assert reach[LET_GO] > reach[START] + 0.05
    assert log["base_pose"][LET_GO, 0] > 0.1
    assert not np.abs(log["tool_velocity"][: START + 1]).max() > 1e-6


def test_drag_pulls_at_the_point_and_no_harder_than_it_may():
    scenario, log = dragged()
    force = np.linalg.norm(log["hand_force"], axis=1)
    assert 20.0 < force.max() <= scenario.drag.max_force
    # Led from where the point was, no faster than may be, as far as the spring goes.
    model = RobotModel(scenario.robot)
    still = np.zeros((len(force), 10))
    states = np.hstack([log["base_pose"], log["arm_position"], still])
    link = model.arm_bodies["link7"]
    points = np.array([model.point_W(link, POINT, x)[0] for x in states])
    led = log["hand_position"][START + 2 : LET_GO]
    assert np.linalg.norm(led[0] - points[START + 1]) < 0.005
    speed = np.linalg.norm(np.diff(led, axis=0), axis=1) / PERIOD
    gap = np.linalg.norm(led - points[START + 2 : LET_GO], axis=1)
    leash = scenario.drag.max_force / scenario.drag.stiffness
    assert speed[gap[1:] < 0.9 * leash].max() <= scenario.drag.max_speed * (1 + 1e-9)
    assert gap.max() < leash + 0.01


def test_arm_that_is_let_go_is_held_where_it_is_and_the_base_rests():
    _, log = dragged()
    assert (log["drag"][LET_GO + 1 :] == 0).all()
    assert (log["gate_status"][LET_GO + 5 :] == GateStatus.RELEASED).all()
    # The hand takes hold of the tool where that is.
    gap = np.linalg.norm(log["hand_position"] - log["tool_position"], axis=1)
    assert gap[LET_GO + 2] < 0.02
    last = slice(-50, None)
    assert np.ptp(log["hand_position"][last], axis=0).max() == 0
    assert np.abs(log["tool_velocity"][last]).max() < 0.01
    assert not log["base_command_smoothed"][last].any()


def test_error_of_the_hand_is_told_while_it_holds_the_tool_alone():
    scenario, log = dragged()
    held_ = holding(Run(scenario, log, 1.0, np.zeros(0)))
    assert held_[: START + 1].all()
    assert not held_[START + 2 : LET_GO].any()
    assert held_[LET_GO + 2 :].all()
    gap = np.linalg.norm(log["hand_position"] - log["tool_position"], axis=1)
    numbers = metrics(Run(scenario, log, 1.0, np.zeros(0)))
    assert numbers["hand_error_max"] == gap[held_].max() < gap[~held_].max()


@pytest.mark.parametrize("seed", range(4))
def test_arm_that_is_held_anywhere_by_its_hand_does_not_shake(seed):
    # Held by an edge of its hand, the arm gives way most easily.
    model = RobotModel(FrankaTiago())
    scenario = load_scenario("petric_guided")
    q = scenario.start_position(scenario.setup())
    rng = np.random.default_rng(seed)
    body = model.arm_bodies["hand"]
    edge = rng.choice([-1, 1], 3) * [0.03, 0.1, 0.06]
    p_WQ, _ = model.point_W(body, edge, [*q, *np.zeros(10)])
    pull = Dragged(body, *edge, *(p_WQ + rng.normal(scale=0.03, size=3)))
    said = held(0.0, 0.0, 0.0)._replace(**pull._asdict())
    _, log = driven("petric_guided", [(REST, 0.1), (said, 3.0)])
    change = np.abs(np.diff(log["hand_force"][-50:], axis=0))
    assert change.max() < 0.3
