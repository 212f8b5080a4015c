"""The whole loop: every scenario with either decomposer, against the paper."""

import functools

import numpy as np
import pytest
from drake_mobman.diagrams.teleop import make_teleop_diagram
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import LeafSystem

from drake_mobman import signals
from drake_mobman.analysis.metrics import metrics
from drake_mobman.analysis.motion import ee_motion
from drake_mobman.decomposers.decomposer import declare_decomposer_ports
from drake_mobman.robot_model import RobotModel
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.log import read_log
from drake_mobman.simulation.simulate import simulate

DECOMPOSERS = ("blending", "switching")
SCENARIOS = [f"kwon_{name}" for name in (1, 2, 3, 4, "arbitrary", "dither", "spatial")]
EVERY_RUN = [(name, kind) for name in SCENARIOS for kind in DECOMPOSERS]
ROUNDING = 4 * np.finfo(float).eps  # Of a sum of two commands below 1.


@functools.cache
def run_of(name, decomposer="blending"):
    return simulate(load_scenario(name, [f"decomposer={decomposer}"]))


@functools.cache
def metrics_of(name, decomposer="blending"):
    return metrics(run_of(name, decomposer))


@pytest.mark.parametrize(("name", "decomposer"), EVERY_RUN)
def test_same_scenario_gives_the_same_log_bit_for_bit(name, decomposer):
    log = run_of(name, decomposer).log
    again = simulate(load_scenario(name, [f"decomposer={decomposer}"])).log
    assert log.keys() == again.keys()
    for signal, values in log.items():
        assert values.tobytes() == again[signal].tobytes(), signal


@pytest.mark.parametrize(("name", "decomposer"), EVERY_RUN)
def test_every_signal_of_the_contract_is_logged(name, decomposer):
    run = run_of(name, decomposer)
    n = run.scenario.robot.arm().num_joints
    samples = round(run.scenario.duration / run.scenario.period) + 1
    sizes = {
        "ee_command": 3,
        "ee_cylindrical": 3,
        "p_BT": 3,
        "base_command": 2,
        "base_command_smoothed": 2,
        "arm_command": 3,
        "arm_velocity_command": n,
        "arm_position": n,
        "arm_velocity": n,
        "base_pose": 3,
        "source.ee_command": 3,
    }
    assert run.died == ""
    assert run.log["time"].shape == (samples,)
    for signal, size in sizes.items():
        assert run.log[signal].shape == (samples, size), signal


@pytest.mark.parametrize(("name", "decomposer"), EVERY_RUN)
def test_base_and_arm_sum_to_the_command(name, decomposer):
    log = run_of(name, decomposer).log
    total = log["base_contribution"] + log["arm_command"][:, :2]
    np.testing.assert_allclose(total, log["ee_command"][:, :2], rtol=0, atol=ROUNDING)
    np.testing.assert_array_equal(log["arm_command"][:, 2], log["ee_command"][:, 2])


@pytest.mark.parametrize(("name", "decomposer"), EVERY_RUN)
def test_base_never_slides_sideways(name, decomposer):
    assert metrics_of(name, decomposer)["lateral_slip_max"] < 1e-9


@pytest.mark.parametrize(("name", "decomposer"), EVERY_RUN)
def test_commands_within_range_reach_the_decomposer_untouched(name, decomposer):
    log = run_of(name, decomposer).log
    assert log["ee_command"].tobytes() == log["source.ee_command"].tobytes()
    assert not log["guard_status"].any()


@pytest.mark.parametrize(("name", "decomposer"), EVERY_RUN)
def test_smoother_passes_commands_as_they_are_by_default(name, decomposer):
    log = run_of(name, decomposer).log
    assert log["base_command_smoothed"].tobytes() == log["base_command"].tobytes()


# Ends of table 2's runs, worked out from the law alone: the arm's coordinate x obeys
# x' = c (1 - mu(x)), and for the blended share that has the closed form
# exp(2 alpha (x - limit)) / (2 alpha) + (x - limit) = c t + constant.
def blended_end(start, command, limit, time, sharpness=21.0):
    direction = np.sign(command)

    def covered(x):
        beyond = direction * (x - limit)
        return np.exp(2 * sharpness * beyond) / (2 * sharpness) + beyond

    goal = covered(start) + abs(command) * time
    low, high = sorted((start, limit + direction * 1.0))
    for _ in range(200):
        middle = (low + high) / 2
        if (covered(middle) < goal) == (direction > 0):
            low = middle
        else:
            high = middle
    return middle


@pytest.mark.parametrize(
    ("name", "coordinate", "start", "command", "limit"),
    [
        ("kwon_1", 0, 0.0, 0.35, 1.6),
        ("kwon_2", 0, 1.8, -0.35, 0.4),
        ("kwon_3", 1, -0.85, 0.35, 0.7),
        ("kwon_4", 1, 0.85, -0.35, -0.7),
    ],
)
def test_runs_of_table_2_end_where_the_law_ends(
    name, coordinate, start, command, limit
):
    end = run_of(name).log["ee_cylindrical"][-1, coordinate]
    euler_step = abs(command) * 0.01  # What an Euler step can be off by, at most.
    assert end == pytest.approx(
        blended_end(start, command, limit, 14.0), abs=euler_step
    )
    switched = run_of(name, "switching").log["ee_cylindrical"][-1, coordinate]
    assert switched == pytest.approx(limit, abs=euler_step)


def test_scenario_1_ends_at_a_reach_of_1717_mm():
    assert run_of("kwon_1").log["ee_cylindrical"][-1, 0] == pytest.approx(
        1.717, abs=5e-4
    )


def test_hand_goes_as_far_as_it_is_told_straight_ahead():
    log = run_of("kwon_1").log
    hand = log["base_pose"][-1, 0] + log["ee_cylindrical"][-1, 0]
    kappa_loss = 14 * 0.35 * np.exp(-((np.pi / 2 / 0.5) ** 2))
    assert hand == pytest.approx(14 * 0.35, abs=kappa_loss + 1e-9)


def test_hand_turns_as_far_as_it_is_told_also_at_zero_reach():
    log = run_of("kwon_3").log
    turned = log["base_pose"][-1, 2] + log["ee_cylindrical"][-1, 1] - -0.85
    assert turned == pytest.approx(14 * 0.35, abs=1e-9)
    assert np.abs(log["ee_cylindrical"][:, 0]).max() < 1e-12


@pytest.mark.parametrize("name", ["kwon_arbitrary", "kwon_spatial"])
@pytest.mark.parametrize(
    ("coordinate", "limit"), [(0, 0.4), (0, 1.6), (1, -0.7), (1, 0.7)]
)
def test_arbitrary_input_crosses_every_limit_in_both_directions(
    name, coordinate, limit
):
    beyond = run_of(name).log["ee_cylindrical"][:, coordinate] > limit
    steps = np.diff(beyond.astype(int))
    assert (steps == 1).any()
    assert (steps == -1).any()


def test_base_drives_while_the_arm_stands_askew_in_arbitrary_input():
    log = run_of("kwon_arbitrary").log
    askew = np.abs(log["ee_cylindrical"][:, 1]) > 0.5
    assert np.abs(log["base_command_smoothed"][askew, 0]).max() > 0.2


def test_blended_law_lets_the_hand_slip_and_the_metrics_show_it():
    # Law 5: what is left uncompensated is v_b sin(psi) across the reach, and
    # v_b cos(psi) short of v_bm by kappa along it.
    run = run_of("kwon_arbitrary")
    psi, v_b = run.log["ee_cylindrical"][:, 1], run.log["base_command_smoothed"][:, 0]
    along = v_b * np.cos(psi) - run.log["base_contribution"][:, 0]
    across = -v_b * np.sin(psi)
    slip = np.hypot(along, across)
    numbers = metrics_of("kwon_arbitrary")
    assert numbers["ee_error_max"] == pytest.approx(slip.max(), abs=1e-9)
    assert numbers["ee_error_rms"] == pytest.approx(np.sqrt(np.mean(slip**2)), abs=1e-9)
    assert numbers["ee_error_rms"] > 0.05


def test_vertical_command_raises_the_hand_as_told():
    log = run_of("kwon_spatial").log
    led = 0.01 * np.cumsum(log["ee_command"][:-1, 2])
    np.testing.assert_allclose(log["ee_cylindrical"][1:, 2], led, atol=1e-9)
    assert np.ptp(led) > 0.3


def test_switching_chatters_at_a_dithering_command_and_blending_does_not():
    cycles = 45
    switched = metrics_of("kwon_dither", "switching")["authority_flips"]["linear"]
    blended = metrics_of("kwon_dither", "blending")["authority_flips"]["linear"]
    assert switched > cycles
    assert blended == 0


def test_switching_throws_the_base_where_blending_leads_it():
    def largest_step(decomposer):
        v_b = run_of("kwon_dither", decomposer).log["base_command_smoothed"][:, 0]
        return np.abs(np.diff(v_b)).max()

    assert largest_step("switching") > 5 * largest_step("blending")


@pytest.mark.parametrize("name", SCENARIOS)
def test_hand_of_the_log_is_where_drakes_kinematics_puts_it(name):
    run = run_of(name)
    model = RobotModel(run.scenario.robot)
    motion = ee_motion(run)
    for k in range(0, len(run.log["time"]), 97):
        q = np.concatenate([run.log["base_pose"][k], run.log["arm_position"][k]])
        model.set_state(q, 0 * q)
        np.testing.assert_allclose(motion.position[k], model.p_W("tool")[:2], atol=1e-9)


def test_measured_velocity_tends_to_drakes_as_the_step_shrinks():
    def gap(period):
        overrides = [f"period={period}", "duration=20"]
        scenario = load_scenario("kwon_arbitrary", overrides)
        run = simulate(scenario)
        log, motion = run.log, ee_motion(run)
        model = RobotModel(scenario.robot)
        gaps = []
        for time in range(1, 20):
            k = round(time / period)
            forward, sideways, omega = log["base_velocity"][k]
            theta, axes = log["base_pose"][k, 2], motion.axes[k]
            x = forward * np.cos(theta) - sideways * np.sin(theta)
            y = forward * np.sin(theta) + sideways * np.cos(theta)
            q = np.concatenate([log["base_pose"][k], log["arm_position"][k]])
            model.set_state(q, np.array([x, y, omega, *log["arm_velocity"][k]]))
            v = model.v_W("tool")
            radial = v[0] * np.cos(axes) + v[1] * np.sin(axes)
            across = v[1] * np.cos(axes) - v[0] * np.sin(axes)
            gaps.append(np.hypot(*(motion.velocity[k] - (radial, across))))
        return max(gaps)

    coarse, fine = gap(0.01), gap(0.001)
    assert coarse < 2e-3
    assert fine < coarse / 5


def test_arm_command_inverted_by_rates_follows_the_one_by_positions():
    overrides = ["inverse=rates", "period=0.002", "compiled=true"]
    by_rates = simulate(load_scenario("kwon_arbitrary", overrides)).log
    by_positions = simulate(load_scenario("kwon_arbitrary", overrides[1:])).log
    gap = by_rates["ee_cylindrical"] - by_positions["ee_cylindrical"]
    assert np.abs(gap).max() < 5e-3


def test_program_can_feed_the_command_itself():
    scenario = load_scenario("kwon_1", ["source=external", "start.l=1.0"])
    diagram = make_teleop_diagram(scenario)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    command = diagram.GetInputPort(signals.EE_COMMAND)
    command.FixValue(context, [0.2, 0.0, 0.0])
    simulator.AdvanceTo(1.0)
    reach = diagram.GetOutputPort(signals.EE_CYLINDRICAL).Eval(context)[0]
    assert reach == pytest.approx(1.2, abs=1e-4)
    command.FixValue(context, [0.0, 0.0, 0.0])
    simulator.AdvanceTo(2.0)
    assert diagram.GetOutputPort(signals.EE_CYLINDRICAL).Eval(context)[0] == reach
    assert read_log(diagram, context)["time"][-1] == 2.0


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e300, 0.41])
def test_bad_command_ends_as_a_stop_of_the_whole_robot(bad):
    scenario = load_scenario("kwon_arbitrary", ["source=external", "start.l=1.6"])
    diagram = make_teleop_diagram(scenario)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    command = diagram.GetInputPort(signals.EE_COMMAND)
    command.FixValue(context, [0.3, 0.3, 0.0])
    simulator.AdvanceTo(1.0)
    assert (
        np.abs(diagram.GetOutputPort(signals.BASE_COMMAND_SMOOTHED).Eval(context)).max()
        > 0.1
    )
    command.FixValue(context, [0.3, bad, 0.0])
    simulator.AdvanceTo(1.0 + scenario.guard.stop_time + 2 * scenario.period)
    log = read_log(diagram, context)
    assert all(np.isfinite(values).all() for values in log.values())
    assert log["guard_status"][-1, 0] > 0
    assert not log["base_command_smoothed"][-1].any()
    assert not log["arm_velocity_command"][-1].any()


def test_state_gone_non_finite_keeps_the_log_so_far():
    class Failing(LeafSystem):
        def __init__(self):
            super().__init__()
            declare_decomposer_ports(self, 2, self._base, self._share, self._arm)

        def _base(self, context, output):
            late = context.get_time() > 2.0
            output.SetFromVector([np.nan if late else 0.1, 0.0])

        def _share(self, _context, output):
            output.SetFromVector([0.0, 0.0])

        def _arm(self, _context, output):
            output.SetFromVector([0.0, 0.0, 0.0])

    run = simulate(load_scenario("kwon_1"), decomposer=Failing)
    assert "died at t = 2.0" in run.died
    assert "not finite" in run.died
    assert run.log["time"][-1] == pytest.approx(2.0, abs=0.011)
    assert np.isfinite(run.log["base_pose"]).all()
    assert metrics(run)["died"] == run.died


def test_two_contexts_of_one_diagram_do_not_disturb_each_other():
    scenario = load_scenario("kwon_1")
    diagram = make_teleop_diagram(scenario, logged=False)
    first, second = Simulator(diagram), Simulator(diagram)
    first.AdvanceTo(8.0)
    port = diagram.GetOutputPort(signals.EE_CYLINDRICAL)
    assert port.Eval(second.get_context())[0] == pytest.approx(0.0, abs=1e-12)
    second.AdvanceTo(8.0)
    at_8 = port.Eval(second.get_context())
    np.testing.assert_array_equal(port.Eval(first.get_context()), at_8)
