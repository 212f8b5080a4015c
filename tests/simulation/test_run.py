"""A run's signals are arrays by name; what is wrong with a name is told."""

import numpy as np
import pytest

from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.run import Run
from drake_mobman.simulation.simulate import simulate


@pytest.fixture(scope="module")
def run() -> Run:
    return simulate(load_scenario("kwon_1", ["duration=0.5"]))


def test_signals_are_arrays_over_the_times_of_the_samples(run):
    assert run.time == pytest.approx(0.01 * np.arange(51))
    assert run["ee_command"].shape == (51, 3)
    assert run["arm_position"].shape == (51, 2)
    assert "time" not in run.signals
    for name in run.signals:
        assert run[name] is run.log[name]
        assert len(run[name]) == len(run.time)


@pytest.mark.parametrize("name", ["ee_comand", "time", ""])
def test_a_name_that_was_not_logged_is_answered_with_those_that_were(run, name):
    with pytest.raises(KeyError, match=f"no signal '{name}'; valid names are") as error:
        run[name]
    for valid in run.signals:
        assert valid in str(error.value)


def test_robot_is_parsed_once_for_a_run_and_its_parts(run):
    model = run.model
    assert run.model is model
    part = run.first(10)
    assert part.model is model
    assert len(part.time) == len(part["ee_command"]) == 10
    assert part.scenario is run.scenario
    assert run.with_log(part.log).model is model
    assert len(run.time) == 51
