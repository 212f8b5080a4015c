"""Metrics: each is a class in a list, with units, and applies by what the log holds."""

import math
from typing import ClassVar

import numpy as np
import pytest

from drake_mobman import signals
from drake_mobman.analysis import metrics as package
from drake_mobman.analysis.metrics import METRICS, Metric, metrics
from drake_mobman.analysis.metrics.tally import Tally
from drake_mobman.analysis.metrics.workspace_excess import excess
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.run import Run
from drake_mobman.simulation.simulate import simulate
from drake_mobman.simulation.tick_times import tick_times

COMMANDED, GUIDED = "kwon_1", "petric_hold"
GROUPS = {"end effector", "base", "arm", "hand", "time"}


@pytest.fixture(scope="module")
def runs() -> dict[str, Run]:
    return {
        name: simulate(load_scenario(name, ["duration=0.3"]))
        for name in (COMMANDED, GUIDED)
    }


def flat(numbers, prefix=""):
    for key, value in numbers.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def test_every_number_has_a_unit_and_a_group(runs):
    for run in runs.values():
        run.tick_times = np.array([1e-4])
        names = {name for name, _ in flat(metrics(run))}
        names = {name for name in names if not name.startswith(("died", "versions"))}
        units = {
            name
            for metric in METRICS
            if metric.applies(run.log)
            for name in metric.units
        }
        assert names == units
    assert {metric.group for metric in METRICS} == GROUPS


def test_no_name_is_given_to_two_metrics():
    names = [name for metric in METRICS for name in metric.units]
    assert len(names) == len(set(names))


def test_what_is_measured_goes_by_what_was_logged(runs):
    commanded, guided = (metrics(runs[name]) for name in (COMMANDED, GUIDED))
    assert {"ee_error_rms", "authority_flips", "commands_refused"} <= commanded.keys()
    assert not {"hand_force_max", "hand_error_max"} & commanded.keys()
    assert {"hand_force_max", "hand_error_max"} <= guided.keys()
    assert not {"ee_error_rms", "workspace_excess_max"} & guided.keys()
    assert {"base_speed_max", "joint_margin_min"} <= commanded.keys() & guided.keys()


class YawSum(Metric):
    """The sum of all yaw rates sent: a metric of a user's own."""

    group = "base"
    units: ClassVar = {"yaw_sum": "rad/s"}
    needs = (signals.BASE_COMMAND_SMOOTHED,)

    def __init__(self):
        self.total = 0.0

    def take(self, window):
        self.total += float(window.fresh(signals.BASE_COMMAND_SMOOTHED)[:, 1].sum())

    def numbers(self):
        return {"yaw_sum": self.total}


def test_a_new_metric_is_a_class_and_a_line(runs, monkeypatch):
    monkeypatch.setattr(package, "METRICS", [*METRICS, YawSum])
    run = runs[GUIDED]
    expected = run[signals.BASE_COMMAND_SMOOTHED][:, 1].sum()
    assert metrics(run)["yaw_sum"] == pytest.approx(expected)
    blind = run.with_log({"time": run.time} | {n: run[n] for n in run.signals})
    monkeypatch.setattr(YawSum, "needs", ("nothing_logged",))
    assert "yaw_sum" not in metrics(blind)


def test_ticks_are_timed_by_who_wants_them():
    run = simulate(load_scenario(COMMANDED, ["duration=0.3"]))
    assert len(run.tick_times) == 0
    assert metrics(run)["step_time_us"] is None
    run.tick_times = tick_times(run.scenario)
    assert len(run.tick_times) == 30
    spread = metrics(run)["step_time_us"]
    assert 0 < spread["median"] <= spread["p99"] <= spread["max"]
    assert spread["mean"] == pytest.approx(1e6 * run.tick_times.mean())


def test_tally_of_pieces_is_that_of_the_whole():
    x = np.array([[3.0, -4.0], [0.0, 1.0], [2.0, -2.0]])
    tally = Tally()
    assert (tally.largest, tally.rms) == (None, None)
    for piece in (x[:0], x[:1], x[1:]):
        tally.take(piece)
    assert tally.largest == 4.0
    assert tally.rms == pytest.approx(math.sqrt(34 / 6))


@pytest.mark.parametrize(
    ("x", "expected"), [([0.5, 0.6], 0.0), ([0.5, 1.7], 0.1), ([0.1, 1.7], 0.3)]
)
def test_excess_is_how_far_beyond_a_limit(x, expected):
    assert excess(np.array(x), 0.4, 1.6) == pytest.approx(expected)
