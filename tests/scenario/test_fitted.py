"""Scenarios fitted to a robot run on it, and reach what they are to show."""

import dataclasses as dc

import numpy as np
import pytest

from drake_mobman.base.velocity_field import field_velocity
from drake_mobman.guidance.guiding_hand import peak_speed
from drake_mobman.parameters import checked
from drake_mobman.robots import FrankaTiago, Kinematic, Spatial
from drake_mobman.scenario import Guided, Teleop, load_scenario
from drake_mobman.scenario.changes import dump_changes
from drake_mobman.scenario.fitted import fitted_guided, fitted_teleop
from drake_mobman.simulation.simulate import simulate

LARGE = Spatial(upper_link=2.0, lower_link=1.8, shoulder_height=1.0)
"""An arm of five times the Franka's length."""


def test_stick_leads_through_the_workspace_and_the_base_both_ways():
    fitted = fitted_teleop(LARGE)
    scenario = dc.replace(fitted, fidelity=Kinematic(), compiled=True)
    run = simulate(scenario)
    assert not run.died
    l, _, z = run["ee_cylindrical"].T
    limits = scenario.workspace
    room = 0.03 * (limits.l_max - limits.l_min)
    assert l.max() > limits.l_max - room
    assert l.min() < limits.l_min + room
    assert np.ptp(z) > 0.05
    v, omega = run["base_command_smoothed"].T
    out, back = 0.9 * max(x.v_c for x in scenario.source.segments), -0.1
    assert v.max() > out
    assert v.min() < back
    assert omega.max() > 0.1
    assert omega.min() < -0.1


@pytest.mark.parametrize("robot", [FrankaTiago(), LARGE], ids=["franka", "large"])
@pytest.mark.parametrize("fitted", [fitted_teleop, fitted_guided])
def test_short_file_is_the_same_scenario(robot, fitted, tmp_path):
    scenario = checked(fitted(robot))
    file = tmp_path / "fitted.yaml"
    file.write_text(dump_changes(scenario))
    loaded = load_scenario(file)
    assert dc.replace(loaded, name="") == scenario
    assert len(file.read_text().splitlines()) < 60


def test_short_file_holds_only_what_is_not_the_robots_own():
    own = Teleop(robot=FrankaTiago())
    text = dump_changes(dc.replace(own, duration=3.0))
    assert [line.split(":")[0] for line in text.splitlines()] == [
        "!Teleop",
        "duration",
        "robot",
    ]


def test_hand_goes_all_ways_within_the_bases_speed():
    scenario = fitted_guided(FrankaTiago())
    path = np.array([[w.time, w.x, w.y, w.z] for w in scenario.hand.path])
    steps = np.diff(path, axis=0)
    speeds = np.linalg.norm(steps[:, 1:], axis=1) / steps[:, 0]
    assert speeds.max() <= 0.4 * scenario.smoother.max_speed + 1e-9
    assert steps[:, 1].max() > 1.0
    assert steps[:, 2].min() < -0.5
    assert (steps[:, 3].max() > 0.1) & (steps[:, 3].min() < -0.1)
    assert scenario.duration == path[-1, 0]


def test_hand_stays_above_the_floor():
    low = Spatial(upper_link=1.0, lower_link=1.0, shoulder_height=0.2)
    scenario = fitted_guided(low)
    assert min(point.z for point in scenario.hand.path) >= 0.1
    assert isinstance(scenario, Guided)


def test_hand_of_a_short_arm_is_no_faster_than_its_base_follows():
    """By the field itself, T at rest half into the forward zone."""
    short = Spatial(upper_link=0.25, lower_link=0.25, shoulder_height=0.5)
    scenario = fitted_guided(short)
    field, reach = scenario.field, short.reach()
    edge = reach.r_f - field.Delta_f / 2
    v, _ = field_velocity((reach.ahead + edge, reach.aside, reach.l_0), field, reach)
    assert peak_speed(scenario.hand) <= v * 1.001
    assert peak_speed(scenario.hand) < 0.5 * scenario.smoother.max_speed
