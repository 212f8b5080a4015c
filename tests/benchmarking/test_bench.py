"""The benchmark times what it says, alike for all. What a clock says is not tested."""

import functools
import gc
import json
import re
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from typer.testing import CliRunner

from drake_mobman import signals
from drake_mobman.analysis.compare import decomposers_by_name
from drake_mobman.arm.limits import JointLimits
from drake_mobman.benchmarking import bench
from drake_mobman.benchmarking.case import BenchmarkCase, Block
from drake_mobman.benchmarking.cases import (
    BLOCK,
    COMPILED,
    LAW,
    NOTHING,
    REFERENCE,
    SOLVER,
    benchmark_cases,
)
from drake_mobman.benchmarking.control_tick import DIFF_IK, control_tick_cases
from drake_mobman.benchmarking.costs import tick_costs
from drake_mobman.benchmarking.optimization_case import Solution, Solver
from drake_mobman.benchmarking.programs import (
    DENSE_SOLVERS,
    DenseProgram,
    RebuiltProgram,
    installed_solvers,
)
from drake_mobman.benchmarking.real_time import (
    bare_plant,
    compiled_simulator,
    follow,
    real_time_factors,
    threading_ratios,
    wall_time,
)
from drake_mobman.benchmarking.tables import report
from drake_mobman.benchmarking.ticks import recorded_ticks
from drake_mobman.cli import app as cli
from drake_mobman.decomposers.optimization import OptimizationDecomposer
from drake_mobman.decomposers.qp import Qp, QpDecomposer
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.planar import Planar
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate

ROUNDING = 1e-12
"""What compiling may change [m/s], [rad/s]: the order of a few operations."""

OPTIMUM = 1e-4
"""How near dense solvers come to the optimum, at their own tolerances."""

PERIOD = 0.01


@pytest.fixture(scope="module")
def scenario():
    # Both limits are crossed outwards, and the stick turns back.
    return load_scenario("kwon_arbitrary", ["duration=16"])


@pytest.fixture(scope="module")
def run(scenario):
    return simulate(scenario)


@pytest.fixture(scope="module")
def ticks(run):
    return recorded_ticks(run)[::8]


def told(contender, ticks):
    """Returns what comes of each tick (N, size)."""
    found = []
    for tick in ticks:
        contender.prepare(tick)
        found.append(contender.act())
        contender.settle()
    return np.array(found)


def test_ticks_are_what_the_decomposer_was_told(run):
    ticks = recorded_ticks(run)
    assert len(ticks) == 1601
    for name in (
        "ee_command",
        "ee_cylindrical",
        "arm_position",
        "base_command_smoothed",
        "base_estimate",
    ):
        together = np.array([getattr(tick, name) for tick in ticks])
        assert np.array_equal(together, run.log[name])


def test_reference_does_at_each_level_what_it_did_in_the_run(scenario, run):
    entered, _ = benchmark_cases(scenario)
    sent = np.hstack([run.log[signals.BASE_COMMAND], run.log[signals.ARM_COMMAND]])
    assert np.ptp(sent, axis=0)[:4].min() > 0.1
    for level in (LAW, BLOCK, COMPILED):
        found = told(entered[level][REFERENCE], recorded_ticks(run))
        assert found == pytest.approx(sent, abs=ROUNDING)


def test_all_levels_of_a_decomposer_do_the_same(scenario, ticks):
    entered, _ = benchmark_cases(scenario)
    unlimited = entered[LAW].pop("exact, without limits")
    assert set(entered[LAW]) == set(entered[BLOCK]) - {NOTHING}
    free, limited = told(unlimited, ticks), told(entered[BLOCK]["exact"], ticks)
    assert (np.abs(limited[:, :2]) <= np.abs(free[:, :2]) + ROUNDING).all()
    alike = np.isclose(limited, free, rtol=0, atol=ROUNDING).all(axis=1)
    assert alike.mean() > 0.5
    for name, law in entered[LAW].items():
        by_law = told(law, ticks)
        by_block = told(entered[BLOCK][name], ticks)
        assert by_block == pytest.approx(by_law, abs=ROUNDING), name
        if name in entered[COMPILED]:
            by_compiled = told(entered[COMPILED][name], ticks)
            assert by_compiled == pytest.approx(by_law, abs=ROUNDING), name
        else:
            stays = entered[COMPILED][f"{name}, in Python"]
            assert stays is entered[BLOCK][name]


def test_every_decomposer_of_the_scenario_competes(scenario):
    entered, missing = benchmark_cases(scenario)
    names = {name.split(",")[0] for name in entered[BLOCK]}
    assert names == {*decomposers_by_name(), NOTHING}
    assert not [line for line in missing if "pip install" not in line]


def test_nothing_passes_its_inputs_on(scenario, ticks):
    entered, _ = benchmark_cases(scenario)
    assert entered[BLOCK][NOTHING] is entered[COMPILED][NOTHING]
    found = told(entered[BLOCK][NOTHING], ticks)
    expected = [[*tick.base_command_smoothed, *tick.ee_command] for tick in ticks]
    assert np.array_equal(found, expected)


class LeakyIntegrator(OptimizationDecomposer):
    """Rates that depend on those of the tick before."""

    def __init__(self):
        super().__init__(2, (0.0, 0.0, 0.0), np.ones(4), 0.2, PERIOD)

    def rates(self, command, workspace, q, last):  # noqa: ARG002
        if command[0] > 0.25:
            return None
        rates = 0.9 * np.asarray(last) + 0.1
        return rates, (rates[2], 0.0, 0.0)


def test_blocks_with_state_go_on_from_tick_to_tick(ticks):
    still = [tick._replace(ee_command=np.zeros(3)) for tick in ticks[:20]]
    geometric = 1 - 0.9 ** np.arange(1, 21)
    for contender in (Block(LeakyIntegrator()), Solution(LeakyIntegrator())):
        found = told(contender, still)
        for column in (0, 1, 2):
            assert found[:, column] == pytest.approx(geometric)


def qp_block(program=None):
    robot = Planar()
    limits: JointLimits = RobotModel(robot).joint_limits
    block = QpDecomposer(Qp(), robot.arm(), limits, PERIOD)
    if program:
        block.program = program
    return block


@pytest.mark.parametrize("solver", ["rebuilt", *DENSE_SOLVERS])
def test_all_solvers_find_the_same_optimum(ticks, solver):
    if solver == "rebuilt":
        program = RebuiltProgram(4, Qp())
    else:
        pytest.importorskip("qpsolvers")
        if solver not in installed_solvers():
            pytest.skip("not installed")
        program = DenseProgram(solver)
    for kind in (Solver, Solution):
        expected = told(kind(qp_block()), ticks)
        found = told(kind(qp_block(program)), ticks)
        assert np.ptp(expected) > 0.3
        assert found == pytest.approx(expected, abs=OPTIMUM)


# The loop about the clock, with a clock that goes by what is called.


class Clock:
    """Each reading is [s] what was spent; nothing is spent by itself."""

    now = 0.0

    def __call__(self):
        return self.now


class Spender(BenchmarkCase):
    """Takes a given time for a tick, and much before and after."""

    def __init__(self, clock, cost, found=0.0):
        self.clock, self.cost, self.found = clock, cost, found
        self.told = []

    def prepare(self, tick):
        self.clock.now += 100.0
        self.told.append(tick)

    def act(self):
        self.clock.now += self.cost(self.told[-1])
        return self.found

    def settle(self):
        self.clock.now += 100.0


@pytest.fixture
def clock():
    return Clock()


def test_costs_are_of_the_act_alone_and_ratios_are_by_turns(clock):
    # 1 us a tick, in the second turn 2 us, at the last tick 11 us; the other, thrice.
    cost = {0: 1e-6, 1: 1e-6, 2: 1e-6, 3: 2e-6, 4: 2e-6, 5: 11e-6}
    one = Spender(clock, cost.__getitem__)
    three = Spender(clock, lambda tick: 3 * cost[tick] + 6e-6 * (tick < 3))
    entered = {LAW: {REFERENCE: one, "other": three}}
    costs = tick_costs(entered, list(range(6)), turns=2, clock=clock)
    reference, other = costs[LAW][REFERENCE], costs[LAW]["other"]
    assert reference["mean_us"] == pytest.approx(3)
    assert reference["median_us"] == pytest.approx(1.5)
    assert reference["min_us"] == pytest.approx(1)
    assert reference["max_us"] == pytest.approx(11)
    # Between the largest two, 2 and 11, by 0.95 of the way.
    assert reference["p99_us"] == pytest.approx(2 + 0.95 * 9)
    assert set(reference["ratio"].values()) == {1.0}
    # Nine times in the first turn, thrice in the second.
    assert other["ratio"] == pytest.approx({"median": 6, "low": 4.5, "high": 7.5})


def test_everyone_gets_every_tick_once_and_the_first_of_a_turn_changes(clock):
    begun = []
    names = [REFERENCE, "b", "c"]
    entered = {LAW: {}, BLOCK: {}}
    for name in names:

        def spent(tick, name=name):
            begun.append((name, tick))
            return 1e-6

        entered[LAW][name] = Spender(clock, spent)
    entered[BLOCK] = entered[LAW]
    tick_costs(entered, list(range(7)), turns=3, clock=clock)
    warm_up, counted = begun[:21], begun[21:]
    assert {name for name, _ in warm_up} == set(names)
    # Two ticks to a turn; the odd one is left.
    for name in names:
        assert [tick for who, tick in counted if who == name] == [0, 1, 2, 3, 4, 5]
    assert [counted[i][0] for i in (0, 6, 12)] == [REFERENCE, "b", "c"]


def test_ticks_in_which_nothing_is_found_are_counted(clock):
    entered = {
        LAW: {
            REFERENCE: Spender(clock, lambda _: 1e-6),
            "lost": Spender(clock, lambda _: 1e-6, found=None),
        }
    }
    costs = tick_costs(entered, list(range(6)), turns=2, clock=clock)[LAW]
    assert (costs[REFERENCE]["unsolved"], costs["lost"]["unsolved"]) == (0, 6)


@pytest.mark.parametrize("enabled", [True, False])
def test_garbage_collection_is_as_it_was(clock, enabled):
    spender = Spender(clock, lambda _: failing())

    def failing():
        if len(spender.told) > 4:  # Three ticks to warm up.
            assert not gc.isenabled()
            raise ArithmeticError
        return 1e-6

    before = gc.isenabled()
    (gc.enable if enabled else gc.disable)()
    try:
        with pytest.raises(ArithmeticError):
            tick_costs({LAW: {REFERENCE: spender}}, [1, 2, 3], 3, clock)
        assert gc.isenabled() == enabled
    finally:
        (gc.enable if before else gc.disable)()


# Whole runs.


def test_bare_plant_stands_where_the_whole_one_does():
    scenario = load_scenario("petric_guided")
    whole, bare = compiled_simulator(scenario), bare_plant(scenario)
    whole.AdvanceTo(4.0)
    follow(bare, whole)
    plant = bare.get_system()
    got = plant.GetPositionsAndVelocities(bare.get_context())
    robot = whole.get_system().GetOutputPort
    pose, arm = (
        robot(name).Eval(whole.get_context())
        for name in (signals.BASE_POSE, signals.ARM_POSITION)
    )
    assert got[: 3 + len(arm)] == pytest.approx(np.concatenate([pose, arm]))
    assert np.abs(got[3 + len(arm) :]).max() > 0.01


def test_bare_robot_stands_on_its_wheels_and_is_driven_as_the_whole_one():
    scenario = load_scenario("kwon_franka", ["fidelity=!Wheels {}"])
    whole, bare = compiled_simulator(scenario), bare_plant(scenario)
    whole.AdvanceTo(3.0)
    follow(bare, whole)
    bare.AdvanceTo(0.2)
    plant = bare.get_system().GetSubsystemByName("plant")
    here = plant.GetMyContextFromRoot(bare.get_context())
    X_WB = plant.GetBodyByName("base").EvalPoseInWorld(here)
    assert X_WB.translation()[2] == pytest.approx(0.0, abs=1e-4)
    pose = whole.get_system().GetOutputPort(signals.BASE_POSE)
    x, y, _ = pose.Eval(whole.get_context())
    speed = np.hypot(*(X_WB.translation()[:2] - [x, y])) / 0.2
    velocity = whole.get_system().GetOutputPort(signals.BASE_VELOCITY)
    v, *_ = velocity.Eval(whole.get_context())
    assert v > 0.05
    assert speed == pytest.approx(v, rel=0.02)


def test_control_tick_does_what_the_run_did():
    scenario = load_scenario("kwon_franka", ["duration=3"])
    run = simulate(scenario)
    cases, ticks = control_tick_cases(scenario, run)
    base, arm = run[signals.BASE_COMMAND], run[signals.ARM_VELOCITY_COMMAND]
    sent = np.hstack([base, arm])
    assert np.abs(sent).max() > 0.1
    for name in ("exact, compiled", "exact, in Python"):
        assert told(cases[name], ticks) == pytest.approx(sent, abs=ROUNDING)
    for name in (DIFF_IK, "diffik, in Python"):
        other = told(cases[name], ticks)
        assert np.isfinite(other).all()
        assert np.abs(other - sent).max() > 0.01


def test_there_is_no_bare_plant_where_none_is_stepped(scenario):
    assert bare_plant(scenario) is None


def test_simulators_advance_by_the_stretch_alone_and_in_threads(scenario):
    pair = [compiled_simulator(scenario) for _ in range(2)]
    wall_time(pair, 0.5)
    seen = []
    for simulator in pair:
        simulator.set_monitor(lambda _: seen.append(threading.get_ident()))
    with ThreadPoolExecutor(2) as pool:
        assert wall_time(pair, 0.25, pool) > 0
    assert [s.get_context().get_time() for s in pair] == [0.75, 0.75]
    assert threading.get_ident() not in seen


class HalfASecond:
    """A clock by which everything takes half a second; it notes what that was."""

    def __init__(self):
        self.timed = []

    def __call__(self, simulators, stretch, pool=None):
        for simulator in simulators:
            simulator.AdvanceTo(simulator.get_context().get_time() + stretch)
        self.timed.append((len(simulators), stretch, pool is not None))
        return 0.5


def test_factors_are_simulated_over_wall_time_within_the_scenario():
    clock = HalfASecond()
    scenario = load_scenario("petric_teleop", ["duration=0.9"])
    named = real_time_factors({"teleop": scenario}, 2, stretch=2.0, timed=clock)
    factors = named["teleop"]
    # Three stretches, the first to warm up, fill the scenario.
    assert {name: len(taken) for name, taken in factors.items()} == {
        "python": 2,
        "compiled": 2,
        "bare": 2,
    }
    for taken in factors.values():
        assert taken == pytest.approx([0.3 / 0.5] * 2)
    assert clock.timed == [(1, pytest.approx(0.3), False)] * 9


def test_threading_ratio_is_of_both_at_once_to_one_alone(scenario):
    clock = HalfASecond()
    ratios = threading_ratios(scenario, turns=2, stretch=0.1, timed=clock)
    assert ratios == [1.0, 1.0]
    alone, both = (1, 0.1, False), (2, 0.1, True)
    assert clock.timed == [alone, alone, both] * 3


# The command.


def run_bench(*arguments):
    return CliRunner().invoke(cli.app, ["bench", *map(str, arguments)])


FOUND = []
"""What the bench has found of the robot with masses, which takes long to compile."""


@pytest.fixture
def few(monkeypatch):
    """Has two scenarios, run for a moment, stand for all; masses are timed once."""
    names = ("kwon_1", "petric_behind")
    brief = functools.partial(bench.bench, names=names, stretch=0.02)
    monkeypatch.setattr(bench, "bench", brief)
    monkeypatch.setattr(bench, "_LONG", 1.0)
    of_franka = bench._of_franka

    def once(*arguments):
        if not FOUND:
            FOUND.append(of_franka(*arguments))
        return FOUND[0]

    monkeypatch.setattr(bench, "_of_franka", once)


def tables_of(text):
    """Returns Markdown's tables as lists of rows of cells, by the heading above."""
    tables, heading = {}, None
    for line in text.splitlines():
        if line.startswith("### "):
            heading = line[4:]
        elif line.startswith("|"):
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            tables.setdefault(heading, []).append(cells)
    return tables


@pytest.mark.usefixtures("few")
def test_bench_prints_tables_and_writes_their_numbers(tmp_path):
    file = tmp_path / "new" / "bench.json"
    sets = ["--turns", 2, "--set", "duration=0.5"]
    result = run_bench("kwon_3", "--out", file, *sets)
    assert result.exit_code == 0
    assert result.stderr == ""
    content = json.loads(file.read_text())
    assert [p.name for p in tmp_path.rglob("*")] == ["new", "bench.json"]
    assert content["scenario"] == "kwon_3"
    assert content["ticks"] == 51
    assert {"date", "processor", "cores", "python", "drake", "numpy"} <= set(
        content["ran_on"]
    )
    tables = tables_of(result.stdout)
    assert next(iter(tables)) == "Bare law"
    for table, level in zip(tables.values(), (LAW, BLOCK, COMPILED), strict=False):
        heading, rule, *rows = table
        assert heading[1:] == ["mean", "median", "p99", "max", "min", "ratio"]
        assert all(re.fullmatch("-+:?", cell) for cell in rule)
        costs = content["costs"][level]
        assert [row[0] for row in rows] == list(costs)
        for name, *numbers, ratio in rows:
            for column, number in zip(heading[1:], numbers, strict=False):
                expected = costs[name][f"{column}_us"]
                assert float(number) == pytest.approx(expected, rel=5e-3)
            assert float(ratio.split()[0]) > 0
            cost = costs[name]
            assert cost["min_us"] <= cost["median_us"] <= cost["p99_us"]
            assert cost["p99_us"] <= cost["max_us"]
    heading, _, *rows = tables["Control tick"]
    costs = content["control_tick"]["costs"]
    assert [row[0] for row in rows] == list(costs)
    for name, *_, median, _, _, _, _ in rows:
        assert float(median) == pytest.approx(costs[name]["median_us"], rel=5e-3)
    heading, _, *rows = tables["On wheels"]
    assert heading[1:] == ["!Servo", "!Wheels", "wheels / servo"]
    assert [row[0] for row in rows] == ["Python blocks", "compiled", "bare plant"]
    for row, ratio in zip(
        rows, content["wheels"]["wheels_to_servo"].values(), strict=True
    ):
        assert float(row[3].split()[0]) == pytest.approx(ratio["median"], rel=5e-3)
    heading, _, *rows = tables["Real-time factor"]
    assert [row[0] for row in rows] == ["kwon_1", "petric_behind"]
    bare = heading.index("bare plant")
    assert rows[0][bare] == "-"
    assert float(rows[1][bare]) > 0
    assert "in two threads take" in result.stdout


@pytest.mark.usefixtures("few")
def test_without_the_solvers_the_rest_runs_and_says_how_to_get_them(monkeypatch):
    monkeypatch.setitem(sys.modules, "qpsolvers", None)
    assert installed_solvers() == []
    result = run_bench("--turns", 1, "--set", "duration=0.2")
    assert result.exit_code == 0
    for solver in DENSE_SOLVERS:
        assert f"Left out: {solver}, which pip install 'drake_mobman[bench]'" in (
            result.stdout
        )
    assert "blending" in result.stdout


def test_what_cannot_be_built_is_left_out_and_listed():
    # An arm too short for a velocity field.
    short = ["start.l=0.45", "robot={upper_link: 0.2, lower_link: 0.25}"]
    scenario = load_scenario("kwon_1", short)
    entered, missing = benchmark_cases(scenario)
    (line,) = [line for line in missing if "velocityfield" in line]
    assert line.startswith("with decomposer=velocityfield: decomposer.Delta_r: 0.1 is")
    assert "velocityfield" not in entered[BLOCK]
    assert "blending" in entered[BLOCK]


def test_report_tells_of_ticks_that_found_nothing():
    cost = dict.fromkeys(["mean_us", "median_us", "p99_us", "max_us", "min_us"], 1.0)
    cost |= {"ratio": {"median": 1.0, "low": 1.0, "high": 1.0}, "unsolved": 7}
    speeds = dict.fromkeys(["python", "compiled", "bare"], 7.0)
    content = {
        "ran_on": {"date": "2026-01-01", "processor": "P", "cores": 2, "python": "3"},
        "core_share": 0.5,
        "ticks": 9,
        "turns": 1,
        "costs": {LAW: {"diffik": cost}, SOLVER: {}},
        "missing": [],
        "real_time_factors": {},
        "control_tick": {"scenario": "kwon_franka", "ticks": 9, "costs": {}},
        "wheels": {
            "scenario": "kwon_franka",
            "step": 0.002,
            "factors": {"Servo": speeds, "Wheels": speeds},
            "wheels_to_servo": dict.fromkeys(speeds, cost["ratio"]),
        },
        "two_threads": cost["ratio"],
    }
    text = report(content, "kwon_1")
    assert "2026-01-01, P, 2 cores; python 3." in text
    assert "50 % of a core" in text
    assert "As law, diffik found no solution in 7 of the ticks." in text
    assert "solution alone" not in text


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["nosuch"], "no such scenario"),
        (["petric_guided"], "petric_guided: !Guided has no command to decompose"),
        (["--set", "source=external"], "is fed by a program"),
        (["--set", "duration=0"], "must be at least period"),
        (["--out", "bench.txt"], "must end in .json"),
    ],
)
def test_bad_input_is_refused_before_anything_runs(
    tmp_path, monkeypatch, arguments, says
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("drake_mobman.simulation.simulate.simulate", None)
    result = run_bench(*arguments)
    assert result.exit_code == 2
    assert result.stdout == ""
    (line,) = result.stderr.splitlines()
    assert says in line
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_cannot_be_written_is_refused_before_anything_runs(
    tmp_path, monkeypatch
):
    monkeypatch.setattr("drake_mobman.simulation.simulate.simulate", None)
    (tmp_path / "x.json").mkdir()
    (tmp_path / "file").touch()
    for file, says in (("x.json", "it is a folder"), ("file/b.json", "cannot be")):
        result = run_bench("--out", tmp_path / file)
        assert result.exit_code == 2
        assert says in result.stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "x.json"]


@pytest.mark.parametrize(("error", "status"), [(KeyboardInterrupt, 130), (OSError, 1)])
def test_a_bench_that_ends_early_leaves_the_old_file(
    tmp_path, monkeypatch, error, status
):
    def end(*_):
        raise error("early")

    monkeypatch.setattr(bench, "bench", end)
    file = tmp_path / "bench.json"
    file.write_text("old")
    result = run_bench("kwon_1", "--set", "duration=0.2", "--out", file)
    assert result.exit_code == status
    assert len(result.stderr.splitlines()) == 1
    assert [p.read_text() for p in tmp_path.iterdir()] == ["old"]


def test_bench_imports_no_solver_of_the_extra_by_itself():
    code = (
        "import sys, drake_mobman.benchmarking.bench\n"
        "heavy = {'qpsolvers', 'daqp', 'proxsuite', 'quadprog'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
