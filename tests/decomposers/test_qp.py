"""The quadratic program, its solution, and blocks that split a command by a solver."""

import dataclasses as dc
import functools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from qpsolvers import solve_qp

from drake_mobman.analysis.metrics import metrics
from drake_mobman.arm.limits import JointLimits
from drake_mobman.decomposers.arm_compensation import base_induced_rates
from drake_mobman.decomposers.blending import Blending, BlendingDecomposer
from drake_mobman.decomposers.diff_ik import DiffIk, DiffIkDecomposer
from drake_mobman.decomposers.optimization import braking_factor
from drake_mobman.decomposers.qp import (
    Qp,
    QpDecomposer,
    QpProgram,
    decomposition_qp,
)
from drake_mobman.decomposers.status import DecomposerStatus
from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import RobotModel, RobotSetup
from drake_mobman.robots.franka_tiago import FrankaTiago
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.spatial import Spatial
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate

PERIOD = 0.01

SAME = 1e-6
"""[m/s], [rad/s]: what the solution may differ by from that of a dense solver."""

SLOPE = 1e-8
"""Of central differences: a step of 1e-5, squared, times third derivatives of up to
10; and rounding over the step."""

ROBOTS = {"planar": Planar(shoulder_ahead=0.2), "spatial": Spatial(shoulder_aside=0.2)}
ARMS = {name: robot.arm() for name, robot in ROBOTS.items()}
LIMITS = {name: RobotModel(robot).joint_limits for name, robot in ROBOTS.items()}
QPS = {name: QpDecomposer(Qp(), ARMS[name], LIMITS[name], PERIOD) for name in ROBOTS}
BLOCKS = {f"qp, {name}": block for name, block in QPS.items()}
BLOCKS |= {
    f"diff_ik, {name}": DiffIkDecomposer(DiffIk(), RobotSetup.of(robot, PERIOD))
    for name, robot in (ROBOTS | {"franka_tiago": FrankaTiago()}).items()
}
every_block = pytest.mark.parametrize("name", BLOCKS)

NEAR = (0.6, 0.2, -0.2)
"""Within reach of every arm: l [m], psi [rad], z [m]."""


def arm_of(name):
    return (ROBOTS | {"franka_tiago": FrankaTiago()})[name.split(", ")[-1]].arm()


def inputs_of(name, command=(0.1, 0.1, 0.05), hand=NEAR):
    """Returns inputs of a block, the workspace that of the joints."""
    arm = arm_of(name)
    q = np.array(arm.inverse(hand))
    return {
        "ee_command": np.array(command),
        "ee_cylindrical": np.array(arm.ee_cylindrical(q)),
        "arm_position": q,
        "base_command_smoothed": np.zeros(2),
        "base_estimate": np.zeros(3),
    }


def moving(block, fed, step, inputs):
    """Returns a context in which `block` has put out a command for some periods."""
    context = fed(block, **inputs)
    for _ in range(15):
        step(block, context)
    return context


def put_out(found):
    """Returns all that a block puts out but its status (7,)."""
    names = ("base_command", "base_contribution", "arm_command")
    return np.concatenate([found[name] for name in names])


def program_of(name, command, hand, params=None):
    arm = ARMS[name]
    q = np.array(arm.inverse(hand))
    params = params or Qp()
    return decomposition_qp(
        arm, LIMITS[name], params, PERIOD, command, arm.ee_cylindrical(q), q
    )[0]


def dense(qp):
    """Returns the solution by an active-set solver that shares no code with OSQP."""
    return solve_qp(qp.P, qp.q, lb=qp.lb, ub=qp.ub, solver="daqp")


# The program.


def hand_in_world(name, u, time):
    """Returns where the hand is when base and joints go by `u` for a time."""
    arm = ARMS[name]
    q = np.array(arm.inverse(NEAR))
    m = len(u) - 2
    q[:m] += time * u[2:]
    l, psi, z = arm.ee_cylindrical(q)
    theta = time * u[1]
    # On an arc, or straight on.
    x = time * u[0] * math.cos(theta / 2) * np.sinc(theta / 2 / math.pi)
    y = time * u[0] * math.sin(theta / 2) * np.sinc(theta / 2 / math.pi)
    d, e, _ = arm.p_BS
    c, s = math.cos(theta), math.sin(theta)
    return np.array(
        [
            x + d * c - e * s + l * math.cos(theta + psi),
            y + d * s + e * c + l * math.sin(theta + psi),
            z,
        ]
    )


@pytest.mark.parametrize("name", ROBOTS)
def test_cost_is_that_of_the_hands_true_velocity(name):
    command, damping = np.array([0.2, -0.3, 0.1]), 0.03
    qp = program_of(name, command, NEAR, Qp(damping=damping))
    l, psi, _ = NEAR
    c, s = math.cos(psi), math.sin(psi)
    rows = 2 if name == "planar" else 3
    wanted = np.array([command[0], l * command[1], command[2]])[:rows]
    rng = np.random.default_rng(0)
    for u in rng.uniform(-1, 1, (5, len(qp.q))):
        h = 1e-5
        v = (hand_in_world(name, u, h) - hand_in_world(name, u, -h)) / (2 * h)
        v = np.array([c * v[0] + s * v[1], c * v[1] - s * v[0], v[2]])[:rows]
        expected = 0.5 * np.sum((v - wanted) ** 2) + damping * u @ u
        found = 0.5 * u @ qp.P @ u + qp.q @ u + 0.5 * wanted @ wanted
        assert found == pytest.approx(expected, rel=0, abs=SLOPE)


def test_solution_of_a_bent_elbow_is_that_worked_out_by_hand():
    # l = sqrt 2 and psi = 0, so that J J^T = [[1.5, 0.5], [0.5, 4.5]], and with
    # 2 lambda = 0.02 added, u = J^T y where y = (0.3 * 4.52, -0.3 * 0.5) / 6.6204.
    arm = Planar().arm()
    q = np.array([math.pi / 4, -math.pi / 2])
    limits = RobotModel(Planar()).joint_limits
    block = QpDecomposer(Qp(damping=0.01), arm, limits, PERIOD)
    u, _ = block.rates(np.array([0.3, 0, 0]), arm.ee_cylindrical(q), q, np.zeros(4))
    expected = [0.2048215, -0.0320422, -0.0320422, 0.1288095]
    np.testing.assert_allclose(u, expected, rtol=0, atol=SAME)


@pytest.mark.parametrize("name", ROBOTS)
def test_steps_and_joints_keep_to_their_bounds(name):
    params = Qp(max_step=0.002)
    far = program_of(name, (0.4, 0.4, 0.4), (0.6, 0.2, 0.0), params)
    np.testing.assert_array_equal(far.ub, np.full(len(far.q), 0.2))
    np.testing.assert_array_equal(far.lb, -far.ub)
    u = QpProgram(len(far.q), params).solve(far)
    assert np.abs(u).max() == pytest.approx(0.2, abs=SAME)
    # Half a step from the stretched elbow, which is the end of its range.
    elbow = BASE_AND_ELBOW[name]
    arm = ARMS[name]
    q = np.array(arm.inverse(NEAR))
    q[elbow - 2] = LIMITS[name].upper[elbow - 2] - 0.001
    near, _ = decomposition_qp(
        arm, LIMITS[name], params, PERIOD, (0.4, 0, 0), arm.ee_cylindrical(q), q
    )
    assert near.ub[elbow] == pytest.approx(0.1)


BASE_AND_ELBOW = {"planar": 3, "spatial": 4}
"""Where the elbow's rate stands in u."""


def test_joints_keep_to_their_rates():
    slow = JointLimits([-4.0] * 2, [4.0] * 2, [0.03, 0.05])
    arm = ARMS["planar"]
    q = np.array(arm.inverse(NEAR))
    qp, _ = decomposition_qp(
        arm, slow, Qp(), PERIOD, (0, 0, 0), arm.ee_cylindrical(q), q
    )
    np.testing.assert_allclose(qp.ub, [1.0, 1.0, 0.03, 0.05])


@functools.cache
def run_of(name, max_step, iterations):
    scenario = load_scenario(name)
    params = Qp(max_step=max_step, iterations=iterations)
    arm, limits = scenario.robot.arm(), RobotModel(scenario.robot).joint_limits
    return simulate(
        scenario, decomposer=lambda: QpDecomposer(params, arm, limits, PERIOD)
    )


def recorded(name, max_step):
    """Returns programs of 1,000 states of a recorded minute, equally spaced."""
    run = run_of(name, max_step, 4000)
    arm, limits = run.scenario.robot.arm(), RobotModel(run.scenario.robot).joint_limits
    params = Qp(max_step=max_step)
    signals = ("ee_command", "ee_cylindrical", "arm_position")
    return [
        decomposition_qp(
            arm, limits, params, PERIOD, *(run.log[signal][k] for signal in signals)
        )[0]
        for k in np.linspace(0, len(run.log["time"]) - 1, 1000).astype(int)
    ]


@pytest.mark.parametrize("name", ["kwon_arbitrary", "kwon_spatial"])
@pytest.mark.parametrize("max_step", [0.01, 0.001])
def test_solution_is_that_of_a_dense_solver_on_recorded_states(name, max_step):
    qps = recorded(name, max_step)
    program = QpProgram(len(qps[0].q), Qp())
    bound = 0
    for qp in qps:
        expected = dense(qp)
        np.testing.assert_allclose(program.solve(qp), expected, rtol=0, atol=SAME)
        bound += bool(((expected <= qp.lb) | (expected >= qp.ub)).any())
    assert len(qps) == 1000
    if max_step < 0.01:  # Less than what is commanded: most optima are at a bound.
        assert bound > 500


@pytest.mark.parametrize("damping", [1e-3, 0.1, 0.9])
def test_solution_is_within_its_tolerance_whatever_the_damping(damping):
    params = Qp(damping=damping)
    rng = np.random.default_rng(1)
    program = QpProgram(4, params)
    for _ in range(100):
        hand = (rng.uniform(0.2, 1.9), rng.uniform(-1.5, 1.5), 0.0)
        qp = program_of("planar", rng.uniform(-0.4, 0.4, 3), hand, params)
        np.testing.assert_allclose(program.solve(qp), dense(qp), rtol=0, atol=SAME)


def test_solution_is_the_same_from_wherever_it_starts():
    qp = program_of("planar", (0.3, 0.2, 0.0), NEAR)
    program = QpProgram(4, Qp())
    alone = program.solve(qp)
    for guess in (dense(qp), np.full(4, 5.0)):
        np.testing.assert_allclose(program.solve(qp, guess), alone, rtol=0, atol=SAME)


def test_kept_program_forgets_the_one_before():
    first = program_of("spatial", (0.3, 0.2, 0.1), NEAR)
    second = program_of("spatial", (-0.1, 0.4, 0.0), (1.2, -0.5, 0.3))
    kept = QpProgram(5, Qp())
    for qp in (first, second, first):
        np.testing.assert_array_equal(kept.solve(qp), QpProgram(5, Qp()).solve(qp))


@pytest.mark.parametrize("wrong", ["order", "P", "q", "lb"])
def test_program_without_a_solution_has_none(capfd, wrong):
    qp = program_of("planar", (0.3, 0.2, 0.0), NEAR)
    if wrong == "order":
        qp = qp._replace(lb=qp.ub + 1e-9)
    else:
        qp = qp._replace(**{wrong: np.full_like(getattr(qp, wrong), math.nan)})
    assert QpProgram(4, Qp()).solve(qp) is None
    assert capfd.readouterr() == ("", "")


def test_solver_that_runs_out_of_iterations_has_found_nothing():
    qp = program_of("planar", (0.3, 0.2, 0.0), NEAR)
    assert QpProgram(4, Qp(iterations=1)).solve(qp) is None


def test_solver_says_nothing(capfd):
    # Neither where a bound is active nor where none is.
    for v_c in (0.0, 0.01, 0.3, 40.0):
        qp = program_of("planar", (v_c, 0.0, 0.0), NEAR)
        assert QpProgram(4, Qp()).solve(qp) is not None
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("params", "says"),
    [
        ({"damping": 0.0}, "damping: 0.0 is not valid; must be within [1e-06, 1]"),
        ({"damping": 1.0}, "damping: 1.0 is not valid; must be below 1"),
        (
            {"max_step": -0.01},
            "max_step: -0.01 is not valid; must be within [1e-06, 1] m or rad",
        ),
        ({"tolerance": math.nan}, "tolerance: nan is not valid; must be a finite"),
        ({"iterations": 0}, "iterations: 0 is not valid; must be within [1, 100000]"),
        ({"stop_time": -1.0}, "stop_time: -1.0 is not valid; must be within [0, 60] s"),
    ],
)
def test_parameters_that_are_none_are_refused(params, says):
    with pytest.raises(ParameterError) as refusal:
        QpDecomposer(
            dc.replace(Qp(), **params), ARMS["planar"], LIMITS["planar"], PERIOD
        )
    assert says in str(refusal.value)


def test_arm_without_closed_form_is_refused():
    robot = FrankaTiago()
    says = r"^robot: 'JacobianArm' is not valid; must have an arm with a Jacobian"
    with pytest.raises(ParameterError, match=says):
        QpDecomposer(Qp(), robot.arm(), RobotModel(robot).joint_limits, PERIOD)


# The block of every solver.


@every_block
def test_ports_are_those_of_any_other_decomposer_and_a_status(name):
    def ports(block):
        given = map(block.get_input_port, range(block.num_input_ports()))
        made = map(block.get_output_port, range(block.num_output_ports()))
        return [
            [(port.get_name(), port.size()) for port in side] for side in (given, made)
        ]

    block = BLOCKS[name]
    inputs, made = ports(
        BlendingDecomposer(Blending(), num_joints=arm_of(name).num_joints)
    )
    assert ports(block) == [inputs, [*made, ("decomposer_status", 1)]]


@every_block
@pytest.mark.parametrize("told", ["base_command_smoothed", "base_estimate"])
def test_what_the_base_does_needs_not_what_it_is_sent(name, told):
    block = BLOCKS[name]
    sent = block.GetInputPort(told).get_index()
    for output in ("base_command", "base_contribution"):
        index = block.GetOutputPort(output).get_index()
        assert not block.HasDirectFeedthrough(sent, index)


@every_block
def test_base_and_arm_make_the_command_once_they_have_gathered_way(
    fed, outputs, step, name
):
    block, arm = BLOCKS[name], arm_of(name)
    command = np.array([0.1, 0.1, 0.05 if arm.num_joints > 2 else 0.0])
    inputs = inputs_of(name, command)
    found = outputs(block, moving(block, fed, step, inputs))
    assert found["decomposer_status"] == DecomposerStatus.OK
    total = found["arm_command"] + np.append(found["base_contribution"], 0.0)
    # What the damping costs the QP, which at such a reach is a tenth of it.
    np.testing.assert_allclose(total, command, rtol=0, atol=0.01)
    carried = base_induced_rates(
        inputs["ee_cylindrical"], *found["base_command"], arm.p_BS
    )
    np.testing.assert_array_equal(found["base_contribution"], carried)


@pytest.mark.parametrize("name", ROBOTS)
def test_arm_command_is_what_the_solved_joint_rates_make(fed, outputs, name):
    block, arm = QPS[name], ARMS[name]
    inputs = inputs_of(name)
    found = outputs(block, fed(block, **inputs))
    q = inputs["arm_position"]
    u, _ = block.rates(*list(inputs.values())[:3], np.zeros(block.largest.size))
    h = 1e-5
    rates = np.zeros(arm.num_joints)
    rates[: len(u) - 2] = u[2:]
    after, before = (np.array(arm.ee_cylindrical(q + d * rates)) for d in (h, -h))
    expected = (after - before) / (2 * h)
    np.testing.assert_allclose(found["arm_command"], expected, rtol=0, atol=SLOPE)


@every_block
def test_each_tick_is_solved_once(fed, outputs, monkeypatch, name):
    block = BLOCKS[name]
    solve, times = block.rates, []
    monkeypatch.setattr(block, "rates", lambda *x: times.append(1) or solve(*x))
    context = fed(block, **inputs_of(name))
    outputs(block, context)
    block.EvalUniquePeriodicDiscreteUpdate(context)
    assert len(times) == 1


@every_block
@pytest.mark.parametrize("wrong", [math.nan, math.inf, 1e200])
@pytest.mark.parametrize("port", ["ee_command", "ee_cylindrical", "arm_position"])
def test_input_that_is_no_number_ends_in_a_bounded_stop(
    fed, outputs, step, capfd, name, port, wrong
):
    block = BLOCKS[name]
    context = moving(block, fed, step, inputs_of(name))
    value = inputs_of(name)[port]
    value[-1] = wrong
    block.GetInputPort(port).FixValue(context, value)
    check_bounded_stop(block, context, outputs, step)
    # And goes on when it is a number again.
    block.GetInputPort(port).FixValue(context, inputs_of(name)[port])
    assert outputs(block, context)["decomposer_status"] == DecomposerStatus.OK
    assert capfd.readouterr() == ("", "")


@every_block
def test_joint_far_out_of_its_range_ends_in_a_bounded_stop(
    fed, outputs, step, capfd, name
):
    # There is no rate that takes it back within a period.
    block = BLOCKS[name]
    context = moving(block, fed, step, inputs_of(name))
    q = inputs_of(name)["arm_position"]
    q[1] = block.limits.upper[1] + 0.2
    block.GetInputPort("arm_position").FixValue(context, q)
    check_bounded_stop(block, context, outputs, step)
    assert capfd.readouterr() == ("", "")


def test_solver_that_runs_out_of_iterations_ends_in_a_bounded_stop(fed, outputs, step):
    name = "qp, planar"
    hasty = QpDecomposer(Qp(iterations=1), ARMS["planar"], LIMITS["planar"], PERIOD)
    context = moving(BLOCKS[name], fed, step, inputs_of(name))
    state = context.get_discrete_state_vector().value()
    context = fed(hasty, state, **inputs_of(name, (-0.3, 0.4, 0.0)))
    check_bounded_stop(hasty, context, outputs, step)


def check_bounded_stop(block, context, outputs, step):
    """Checks that what was put out goes down to rest, and keeps its direction."""
    state = context.get_discrete_state_vector().value()
    before = np.concatenate([state[:2], state[-5:]])
    assert np.linalg.norm(before) > 0.1
    least = np.linalg.norm(before)
    for _ in range(math.ceil(block.params.stop_time / PERIOD)):
        found = outputs(block, context)
        assert found["decomposer_status"] == DecomposerStatus.UNSOLVED
        now = put_out(found)
        size = np.linalg.norm(now)
        assert size < least or size == 0
        np.testing.assert_allclose(
            now * np.linalg.norm(before), before * size, rtol=0, atol=1e-12
        )
        least = size
        step(block, context)
    rest = outputs(block, context)
    np.testing.assert_allclose(put_out(rest), np.zeros(7), rtol=0, atol=1e-15)
    assert rest["decomposer_status"] == DecomposerStatus.UNSOLVED


@given(
    rates=st.lists(st.floats(-1, 1), min_size=1, max_size=4),
    share=st.floats(0.01, 1.5),
)
def test_stop_takes_no_longer_than_that_of_the_largest_rates(rates, share):
    rates = np.array(rates)
    largest = np.ones(len(rates))
    for _ in range(math.ceil(1 / share) + 1):  # One more for rounding.
        factor = braking_factor(rates, largest, share)
        assert 0 <= factor <= 1
        assert np.max(np.abs(rates - factor * rates)) <= share + 1e-12
        rates = factor * rates
    np.testing.assert_array_equal(rates, np.zeros(len(rates)))


@every_block
def test_two_contexts_do_not_disturb_each_other(fed, outputs, step, name):
    # They share the program.
    block = BLOCKS[name]

    def trace(command):
        context = fed(block, **inputs_of(name, command))
        while True:
            yield outputs(block, context)
            step(block, context)

    commands = [(0.1, 0.1, 0.05), (-0.2, 0.0, 0.1)]
    alone = [[next(run) for _ in range(5)] for run in [trace(c) for c in commands]]
    for tick, found in enumerate(
        zip(*[trace(c) for c in commands], strict=True), start=0
    ):
        for which in (0, 1):
            for port, value in alone[which][tick].items():
                np.testing.assert_array_equal(found[which][port], value)
        if tick == 4:
            break


# In the loop.


def test_hand_follows_within_what_the_damping_costs():
    found = metrics(run_of("kwon_spatial", 0.01, 4000))
    assert found["died"] is None
    assert found["ee_error_max"] < 0.02
    assert found["lateral_slip_max"] < 1e-9


def test_arbitrary_minute_runs_through_a_stretched_arm_square_to_the_base():
    # There is nothing in eq. 17 that turns the base towards its hand: the arm
    # stretches, comes to stand square to the base, and what is commanded along it
    # neither can make.
    run = run_of("kwon_arbitrary", 0.01, 4000)
    assert run.died == ""
    assert np.count_nonzero(run.log["decomposer_status"]) == 0
    found = metrics(run)
    assert found["ee_error_rms"] < 0.08
    assert found["lateral_slip_max"] < 1e-9
    assert found["base_speed_max"] <= 1.0 + SAME
    first = run.log["time"] < 9
    assert np.abs(run.log["base_command"][first]).max() < 0.3


def test_unsolved_ticks_can_be_counted_in_the_log():
    run = run_of("kwon_1", 0.01, 1)
    assert run.died == ""
    status = run.log["decomposer_status"]
    commanded = run.log["ee_command"].any(1)
    assert (status[commanded] == DecomposerStatus.UNSOLVED).all()
    np.testing.assert_array_equal(run.log["base_command_smoothed"], 0.0)
