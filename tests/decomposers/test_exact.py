"""The exact decomposition: the hand does as told, or slows down in its direction."""

import dataclasses as dc
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.autodiffutils import InitializeAutoDiff

from drake_mobman.analysis.metrics import metrics
from drake_mobman.analysis.motion import ee_motion
from drake_mobman.arm.limits import JointLimits
from drake_mobman.base.smoother import Smoother
from drake_mobman.decomposers.arm_compensation import base_induced_rates
from drake_mobman.decomposers.exact import Exact, ExactDecomposer, exact_base
from drake_mobman.decomposers.field import build_decomposer
from drake_mobman.decomposers.limiter import factor_within
from drake_mobman.decomposers.status import DecomposerStatus
from drake_mobman.parameters import ParameterError, checked
from drake_mobman.robot_model import RobotModel, WorkspaceLimits
from drake_mobman.robots.planar import Planar
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate
from drake_mobman.teleop.scripted import Held, Script

ROUNDING = 1e-12
EXACT = 1e-9
"""Of a velocity [m/s]: positions of a metre, to rounding, over a period of 10 ms."""

TURNED = 1.0
"""Degrees: what the hand may turn out of its direction where a limit binds."""

CREEP = 0.01
"""[m/s]: a hand as slow as that has been slowed to a stop."""

LIMITS = WorkspaceLimits()
PERIOD = 0.01
SMOOTHED = "smoother=smoother"
SLOW_BASE = "smoother=!Smoother {max_acceleration: 0.2, max_yaw_acceleration: 0.3}"


# --- The base's law, by hand ----------------------------------------------------------


def base(command, l, psi, p_BS=(0.0, 0.0, 0.5), **params):
    return exact_base(command, (l, psi, 0.0), Exact(**params), LIMITS, p_BS)


def test_base_rests_in_the_middle_of_the_workspace():
    assert base((0.3, 0.2, 0.1), 1.0, 0.1) == (0.0, 0.0)


def test_base_carries_the_hand_whole_at_each_limit():
    for psi in (-0.6, 0.0, 0.3, 1.0):
        for l, v_c in ((1.6, 0.3), (0.4, -0.2), (1.9, 0.1), (0.1, -0.1)):
            v_b, omega_b = base((v_c, 0.2, 0.0), l, psi)
            along, _ = base_induced_rates((l, psi, 0.0), v_b, omega_b, (0.0, 0.0, 0.5))
            assert along == pytest.approx(v_c, abs=ROUNDING)


@given(
    command=st.tuples(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4), st.just(0.0)),
    psi=st.floats(-1.04, 1.04),
    ahead=st.floats(-0.3, 0.3),
    aside=st.floats(-0.3, 0.3),
)
def test_nothing_is_left_to_the_arm_that_leads_out_of_a_limit(
    command, psi, ahead, aside
):
    p_BS = ahead, aside, 0.5
    for l, outward in ((1.6, 1), (1.8, 1), (0.4, -1), (0.2, -1)):
        v_b, omega_b = base(command, l, psi, p_BS)
        along, _ = base_induced_rates((l, psi, 0.0), v_b, omega_b, p_BS)
        assert outward * (command[0] - along) <= ROUNDING


def test_base_turns_towards_its_hand_as_the_field_does():
    # Half way from phi_min to phi_max the smoothstep is 1/2; at rest nothing turns.
    moving, slow = (0.3, 0.0, 0.0), (0.025, 0.0, 0.0)
    assert base(moving, 1.0, 0.45)[1] == pytest.approx(0.4)
    assert base(moving, 1.0, -0.45)[1] == pytest.approx(-0.4)
    assert base(slow, 1.0, 0.45)[1] == pytest.approx(0.2)
    assert base((0.0, 0.0, 0.3), 1.0, 0.45) == (0.0, 0.0)
    assert base(moving, 1.0, 0.7)[1] == pytest.approx(0.8)


def test_base_takes_all_turning_at_the_end_of_psi():
    _, omega_b = base((0.0, 0.3, 0.0), 1.0, 0.7, K_omega=0.0)
    assert omega_b == pytest.approx(0.3)


def test_base_is_told_nothing_endless_at_a_right_angle():
    command = (0.4, 0.4, 0.0)
    for psi in (math.pi / 2, -math.pi / 2):
        assert base(command, 1.6, psi)[0] == pytest.approx(0.0, abs=1e-8)
    angles = np.linspace(-math.pi, math.pi, 20_001)
    v_b = np.array([base(command, 1.6, psi)[0] for psi in angles])
    # 1.125 / cos(60 degrees), and no jump where the law changes.
    assert np.abs(v_b).max() == pytest.approx(2.25 * 0.4, rel=1e-6)
    assert np.abs(np.diff(v_b)).max() < 10 * (angles[1] - angles[0])


@given(
    wanted=st.floats(-2, 2),
    carried=st.floats(-1, 1),
    bound=st.floats(0, 2),
)
def test_factor_is_the_largest_that_the_bound_leaves(wanted, carried, bound):
    s = factor_within(wanted, carried, bound)
    side = math.copysign(1.0, wanted)
    assert 0 <= s <= 1
    if bound + side * carried >= 1e-9:
        assert side * (s * wanted - carried) <= bound + ROUNDING
    if s < 1 and s > 1e-6:  # Binding: a little more would be too much.
        assert side * (1.001 * s * wanted - carried) > bound


@pytest.mark.parametrize(
    ("params", "message"),
    [
        (Exact(share="step"), "must be one of tanh, smoothstep"),
        (
            Exact(turning_speed=0.0),
            r"turning_speed: 0.0 is not valid; must be within \[0.0001, 10\] m/s",
        ),
        (Exact(phi_min=0.8), "must be below phi_max = 0.7"),
        (
            Exact(K_omega=-1.0),
            r"K_omega: -1.0 is not valid; must be within \[0, 20\] rad/s",
        ),
    ],
)
def test_bad_parameters_are_refused(params, message):
    with pytest.raises(ParameterError, match=message):
        checked(params)


# --- The block ------------------------------------------------------------------------


def block(name="kwon_arbitrary", *overrides):
    scenario = load_scenario(name, ["decomposer=exact", *overrides])
    return build_decomposer(scenario.decomposer, scenario.setup())


@pytest.mark.parametrize("told", ["base_command_smoothed", "base_estimate"])
def test_what_the_base_does_needs_not_what_it_is_sent(told):
    exact = block("kwon_arbitrary", SMOOTHED)
    sent = exact.GetInputPort(told).get_index()
    needs_it = {
        name: exact.HasDirectFeedthrough(sent, exact.GetOutputPort(name).get_index())
        for name in (
            "base_command",
            "base_contribution",
            "arm_command",
            "decomposer_status",
        )
    }
    assert needs_it == {
        "base_command": False,
        "base_contribution": False,
        "arm_command": True,
        "decomposer_status": True,
    }


def test_each_limit_is_named(fed, outputs):
    planar = Planar()
    arm = planar.arm()

    def status(at, command, sent=(0.0, 0.0), smoother=None, **limits):
        n = arm.num_joints
        model = RobotModel(planar).joint_limits
        joints = dc.replace(
            JointLimits(model.lower, model.upper, model.velocity), **limits
        )
        smoother = smoother or Smoother(smoothing=1.0)
        base_limits = smoother.limits()
        exact = ExactDecomposer(Exact(), LIMITS, arm, joints, base_limits, PERIOD)
        q = arm.inverse(at)
        assert len(q) == n
        context = fed(
            exact,
            ee_command=command,
            ee_cylindrical=at,
            arm_position=q,
            base_command_smoothed=sent,
            base_estimate=(sent[0], 0.0, sent[1]),
        )
        found = outputs(exact, context)
        return DecomposerStatus(int(found["decomposer_status"][0])), found

    ahead = (0.3, 0.0, 0.0)
    assert status((1.0, 0.0, 0.0), ahead)[0] == DecomposerStatus.OK
    slow = Smoother(smoothing=1.0, max_speed=0.1)
    named, found = status((1.6, 0.0, 0.0), ahead, sent=(0.1, 0.0), smoother=slow)
    assert named & DecomposerStatus.BASE_RATE
    # A third of the command is what the base can carry, and the arm adds nothing.
    assert found["base_command"] == pytest.approx([0.1, 0.0])
    assert found["arm_command"] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)
    named, found = status((1.0, 0.0, 0.0), ahead, velocity=[0.2, 0.2])
    assert named == DecomposerStatus.JOINT_RATE
    # l = 2 cos(theta_2 / 2): l' = -sin(theta_2 / 2) theta_2', and 2 % are kept back.
    fastest = 0.98 * 0.2 * math.sin(math.acos(0.5))
    assert found["arm_command"][0] == pytest.approx(fastest)
    q = arm.inverse((1.0, 0.0, 0.0))
    named, found = status((1.0, 0.0, 0.0), ahead, upper=[4.9, q[1]])
    assert named == DecomposerStatus.JOINT_LIMIT
    assert found["arm_command"] == pytest.approx([0.0, 0.0, 0.0], abs=1e-5)
    named, found = status((1.6, 0.0, 0.0), ahead)  # The base is still at rest.
    assert named == DecomposerStatus.WORKSPACE
    assert found["arm_command"] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)
    assert found["base_command"] == pytest.approx([0.3, 0.0])
    assert status((0.005, 0.0, 0.0), ahead)[0] & DecomposerStatus.SINGULAR


def test_base_that_falls_short_of_what_it_is_sent_stops_no_hand_at_an_edge(
    fed, outputs
):
    exact = block("kwon_arbitrary", SMOOTHED)
    at = (LIMITS.l_max, 0.0, 0.0)
    context = fed(
        exact,
        ee_command=(0.3, 0.0, 0.0),
        ee_cylindrical=at,
        arm_position=exact.arm.inverse(at),
        base_command_smoothed=(0.3, 0.0),
        base_estimate=(0.1, 0.02, 0.0),
    )
    found = outputs(exact, context)
    assert found["decomposer_status"] == DecomposerStatus.OK
    # The arm makes up for the 0.2 m/s that are missing, and for the slip: across l.
    across = -0.02 / LIMITS.l_max
    assert found["arm_command"] == pytest.approx([0.2, across, 0.0])


def test_autodiff_gives_the_slope_of_a_finite_difference(fed, outputs):
    exact = block("kwon_spatial", SMOOTHED)
    arm = exact.limiter.arm
    command, sent = np.array([0.3, 0.1, 0.05]), np.array([0.2, 0.1])

    def arm_command(l):
        at = (l, 0.4, 0.1)
        context = fed(
            exact,
            ee_command=command,
            ee_cylindrical=at,
            arm_position=arm.inverse(at),
            base_command_smoothed=sent,
            base_estimate=(sent[0], 0.0, sent[1]),
        )
        found = outputs(exact, context)
        return np.concatenate([found["base_command"], found["arm_command"]])

    other = exact.ToAutoDiffXd()
    context = other.CreateDefaultContext()
    (l,) = InitializeAutoDiff(np.array([1.53])).ravel()
    at = np.array([l, 0.4 + 0 * l, 0.1 + 0 * l])
    for name, value in (
        ("ee_command", command),
        ("ee_cylindrical", at),
        ("arm_position", np.array(arm.inverse(at))),
        ("base_command_smoothed", sent),
        ("base_estimate", np.array([sent[0], 0.0, sent[1]])),
    ):
        other.GetInputPort(name).FixValue(context, value + 0 * l)
    slope = [
        value.derivatives()[0] if value.derivatives().size else 0.0
        for name in ("base_command", "arm_command")
        for value in other.GetOutputPort(name).Eval(context)
    ]
    step = 1e-6
    central = (arm_command(1.53 + step) - arm_command(1.53 - step)) / (2 * step)
    np.testing.assert_allclose(slope, central, rtol=1e-6, atol=1e-6)
    assert np.abs(central).max() > 0.1


# --- The loop -------------------------------------------------------------------------


def run_of(name, *overrides, source=None):
    scenario = load_scenario(name, ["decomposer=exact", *overrides])
    if source:
        scenario = dc.replace(scenario, source=source)
    run = simulate(scenario)
    assert run.died == ""
    return run


def statuses(run):
    return run.log["decomposer_status"][:, 0].astype(int)


def errors(run):
    return np.linalg.norm(ee_motion(run).error, axis=1)


def random_minute(seed, largest=0.4):
    """Returns a minute of an operator who holds the stick, lets go and jumps."""
    rng = np.random.default_rng(seed)
    segments, left = [], 60.0
    while left > 0:
        duration = min(left, float(rng.uniform(0.05, 6.0)))
        v_c, omega_c = rng.uniform(-largest, largest, 2) * rng.integers(0, 2, 2)
        segments.append(Held(duration, v_c=float(v_c), omega_c=float(omega_c)))
        left -= duration
    return Script(segments=segments)


def check_a_minute(run):
    """Checks what holds of any minute whatever the operator did."""
    assert errors(run)[statuses(run) == 0].max() < EXACT
    excess = metrics(run)["workspace_excess_max"]
    assert max(excess.values()) < ROUNDING
    smoother, sent = run.scenario.smoother, run.log["base_command_smoothed"]
    if not smoother.limits().follows_at_once:
        largest = PERIOD * np.array(
            [smoother.max_acceleration, smoother.max_yaw_acceleration]
        )
        assert (np.abs(np.diff(sent, axis=0)) <= largest + ROUNDING).all()
    assert turned(run) < TURNED


def turned(run):
    """Returns how far the hand turned out of its direction, at most [degrees]."""
    motion = ee_motion(run)
    true = np.column_stack([motion.velocity, motion.rise])
    told = np.column_stack([motion.in_force, run.log["ee_command"][:, 2]])
    fast = (np.linalg.norm(true, axis=1) > CREEP) & (
        np.linalg.norm(told, axis=1) > CREEP
    )
    true, told = true[fast], told[fast]
    cross = np.linalg.norm(np.cross(true, told), axis=1)
    return np.degrees(np.arctan2(cross, np.sum(true * told, axis=1))).max()


@pytest.mark.parametrize("smoother", ["smoother=unsmoothed", SMOOTHED])
@pytest.mark.parametrize("name", ["kwon_arbitrary", "kwon_spatial"])
def test_hand_does_as_the_operator_says_and_keeps_the_workspace(name, smoother):
    run = run_of(name, smoother, "compiled=true")
    assert not statuses(run).any()
    assert errors(run).max() < EXACT
    check_a_minute(run)
    # So it is not for want of turning the base, nor of the limits being reached.
    assert np.abs(run.log["base_command_smoothed"]).max(axis=0).min() > 0.3
    blending = "decomposer=blending", "compiled=true"
    printed = metrics(simulate(load_scenario(name, blending)))
    assert printed["ee_error_rms"] > 0.06


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("smoother", ["smoother=unsmoothed", SMOOTHED, SLOW_BASE])
def test_any_minute_of_held_commands_is_exact_and_inside(smoother, seed):
    name = ("kwon_arbitrary", "kwon_spatial")[seed % 2]
    check_a_minute(run_of(name, smoother, "compiled=true", source=random_minute(seed)))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(500))
def test_500_minutes_of_held_commands_are_exact_and_inside(seed):
    name = ("kwon_arbitrary", "kwon_spatial")[seed % 2]
    smoother = ("smoother=unsmoothed", SMOOTHED, SLOW_BASE)[seed % 3]
    check_a_minute(
        run_of(name, smoother, "compiled=true", source=random_minute(1000 + seed))
    )


@pytest.mark.parametrize(
    ("name", "where", "held"),
    [
        # Out and up until the arm is stretched; in and down; the waist to its end.
        ("kwon_spatial", "start.l=1.0", "{duration: 11, v_c: 0.1, v_z: 0.2}"),
        ("kwon_spatial", "start.l=1.0", "{duration: 11, v_c: -0.1, v_z: -0.2}"),
        ("kwon_arbitrary", "start.psi=1.5707963267948966", "{duration: 11, v_c: 0.3}"),
        (
            "kwon_arbitrary",
            "start.psi=-1.5707963267948966",
            "{duration: 11, v_c: -0.3}",
        ),
        ("kwon_arbitrary", "start.l=0.0", "{duration: 11, v_c: 0.3, omega_c: 0.3}"),
        ("kwon_arbitrary", "start.l=2.0", "{duration: 11, v_c: -0.3, omega_c: 0.3}"),
        ("kwon_spatial", "start.psi=2.8", "{duration: 11, v_c: 0.3, omega_c: 0.3}"),
    ],
)
@pytest.mark.parametrize("smoother", ["smoother=unsmoothed", SMOOTHED, SLOW_BASE])
def test_a_limit_slows_the_hand_and_does_not_turn_it(name, where, held, smoother):
    script = f"source.segments=[!Held {held}]"
    run = run_of(name, "duration=10", where, smoother, script)
    assert turned(run) < TURNED
    assert errors(run)[statuses(run) == 0].max() < EXACT
    # A stick that is held still makes no jump in what the base is told, but for the
    # start of it.
    told = run.log["base_command"][1:]
    assert np.abs(np.diff(told, axis=0)).max() < 0.05


def test_hand_that_reaches_the_end_of_the_arm_comes_to_rest_with_its_base():
    script = "source.segments=[!Held {duration: 13, v_c: 0.1, v_z: 0.2}]"
    run = run_of("kwon_spatial", "duration=12", SMOOTHED, script)
    assert statuses(run)[-1] & DecomposerStatus.JOINT_LIMIT
    assert np.linalg.norm(ee_motion(run).velocity[-1]) < 1e-3
    assert np.abs(run.log["base_command_smoothed"][-1]).max() < 1e-3


@pytest.mark.parametrize("name", ["kwon_spatial", "kwon_franka"])
def test_with_masses_the_hand_does_as_told_to_a_centimetre_a_second(name):
    servo = "fidelity=servo", "compiled=true", "duration=25"
    exact = metrics(simulate(load_scenario(name, servo)))
    other = {
        "kwon_spatial": "decomposer=blending",
        "kwon_franka": "decomposer=!Blending {alpha: 60.0}",
    }[name]
    blended = metrics(simulate(load_scenario(name, [*servo, other])))
    assert exact["ee_error_rms"] < 0.01
    assert 4 * exact["ee_error_rms"] < blended["ee_error_rms"]
    assert max(exact["workspace_excess_max"].values()) < 0.005
