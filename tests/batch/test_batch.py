"""A batch logs what Drake's simulator logs."""

import numpy as np
import pytest

from drake_mobman.analysis.metrics import metrics
from drake_mobman.batch.simulate import check_batch, simulated_batch
from drake_mobman.scenario import ScenarioError, load_scenario
from drake_mobman.simulation.simulate import simulate

SAME = 1e-12

LOOPS = {
    "blending": ("kwon_arbitrary", ["duration=60"]),
    "exact": ("kwon_arbitrary", ["decomposer=!Exact {}", "duration=60"]),
    "switching": ("kwon_arbitrary", ["decomposer=!Switching {}", "duration=60"]),
    "field": ("kwon_arbitrary", ["decomposer=!VelocityField {}", "duration=20"]),
    "spatial": ("kwon_spatial", ["duration=20"]),
    "franka": ("kwon_franka", ["fidelity=!Kinematic {}", "duration=10"]),
}


def drawn(loop, seed, *more):
    name, overrides = LOOPS[loop]
    source = f"source=!RandomHeld {{seed: {seed}}}"
    return load_scenario(name, [*overrides, source, *more])


def assert_same(run, reference):
    assert {*run.signals} == {*reference.signals}
    assert not run.died
    np.testing.assert_array_equal(run.time, reference.time)
    for name in reference.signals:
        given = reference[name]
        np.testing.assert_allclose(run[name], given, rtol=0, atol=SAME, err_msg=name)


@pytest.mark.parametrize("loop", LOOPS)
def test_a_random_operator_makes_the_same_log_as_in_drake(loop):
    scenario = drawn(loop, 11)
    (run,) = simulated_batch([scenario])
    assert_same(run, simulate(scenario))


def test_the_scripts_of_the_package_make_the_same_log_as_in_drake():
    scenarios = [load_scenario(f"kwon_{i}") for i in (1, 2, 3, 4)]
    for scenario, run in zip(scenarios, simulated_batch(scenarios), strict=True):
        assert_same(run, simulate(scenario))


def test_runs_come_in_the_order_of_their_scenarios_whatever_their_laws():
    more = ["duration=1.005"]
    scenarios = [
        drawn(loop, seed, *more)
        for seed in range(6)
        for loop in ("exact", "blending", "switching")
    ]
    runs = [*simulated_batch(scenarios, threads=2)]
    assert [run.scenario for run in runs] == scenarios
    assert_same(runs[-1], simulate(scenarios[-1]))


def test_a_run_starts_where_its_scenario_starts():
    first, other = (
        drawn("exact", 1, "duration=2.0", *at)
        for at in ([], ["start.x=1.5", "start.theta=0.7", "start.l=0.7"])
    )
    runs = [*simulated_batch([first, other])]
    assert runs[1]["base_pose"][0].tolist() == [1.5, 0.0, 0.7]
    for run, scenario in zip(runs, (first, other), strict=True):
        assert_same(run, simulate(scenario))


def test_metrics_of_a_batch_are_those_of_drake():
    scenario = drawn("exact", 3)
    (run,) = simulated_batch([scenario])
    found, expected = metrics(run), metrics(simulate(scenario))
    for name in ("ee_error_rms", "base_jerk_rms", "manipulability_min"):
        assert found[name] == pytest.approx(expected[name], abs=1e-9)


def test_more_scenarios_than_memory_would_hold_are_taken_as_they_are_needed():
    taken = []

    def endless():
        for seed in range(10**9):
            taken.append(seed)
            yield drawn("exact", seed, "duration=0.1")

    runs = simulated_batch(endless(), threads=2)
    for _ in range(5):
        next(runs)
    runs.close()
    assert len(taken) < 20


@pytest.mark.parametrize(
    ("name", "overrides", "why"),
    [
        ("petric_guided", [], "!Guided is pulled by hand"),
        ("kwon_1", ["source=external"], "source !External has no script"),
        ("kwon_franka", [], "fidelity !Servo has masses"),
        ("kwon_1", ["decomposer=!Qp {}"], "decomposer takes no Expressions"),
    ],
)
def test_what_is_no_such_law_is_refused_with_the_reason(name, overrides, why):
    with pytest.raises(ScenarioError, match=why):
        [*simulated_batch([load_scenario(name, overrides)])]


def test_a_scenario_can_be_checked_before():
    check_batch(load_scenario("kwon_1"))
    with pytest.raises(ScenarioError, match="batch"):
        check_batch(load_scenario("kwon_franka"))
