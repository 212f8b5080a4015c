"""The base turns the way that the arm's first joint can follow, and comes to rest."""

import dataclasses as dc
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_mobman.arm.first_joint import FirstJoint, turning_share, unwound
from drake_mobman.arm.limits import JointLimits
from drake_mobman.base.velocity_field import (
    VelocityField,
    VelocityFieldController,
    Zone,
)
from drake_mobman.compiled import compiled
from drake_mobman.decomposers.exact import Exact, exact_base
from drake_mobman.decomposers.field import build_decomposer
from drake_mobman.decomposers.status import DecomposerStatus
from drake_mobman.robot_model import Reach, RobotModel, WorkspaceLimits
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate
from drake_mobman.teleop.scripted import Held, Script

PI = math.pi
PLANAR = (-3.4, 4.9)
"""Ends of the planar arm's first joint [rad]."""

AT_REST = 1e-2
"""Speed of the base that counts as rest [m/s], [rad/s]: it dies away as 1 / t^2."""

SWEPT = 1e-6
"""What an arm that is in reach and in range leaves of the hand's path [m]: the way of
an Euler step's second order, and rounding."""


# --- The way round --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("phi", "angle", "ends", "expected"),
    [
        # The shorter way, wherever it ends well inside.
        (0.5, 0.5, PLANAR, 0.5),
        (-3.0, -3.0, PLANAR, -3.0),
        (3.1, 3.1, (-2.9, 2.9), 3.1),
        # Past half a turn: 3.2 is seen as 3.2 - 2 pi, and turned back by 3.2.
        (3.2 - 2 * PI, 3.2, PLANAR, 3.2),
        (-3.3 + 2 * PI, -3.3, PLANAR, -3.3),
        (4.9 - 2 * PI, 4.9, PLANAR, 4.9),
        # An elbow that is bent: the bearing is not the joint's angle.
        (3.2 - 2 * PI, 4.25, PLANAR, 3.2),
        # A joint without ends follows any way, and the shorter is taken.
        (3.2 - 2 * PI, 3.2, (-math.inf, math.inf), 3.2 - 2 * PI),
        (1.0, 25.0, (-math.inf, math.inf), 1.0),
        # With one end, all but past that.
        (-3.0, 3.2, (-math.inf, 4.9), -3.0 + 2 * PI),
        (-1.0, 3.2, (-math.inf, 4.9), -1.0),
        # It goes neither way: an arm that is mounted backwards.
        (3.0, 3.0 - PI, (-2.9, 2.9), 3.0),
        (-3.0, PI - 3.0, (-2.9, 2.9), -3.0),
    ],
)
def test_the_base_turns_the_way_that_the_joint_can_follow(phi, angle, ends, expected):
    assert unwound(phi, FirstJoint(angle, *ends)) == pytest.approx(expected)


@given(
    angle=st.floats(-7, 7),
    elbow=st.floats(-PI, PI),
    lower=st.floats(-7, 0),
    upper=st.floats(0, 7),
)
def test_where_any_way_ends_in_range_the_one_taken_does(angle, elbow, lower, upper):
    bearing = angle + elbow
    phi = math.atan2(math.sin(bearing), math.cos(bearing))
    taken = unwound(phi, FirstJoint(angle, lower, upper))
    assert math.cos(taken - phi) == pytest.approx(1.0)
    ways = [phi - 2 * PI, phi, phi + 2 * PI]
    assert np.isclose(taken, ways).any()
    well_in = [way for way in ways if lower + 1e-9 < angle - way < upper - 1e-9]
    assert not well_in or lower < angle - taken < upper


def test_the_yaw_rate_falls_to_nothing_at_the_end_that_it_leads_to():
    joint = FirstJoint(-3.4, *PLANAR)
    assert turning_share(1.0, joint, 0.4) == 0.0
    assert turning_share(-1.0, joint, 0.4) == 1.0
    assert turning_share(1.0, joint._replace(angle=-3.2), 0.4) == pytest.approx(0.5)
    assert turning_share(1.0, joint._replace(angle=-3.5), 0.4) == 0.0
    assert turning_share(-1.0, joint._replace(angle=5.0), 0.4) == 0.0
    endless = FirstJoint(0.0, -math.inf, math.inf)
    assert turning_share(1.0, endless, 0.4) == turning_share(-1.0, endless, 0.4) == 1.0


# --- The blocks -----------------------------------------------------------------------


def controller(law="projected", lower=-3.4, upper=4.9):
    limits = JointLimits([lower, -PI], [upper, 0.0], [3.0, 3.0])
    reach = Reach(l_0=0.5, r_f=2.0)
    return VelocityFieldController(VelocityField(law=law), reach, limits)


@pytest.mark.parametrize("made", [lambda block: block, compiled], ids=["", "compiled"])
@pytest.mark.parametrize("law", ["projected", "printed"])
def test_the_controller_unwinds_and_holds(law, made, fed, outputs):
    block = made(controller(law))
    # Stretched to 1.5 m, past half a turn to the left.
    at = (1.5 * math.cos(3.3), 1.5 * math.sin(3.3), 0.5)
    found = outputs(block, fed(block, p_BT=at, arm_position=(3.3, 0.0)))
    assert found["base_command"][1] == pytest.approx(1.0)
    assert found["field_zone"] == Zone.ROTATION
    # The same place with the joint the other way round.
    found = outputs(block, fed(block, p_BT=at, arm_position=(3.3 - 2 * PI, 0.0)))
    assert found["base_command"][1] == pytest.approx(-1.0)
    # Mounted backwards, it never faces ahead: half of the rate near its end, then none.
    block = made(controller(law, -2.9, 2.9))
    for angle, phi, omega in ((-2.4, 0.7, 1.0), (-2.7, 0.6, 0.5), (-2.9, 0.45, 0.0)):
        at = (1.5 * math.cos(phi), 1.5 * math.sin(phi), 0.5)
        found = outputs(block, fed(block, p_BT=at, arm_position=(angle, 0.0)))
        assert found["base_command"][1] == pytest.approx(omega)
        held = Zone.HELD if omega < 1 else 0
        assert found["field_zone"] == Zone.ROTATION | held


def test_the_exact_law_turns_no_further_than_the_first_joint_goes():
    """Else the joint's end would stop hand and base for good."""
    command, at, limits = (0.3, 0.0, 0.0), (1.0, 2.0, 0.0), WorkspaceLimits()
    for angle, omega in ((-2.0, 0.8), (-2.65, 0.4), (-2.9, 0.0)):
        joint = FirstJoint(angle, -2.9, 2.9)
        base = exact_base(command, at, Exact(), limits, (0.0, 0.0, 0.0), joint)
        assert base[1] == pytest.approx(omega)
    assert exact_base(command, at, Exact(), limits, (0.0, 0.0, 0.0))[
        1
    ] == pytest.approx(0.8)


def test_without_limits_the_controller_asks_for_no_joints():
    block = VelocityFieldController(VelocityField(), Reach(0.5, 2.0))
    assert block.num_input_ports() == 1


@pytest.mark.parametrize("made", [lambda block: block, compiled], ids=["", "compiled"])
def test_the_decomposer_names_the_end_that_holds_the_base(made, fed, outputs):
    scenario = load_scenario("kwon_1", [FIELD.format("printed")])
    block = made(build_decomposer(scenario.decomposer, scenario.setup()))
    arm = scenario.robot.arm()

    def told(q):
        at = arm.ee_cylindrical(q)
        context = fed(
            block,
            ee_command=(0, 0, 0),
            ee_cylindrical=at,
            arm_position=q,
            base_command_smoothed=(0, 0),
            base_estimate=(0, 0, 0),
        )
        return outputs(block, context)

    free = told((1.5, -1.0))
    assert free["base_command"][1] == pytest.approx(1.0)
    assert free["decomposer_status"] == DecomposerStatus.OK
    # As printed, the base drives away from a hand that is behind: a stretched arm
    # cannot give way to that, but to turning.
    freed = told((2.0, -1e-9))
    assert freed["base_command"] == pytest.approx([0.0, 1.0], abs=1e-6)
    assert freed["decomposer_status"] == DecomposerStatus.BASE_HELD
    # All but folded up, the hand has no bearing that the arm could keep.
    folded = told((1.0, -PI + 1e-3))
    assert folded["base_command"][1] == 0.0
    assert folded["decomposer_status"] == DecomposerStatus.BASE_HELD


# --- The loops ------------------------------------------------------------------------


def run_of(name, *overrides, source=None):
    scenario = load_scenario(name, list(overrides))
    if source:
        scenario = dc.replace(scenario, source=source)
    run = simulate(scenario)
    assert run.died == ""
    return run


def turned(run):
    """Returns how far the base turned, to and fro [rad]."""
    return np.abs(run.log["base_command_smoothed"][:, 1]).sum() * run.scenario.period


def check_it_rests(run, most):
    """Checks that the base has come to rest and turned by no more than `most` [rad]."""
    sent = run.log["base_command_smoothed"]
    assert np.abs(sent[-1]).max() < AT_REST
    assert turned(run) < most


def check_no_joint_is_pressed(run):
    """Checks that no joint sits at its end while the base turns it further.

    For as long as a base takes to stop it may: the first joint turns against the base.
    """
    limits = RobotModel(run.scenario.robot).joint_limits
    q, omega = run.log["arm_position"][:, 0], run.log["base_command_smoothed"][:, 1]
    at_rest = np.abs(run.log["ee_command"]).max(axis=1) == 0
    pressed = ((q < limits.lower[0] + 1e-6) & (omega > AT_REST)) | (
        (q > limits.upper[0] - 1e-6) & (omega < -AT_REST)
    )
    assert (pressed & at_rest).sum() * run.scenario.period < 0.6


FIELD = "decomposer=!VelocityField {{law: {}}}"
NOBODY = "source.segments=[]"


@pytest.mark.parametrize("law", ["projected", "printed"])
@pytest.mark.parametrize("compiled", ["false", "true"])
def test_past_half_a_turn_the_base_turns_back_and_rests(law, compiled):
    where = "start={l: 1.0, psi: 3.2}"
    run = run_of("kwon_1", FIELD.format(law), where, NOBODY, f"compiled={compiled}")
    # To phi_min, the way that it was wound.
    assert turned(run) == pytest.approx(3.2 - 0.2, abs=0.02)
    assert (run.log["base_command_smoothed"][:, 1] >= 0).all()
    check_it_rests(run, 3.2)
    p = run.log["base_pose"], run.log["ee_cylindrical"]
    psi = p[0][:, 2] + p[1][:, 1]
    hand = np.c_[np.cos(psi), np.sin(psi)] * p[1][:, :1] + p[0][:, :2]
    assert np.abs(hand - hand[0]).max() < SWEPT


@pytest.mark.parametrize("law", ["projected", "printed"])
def test_from_folded_up_past_half_a_turn_too(law):
    run = run_of("kwon_1", FIELD.format(law), "start.psi=3.2", NOBODY)
    check_it_rests(run, 4.0)
    check_no_joint_is_pressed(run)


def test_as_printed_the_base_does_not_circle_round_a_hand_that_it_turns_away_from():
    # On the left, near, and wound up to it from the right.
    where = "start={l: 0.3, psi: -4.6}"
    run = run_of("kwon_1", FIELD.format("printed"), where, NOBODY)
    assert run.log["base_command_smoothed"][:, 1].max() < AT_REST
    check_it_rests(run, 4.6)


@pytest.mark.parametrize("law", ["projected", "printed"])
@pytest.mark.parametrize("smoother", ["unsmoothed", "smoother"])
@pytest.mark.parametrize("K_omega", [1.0, 0.3])
def test_an_operator_who_turns_the_arm_past_half_a_turn_gets_no_spin(
    law, smoother, K_omega
):
    # A base that is slower than the operator is passed by the hand behind it.
    told = "source.segments=[!Held {duration: 3.0, omega_c: 0.4}]"
    run = run_of(
        "kwon_1",
        f"decomposer=!VelocityField {{law: {law}, K_omega: {K_omega}}}",
        "start={l: 1.0, psi: 2.9}",
        f"smoother={smoother}",
        "duration=25",
        "compiled=true",
        told,
    )
    assert (run.log["ee_cylindrical"][:, 1].max() > PI) == (K_omega < 0.4)
    # 1.2 rad of the operator's, and all that psi was from the front.
    check_it_rests(run, 2.9 + 1.2)
    check_no_joint_is_pressed(run)


SPEEDS = st.floats(-0.5, 0.5)
HELD = st.lists(st.tuples(st.floats(0.5, 3.0), SPEEDS, SPEEDS), max_size=3)


@settings(max_examples=8)
@given(
    law=st.sampled_from(["projected", "printed"]),
    l=st.one_of(st.floats(0.02, 1.98), st.sampled_from([0.0, 2.0])),
    shoulder=st.one_of(st.floats(3.3, 4.9), st.floats(-3.4, -2.6), st.floats(*PLANAR)),
    smoother=st.sampled_from(["unsmoothed", "smoother"]),
    held=HELD,
)
def test_from_any_angle_after_any_command_the_base_comes_to_rest(
    law, l, shoulder, smoother, held
):
    elbow = -2 * math.acos(l / 2)
    psi = shoulder + math.atan2(math.sin(elbow), 1 + math.cos(elbow))
    segments = [Held(t, v_c=v_c, omega_c=omega_c) for t, v_c, omega_c in held]
    seconds = sum(segment.duration for segment in segments)
    run = run_of(
        "kwon_1",
        FIELD.format(law),
        f"start={{l: {l!r}, psi: {psi!r}}}",
        f"smoother={smoother}",
        f"duration={seconds + 12}",
        "compiled=true",
        source=Script(segments=segments),
    )
    # What it was wound by, what it was commanded, and the same once for driving about.
    check_it_rests(run, 2 * (abs(psi) + 1 + 0.5 * seconds))
    check_no_joint_is_pressed(run)


@pytest.mark.parametrize("law", ["projected", "printed"])
def test_a_hand_that_pulls_the_free_arm_past_half_a_turn_unwinds_it(law):
    told = [
        "robot=!Planar {}",
        f"field={{law: {law}, b_d: 0.5}}",
        "fidelity=!Servo {joint_stiffness: 0.0}",
        "workspace={l_min: 0.2, l_max: 1.9}",
        "start={l: 1.0, psi: 3.3, z: 0.0}",
        f"hand.path=[{{time: 0.0, x: {math.cos(3.3)}, y: {math.sin(3.3)}, z: 0.5}}]",
        "duration=12",
    ]
    run = run_of("petric_guided", *told)
    omega = run.log["base_command_smoothed"][:, 1]
    assert omega.min() > -AT_REST
    check_it_rests(run, 3.3)
    assert run.log["ee_cylindrical"][-1, 1] == pytest.approx(0.2, abs=0.05)
