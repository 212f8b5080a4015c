"""A hand turned at omega_c, or held, in W: whatever the base does."""

import functools
import xml.etree.ElementTree as ET

import numpy as np
import pinocchio
import pytest
from drake_mobman.diagrams.guided import make_guided_diagram
from hypothesis import assume, given
from hypothesis import strategies as st
from pydrake.autodiffutils import InitializeAutoDiff
from pydrake.systems.analysis import Simulator

from drake_mobman.analysis.metrics import metrics
from drake_mobman.analysis.motion import ee_motion
from drake_mobman.arm.closed_form_inverse import ClosedFormInverse
from drake_mobman.arm.damped_inverse import DampedInverse
from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.limits import ArmStatus, JointLimits
from drake_mobman.arm.oriented_inverse import OrientedInverse, oriented_rates
from drake_mobman.arm.pseudo_inverse import Damping
from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.franka_tiago import POSTURE, FrankaTiago
from drake_mobman.robots.spatial import Spatial
from drake_mobman.scenario import ScenarioError, load_scenario
from drake_mobman.simulation.log import read_log
from drake_mobman.simulation.simulate import simulate

PERIOD = 0.01

SAME = 1e-9
"""[rad/s], [m/s]: what the inverse of a Jacobian is off by, as its own test has it."""

STEPS = 1e-10
"""Of 4,000 Euler steps, each with a rounding of the inverse of a Jacobian [rad]."""

EULER = 5e-4
"""What Euler steps turn the hand too far or tilt it [rad]: h^2 / 2 times rates about
axes that are not parallel, 0.3 rad/s twice, each step; taken back at 1/s, so h / 2."""

SERVO = 2e-3
"""What servos turn the hand too far or tilt it for a while [rad]: 0.4 rad/s told at
once, of which a joint of bounded torque makes nothing for half a period."""

TAKEN_BACK = 1e-4
"""What is left of that after a second at rest [rad]."""

PATH = 8e-3
"""What half a minute of Euler steps leads E astray [m]: each by h^2 / 2 times its
acceleration in B, about 0.1 m/s^2, that is 5e-4 m/s, for 16 s in one direction."""

# The spatial arm is three times as long as the arm that the field's defaults are for.
# Later than here, its hand is turned by more than its wrist can hold it.
LONG = "{K_f: 1.0, K_r: 1.0, Delta_f: 0.5, Delta_r: 0.3, b_d: 0.4}"
SCENARIOS = {
    "kwon_franka": ["decomposer=!VelocityField {}"],
    "kwon_spatial": [f"decomposer=!VelocityField {LONG}", "duration=30"],
}

# Two behaviours of the base.
PROMPT = ()
LAZY = ("smoother=smoother", "decomposer.K_omega=0.4", "decomposer.phi_min=0.1")

MODEL = RobotModel(FrankaTiago())
LIMITS = MODEL.joint_limits
ARM = FrankaTiago().arm()
BLIND = JacobianArm(MODEL.plant, POSTURE, Damping(level_gain=0.0))
"""The same arm, which does not see that its hand is tilted."""

BLOCKS = {
    name: OrientedInverse(ARM, LIMITS, PERIOD, name) for name in ("turning", "held")
}
INPUTS = {
    "arm_command": (0.1, -0.2, 0.05),
    "arm_position": np.add(POSTURE, [-0.3, 0.1, 0.4, 0.1, -0.3, 0.1, 0.2]),
    "ee_command": (0.2, 0.3, 0.05),
    "base_estimate": (0.1, 0.02, 0.25),
    "base_pose": (0.4, -0.3, 0.7),
}


def with_limits(lower=LIMITS.lower, upper=LIMITS.upper, velocity=LIMITS.velocity):
    return JointLimits(lower, upper, velocity, LIMITS.acceleration)


@functools.cache
def run_of(name, orientation, fidelity, *overrides):
    wanted = [f"robot.orientation={orientation}", f"fidelity={fidelity}", *overrides]
    return simulate(load_scenario(name, SCENARIOS[name] + wanted))


def hand_of(run):
    """Returns how far the hand has turned in W since the start (N,), and its tilt."""
    model = RobotModel(run.scenario.robot)
    context = model.plant.CreateDefaultContext()
    E = model.plant.GetFrameByName("tool")
    R_WE = []
    for q in np.hstack([run.log["base_pose"], run.log["arm_position"]]):
        model.plant.SetPositions(context, q)
        R_WE.append(E.CalcPoseInWorld(context).rotation().matrix())
    R = np.array(R_WE) @ R_WE[0].T
    yaw = np.arctan2(R[:, 1, 0] - R[:, 0, 1], R[:, 0, 0] + R[:, 1, 1])
    return np.unwrap(yaw), np.hypot(R[:, 0, 2], R[:, 1, 2])


def told_yaw(run):
    """Returns by how far the hand was to be turned in W since the start (N,)."""
    if run.scenario.robot.orientation == "held":
        return np.zeros(len(run.log["time"]))
    omega_c = run.log["ee_command"][:-1, 1]
    return np.append(0.0, np.cumsum(run.scenario.period * omega_c))


def pinocchio_model(urdf):
    """Returns a robot as Pinocchio reads it, which asks for what Drake does without."""
    urdf = urdf.replace('<limit effort="1000"/>', '<limit effort="1000" velocity="1"/>')
    if '<link name="world"/>' not in urdf:
        urdf = urdf.replace(
            '<link name="x_slide"/>', '<link name="x_slide"/><link name="world"/>'
        )
    robot = ET.fromstring(urdf)
    for joint in robot.findall("joint"):
        if joint.get("name").endswith("_wheel"):
            joint.set("type", "fixed")  # At this fidelity wheels do not turn.
    return pinocchio.buildModelFromXML(ET.tostring(robot, encoding="unicode"))


EVERY = pytest.mark.parametrize("name", SCENARIOS)
EITHER = pytest.mark.parametrize("orientation", ["turning", "held"])


# The orientation.


@EVERY
@EITHER
@pytest.mark.parametrize("base", [PROMPT, LAZY], ids=["prompt", "lazy"])
def test_hand_goes_and_turns_as_told_and_level_whatever_the_base_does(
    name, orientation, base
):
    run = run_of(name, orientation, "kinematic", *base)
    assert not run.log["arm_status"].any()
    yaw, tilt = hand_of(run)
    # Of the spatial arm, whose hand turns about z, Euler steps miss nothing.
    tolerance = EULER if name == "kwon_franka" else STEPS
    np.testing.assert_allclose(yaw, told_yaw(run), rtol=0, atol=tolerance)
    assert tilt.max() < tolerance
    assert metrics(run)["ee_drift_max"] < PATH


@EVERY
@EITHER
def test_with_masses_too_and_nothing_sums_up(name, orientation):
    run = run_of(name, orientation, "servo")
    assert not run.log["arm_status"].any()
    yaw, tilt = hand_of(run)
    np.testing.assert_allclose(yaw, told_yaw(run), rtol=0, atol=SERVO)
    assert tilt.max() < SERVO
    assert metrics(run)["ee_drift_max"] < 2 * PATH
    if name == "kwon_franka":  # Which ends at rest.
        assert abs(yaw[-1] - told_yaw(run)[-1]) < TAKEN_BACK
        assert tilt[-1] < TAKEN_BACK


@EVERY
def test_along_its_reach_the_hand_is_turned_by_the_base_too(name):
    prompt, lazy = (
        hand_of(run_of(name, "reach", "kinematic", *base))[0] for base in (PROMPT, LAZY)
    )
    assert np.abs(prompt - lazy).max() > 20 * EULER


@EITHER
def test_what_euler_steps_turn_too_far_shrinks_with_the_step(orientation):
    def miss(*period):
        run = run_of("kwon_franka", orientation, "kinematic", *period)
        yaw, tilt = hand_of(run)
        return max(np.abs(yaw - told_yaw(run)).max(), tilt.max())

    assert miss("period=0.005") == pytest.approx(0.5 * miss(), rel=0.1)


@EITHER
@pytest.mark.parametrize("fidelity", ["kinematic", "servo"])
def test_the_hand_starts_as_it_stands(orientation, fidelity):
    start = "start={l: 0.58, psi: 0.4, z: -0.21, theta: 2.9}"
    run = run_of("kwon_franka", orientation, fidelity, start, "duration=1.0")
    # A second at rest but for the base, which turns towards its hand.
    assert np.abs(run.log["base_command_smoothed"][:, 1]).max() > 0.2
    tolerance = EULER if fidelity == "kinematic" else SERVO
    np.testing.assert_allclose(hand_of(run)[0], 0.0, rtol=0, atol=tolerance)


# The hand's velocity and path.


@EVERY
@EITHER
@pytest.mark.parametrize("base", [PROMPT, LAZY], ids=["prompt", "lazy"])
def test_the_hands_twist_in_w_is_the_operators_as_pinocchio_has_it(
    name, orientation, base
):
    run = run_of(name, orientation, "kinematic", *base)
    model = pinocchio_model(run.scenario.robot.urdf())
    data = model.createData()
    tool = model.getFrameId("tool", pinocchio.FrameType.BODY)
    axes = ee_motion(run).axes
    for k in range(0, len(axes) - 1, 53):
        (x, y, theta), (v, _, omega) = (
            run.log[signal][k] for signal in ("base_pose", "base_velocity")
        )
        c, s = np.cos(theta), np.sin(theta)
        # There, a joint without limits is a point on the circle.
        q = np.array([x, y, c, s, *run.log["arm_position"][k]])
        rates = np.array([v * c, v * s, omega, *run.log["arm_velocity"][k]])
        pinocchio.forwardKinematics(model, data, q, rates)
        V_WE = pinocchio.getFrameVelocity(
            model, data, tool, pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        v_c, omega_c, v_z = run.log["ee_command"][k]
        l = run.log["ee_cylindrical"][k, 0]
        c, s = np.cos(axes[k]), np.sin(axes[k])
        told = [c * v_c - s * l * omega_c, s * v_c + c * l * omega_c, v_z]
        np.testing.assert_allclose(V_WE.linear, told, rtol=0, atol=SAME)
        turn = [0.0, 0.0, omega_c if orientation == "turning" else 0.0]
        # What the last steps turned too far is taken back at 1/s.
        np.testing.assert_allclose(V_WE.angular, turn, rtol=0, atol=EULER)


@EVERY
@EITHER
def test_straight_ahead_the_hands_path_is_the_same_for_every_base(name, orientation):
    """The base is in line with the reach, and does not turn that."""
    segments = "[!Held {duration: 5.0, v_c: 0.2}, !Held {duration: 5.0, v_c: -0.15}]"
    told = [f"source.segments={segments}", "duration=10"]
    gain = {"kwon_franka": 2.8, "kwon_spatial": 0.5}[name]
    prompt, lazy = (
        run_of(name, orientation, "kinematic", *base, *told)
        for base in (PROMPT, (*LAZY, f"decomposer.K_f={gain}"))
    )
    assert not prompt.log["arm_status"].any()
    assert not lazy.log["arm_status"].any()
    apart = ee_motion(prompt).position - ee_motion(lazy).position
    assert np.linalg.norm(apart, axis=1).max() < PATH
    bases = prompt.log["base_pose"][:, 0] - lazy.log["base_pose"][:, 0]
    assert np.abs(bases).max() > 2 * PATH


# Limits.

TURNED_FAR = (
    "source.segments=[!Held {duration: 10.0, omega_c: 0.35},"
    " !Held {duration: 5.0, v_c: 0.2, omega_c: 0.2}, !Held {duration: 10.0},"
    " !Held {duration: 10.0, omega_c: -0.35}, !Held {duration: 10.0}]",
    "duration=45",
)


@EVERY
def test_a_wrist_at_its_end_turns_the_hand_and_does_not_hold_up_the_arm(name):
    run = run_of(name, "held", "kinematic", *TURNED_FAR)
    wrist = run.log["arm_position"][:, -1]
    model = RobotModel(run.scenario.robot)
    ends = model.joint_limits.lower[-1], model.joint_limits.upper[-1]
    ended = np.isclose(wrist, ends[0], atol=1e-6) | np.isclose(
        wrist, ends[1], atol=1e-6
    )
    assert ended.sum() > 300
    yaw, tilt = hand_of(run)
    assert np.abs(yaw).max() > 0.5
    assert tilt.max() < EULER
    # The status says so as long as the hand is turned along.
    rate = np.abs(np.diff(yaw)) / run.scenario.period
    told = ended[:-1] & (run.log["ee_command"][:-1, 1] > 0) & (rate > 0.05)
    assert told.sum() > 300
    status = run.log["arm_status"][:-1, 0][told].astype(int)
    assert (status & ArmStatus.JOINT_LIMIT).all()
    # The hand goes on all the same, and the base is at rest after it.
    assert metrics(run)["ee_drift_max"] < PATH
    assert np.abs(run.log["base_command_smoothed"][2499]).max() < 0.01
    # Back again, by the shorter way, it is held as at the start.
    np.testing.assert_allclose(np.sin(yaw[-1]), 0.0, atol=5e-3)
    assert np.cos(yaw[-1]) > 0.9


def one_more_period(fed, step, block, **inputs):
    """Returns the yaw in W that a block goes on from, and the hand's own (2,) [rad]."""
    own = inputs["base_pose"][2] + ARM.yaw(inputs["arm_position"])
    context = fed(block, state=[own + 0.1], **inputs)
    step(block, context)
    return context.get_discrete_state_vector().CopyToVector()[0], own


def test_a_hand_that_turns_goes_on_from_where_the_limit_left_it(fed, step):
    turning = BLOCKS["turning"]
    led, own = one_more_period(fed, step, turning, **INPUTS)
    assert led == pytest.approx(own + 0.1 + PERIOD * 0.3)
    slow = with_limits(velocity=[0.01] * 7)
    block = OrientedInverse(ARM, slow, PERIOD, "turning")
    led, own = one_more_period(fed, step, block, **INPUTS)
    assert led == pytest.approx(own + PERIOD * 0.3)


SPEED = st.floats(-0.4, 0.4)


def twist(q, rates, h=1e-6):
    """Returns V_BE (6,) by central differences."""
    plant = MODEL.plant
    context = plant.CreateDefaultContext()
    poses = []
    for dt in (h, -h):
        at = np.append(np.zeros(3), q + dt * np.array(rates))
        plant.SetPositions(context, at)
        poses.append(plant.GetFrameByName("tool").CalcPoseInWorld(context))
    after, before = poses
    turn = (after.rotation() @ before.rotation().inverse()).ToAngleAxis()
    moved = after.translation() - before.translation()
    return np.append(turn.angle() * turn.axis(), moved) / (2 * h)


def swung(angle):
    """Returns the posture with the elbow swung out, the hand level where it was."""
    q = np.array(POSTURE)
    for _ in range(50):
        jacobian = np.transpose([twist(q, unit) for unit in np.eye(7)])
        rates = np.linalg.svd(jacobian)[2][-1]
        q = q + angle / 50 * rates * np.sign(rates[2])
    return q


SWUNG = [swung(angle) for angle in (-0.8, 0.0, 0.4)]


@given(
    q=st.sampled_from(SWUNG),
    wrist=st.floats(-2.0, 2.0),
    command=st.tuples(SPEED, SPEED, SPEED),
    yaw_rate=SPEED,
    sign=st.booleans(),
)
def test_with_its_wrist_at_an_end_the_hand_moves_as_without(
    q, wrist, command, yaw_rate, sign
):
    q = np.append(q[:6], wrist)
    lower, upper = list(LIMITS.lower), list(LIMITS.upper)
    (upper if sign else lower)[6] = wrist
    blocked = with_limits(lower, upper)
    free, status, _ = oriented_rates(BLIND, q, command, yaw_rate, 0.0, LIMITS, PERIOD)
    assume(status == ArmStatus.OK)
    found, status, _ = oriented_rates(BLIND, q, command, yaw_rate, 0.0, blocked, PERIOD)
    # A slack of 1e-9 rad over a period, and what differences are off by.
    assert (found[6] if sign else -found[6]) <= 1.1e-7
    gives_way = status == ArmStatus.JOINT_LIMIT | ArmStatus.ORIENTATION
    as_told = [0, 1, 3, 4, 5] if gives_way else [*range(6)]
    moved, told = twist(q, found), twist(q, free)
    np.testing.assert_allclose(moved[as_told], told[as_told], rtol=0, atol=1e-6)


# The block.


@EITHER
def test_its_ports_have_the_signals_names_and_sizes(orientation):
    block = BLOCKS[orientation]
    inputs = [block.get_input_port(i) for i in range(block.num_input_ports())]
    found = [block.get_output_port(i) for i in range(block.num_output_ports())]
    assert {p.get_name(): p.size() for p in inputs} == {
        name: len(value) for name, value in INPUTS.items()
    }
    assert [(p.get_name(), p.size()) for p in found] == [
        ("arm_velocity_command", 7),
        ("arm_status", 1),
    ]


@pytest.mark.parametrize(("orientation", "omega"), [("turning", 0.3), ("held", 0.0)])
def test_its_yaw_rate_is_told_less_sent_and_what_it_lacks(fed, orientation, omega):
    q, lacks = np.array(INPUTS["arm_position"]), 0.02
    own = INPUTS["base_pose"][2] + ARM.yaw(q)
    block = BLOCKS[orientation]
    context = fed(block, state=[own + lacks], **INPUTS)
    rates = block.GetOutputPort("arm_velocity_command").Eval(context)
    level = fed(block, state=[own], **INPUTS)
    at_once = block.GetOutputPort("arm_velocity_command").Eval(level)
    found, expected = twist(q, rates), twist(q, at_once)
    # The hand is tilted by 0.15 rad, of which the square counts.
    assert found[2] - expected[2] == pytest.approx(lacks, rel=0.02)
    assert expected[2] == pytest.approx(omega - 0.25, abs=1e-2)
    v_m, omega_m, v_z = INPUTS["arm_command"]
    l, psi, _ = ARM.ee_cylindrical(q)
    c, s = np.cos(psi), np.sin(psi)
    told = [c * v_m - s * l * omega_m, s * v_m + c * l * omega_m, v_z]
    np.testing.assert_allclose(found[3:], told, rtol=0, atol=1e-7)


@EITHER
def test_two_contexts_do_not_disturb_each_other(fed, orientation):
    block = BLOCKS[orientation]
    port = block.GetOutputPort("arm_velocity_command")
    other = {**INPUTS, "arm_position": np.array(POSTURE)}
    first, second = (
        fed(block, state=[yaw], **inputs)
        for yaw, inputs in ((0.5, INPUTS), (0.9, other))
    )
    before = port.Eval(first)
    assert (port.Eval(second) != before).all()
    first.SetDiscreteState([0.6])
    first.SetDiscreteState([0.5])
    np.testing.assert_array_equal(port.Eval(first), before)


@EITHER
@pytest.mark.parametrize("slowest", [0.1, 2.0], ids=["bound", "free"])
def test_its_derivatives_are_those_of_differences(fed, orientation, slowest):
    limits = with_limits(velocity=[slowest] * 7)
    block = OrientedInverse(ARM, limits, PERIOD, orientation)
    twin = block.ToAutoDiffXd()
    names = [*INPUTS, "state"]
    values = [np.array(value) for value in INPUTS.values()] + [np.array([0.5])]
    ends = np.cumsum([len(value) for value in values])[:-1]
    x = np.concatenate(values)

    def rates(of, x):
        context = fed(of, **dict(zip(names, np.split(x, ends), strict=True)))
        return of.GetOutputPort("arm_velocity_command").Eval(context)

    found = rates(twin, InitializeAutoDiff(x).ravel())
    np.testing.assert_allclose([y.value() for y in found], rates(block, x), atol=SAME)
    if slowest < 1:
        assert max(abs(rates(block, x))) == pytest.approx(slowest)
    h = 1e-6
    for i, e in enumerate(np.eye(len(x))):
        slope = (rates(block, x + h * e) - rates(block, x - h * e)) / (2 * h)
        ours = [y.derivatives()[i] for y in found]
        # h^2 times a third derivative; and rounding over h.
        np.testing.assert_allclose(ours, slope, rtol=0, atol=1e-6)


def test_an_orientation_that_is_none_is_refused():
    says = "orientation: 'reach' is not valid; must be one of turning, held"
    with pytest.raises(ParameterError) as refusal:
        OrientedInverse(ARM, LIMITS, PERIOD, "reach")
    assert str(refusal.value) == says
    says = "must be one of reach, turning, held"
    for name in SCENARIOS:
        with pytest.raises(ScenarioError, match=rf"robot\.orientation: .* {says}"):
            load_scenario(name, ["robot.orientation=sideways"])


# How it is wired.


@pytest.mark.parametrize(
    ("name", "orientation", "block"),
    [
        ("kwon_1", None, ClosedFormInverse),
        ("kwon_spatial", "reach", ClosedFormInverse),
        ("kwon_spatial", "held", OrientedInverse),
        ("kwon_franka", "reach", DampedInverse),
        ("kwon_franka", "turning", OrientedInverse),
    ],
)
def test_the_orientation_chooses_the_arms_inverse(name, orientation, block):
    overrides = [f"robot.orientation={orientation}"] if orientation else []
    scenario = load_scenario(name, overrides)
    made = scenario.robot.arm_inverse(scenario.setup())
    assert isinstance(made, block)


@given(l=st.floats(0.5, 1.9), psi=st.floats(-2.8, 2.8), z=st.floats(-0.3, 0.5))
def test_the_spatial_arm_starts_along_its_reach_all_the_same(l, psi, z):
    closed = Spatial().arm()
    q = closed.inverse((l, psi, z))
    found = SPATIAL.inverse((l, psi, z))
    # Rounding of the hand's place, over the smallest singular value.
    np.testing.assert_allclose(found, q, rtol=0, atol=1e-9)
    np.testing.assert_allclose(
        SPATIAL.ee_cylindrical(q), (l, psi, z), rtol=0, atol=SAME
    )
    assert SPATIAL.yaw(q) == pytest.approx(psi, abs=SAME)
    assert SPATIAL.p_BS == pytest.approx(closed.p_BS, abs=1e-12)


SPATIAL = Spatial(orientation="held").arm()


def test_a_free_arm_is_none_of_its_business():
    logs = []
    for orientation in ("reach", "held"):
        overrides = ["duration=0.5", f"robot.orientation={orientation}"]
        scenario = load_scenario("petric_guided", overrides)
        diagram = make_guided_diagram(scenario)
        simulator = Simulator(diagram)
        simulator.AdvanceTo(scenario.duration)
        logs.append(read_log(diagram, simulator.get_context()))
    for signal, values in logs[0].items():
        assert values.tobytes() == logs[1][signal].tobytes(), signal
