"""A robot on wheels tips over where its zero-moment point leaves what it stands on."""

import re

import numpy as np
import pytest

from drake_mobman.analysis.metrics import metrics
from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import BaseLimits
from drake_mobman.robot_model.tipping import SupportPolygon, zero_moment_point
from drake_mobman.robots.franka_tiago import FrankaTiago
from drake_mobman.robots.wheels import Wheels
from drake_mobman.robots.wheels.tip_limits import Footing, upright_limits
from drake_mobman.scenario import ScenarioError, load_scenario
from drake_mobman.simulation.simulate import simulate

G = 9.81

ON_WHEELS = "fidelity=wheels"

REACHING = ["robot.mount_ahead=0.26", ON_WHEELS, "duration=5"]
"""The arm stands so far ahead that the robot does not stand with it stretched out."""

UNLIMITED = "fidelity.tip_margin=-1"


def test_polygon_is_the_hull_and_tells_how_far_inside_a_point_is():
    square = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 1)]
    polygon = SupportPolygon.of(square)
    points = np.array([[1.0, 1.0], [0.5, 1.0], [2.0, 1.0], [3.0, 1.0]])
    np.testing.assert_allclose(polygon.inside(points), [1, 0.5, 0, -1], atol=1e-9)


def test_at_rest_it_is_below_the_centre_of_mass_and_braking_moves_it_ahead():
    at_rest = zero_moment_point((0.1, -0.05, 0.5), (0.0, 0.0, 0.0), (0.0, 0.0, -G))
    assert at_rest == pytest.approx((0.1, -0.05))
    braking = zero_moment_point((0.1, 0.0, 0.5), (-1.0, 0.0, 0.0), (0.0, 0.0, -G))
    assert braking == pytest.approx((0.1 + 0.5 / G, 0.0))
    # Uphill, gravity pulls back.
    uphill = zero_moment_point((0.1, 0.0, 0.5), (0.0, 0.0, 0.0), (-1.0, 0.0, -G))
    assert uphill == pytest.approx((0.1 - 0.5 / G, 0.0))


def test_the_floors_force_is_the_weight_below_the_centre_of_mass(bench):
    robot = bench()
    robot.advance(10)
    x, y, up = robot.read("floor_force")
    context = robot.plant_context
    x_B, y_B, theta = robot.read("base_pose")
    gap = robot.plant.CalcCenterOfMassPositionInWorld(context)[:2] - [x_B, y_B]
    c, s = np.cos(theta), np.sin(theta)
    expected = c * gap[0] + s * gap[1], c * gap[1] - s * gap[0]
    assert (x, y) == pytest.approx(expected, abs=1e-5)
    assert up == pytest.approx(G * robot.plant.CalcTotalMass(context), rel=1e-5)


def test_while_the_base_brakes_it_moves_as_the_law_says(bench):
    robot = bench()
    robot.ramp(0.4, 0.0)
    for k in range(20):  # At 1 m/s^2.
        robot.command("base_command_smoothed", [0.4 - 0.01 * (k + 1), 0.0])
        robot.advance()
    p_WC = robot.plant.CalcCenterOfMassPositionInWorld(robot.plant_context)
    x_B, y_B, theta = robot.read("base_pose")
    ahead = np.cos(theta) * (p_WC[0] - x_B) + np.sin(theta) * (p_WC[1] - y_B)
    x, _ = zero_moment_point((ahead, 0.0, p_WC[2]), (-1.0, 0.0, 0.0), (0.0, 0.0, -G))
    # But for the wheels, which turn slower, and for the last tick's unrest.
    assert robot.read("floor_force")[0] == pytest.approx(x, abs=5e-3)
    assert x > ahead + 0.02


def test_polygon_is_that_of_wheels_and_casters():
    polygon = Wheels().support(FrankaTiago())
    on_edge = np.array([[0.0, 0.2022], [0.0, -0.2022], [0.1695, 0.0], [-0.1735, 0.05]])
    np.testing.assert_allclose(polygon.inside(on_edge), 0.0, atol=1e-9)
    assert polygon.inside(np.zeros((1, 2)))[0] > 0.1


def test_a_good_run_keeps_away_from_the_edge():
    run = simulate(load_scenario("kwon_franka", [ON_WHEELS, "duration=2"]))
    assert metrics(run)["tip_margin_min"] > 0.05


def test_without_the_limit_a_reach_too_far_lifts_the_wheels_and_ends_the_run():
    run = simulate(load_scenario("kwon_franka", [*REACHING, UNLIMITED]))
    assert "the robot tips over: its base rolls by" in run.died
    assert run.died.startswith("died at t = ")
    assert np.isfinite(run["base_pose"]).all()
    assert metrics(run)["tip_margin_min"] == pytest.approx(0.0, abs=5e-3)


NAMED = re.compile(r"([a-z_.]+): [\d.]+ is not valid; must be at most ([\d.]+) ")
"""A limit in a message, and the largest value that lets the robot stand."""


def refused(given):
    """Returns the limit that is refused, and the largest value that is not."""
    with pytest.raises(ScenarioError) as refusal:
        load_scenario("kwon_franka", given)
    assert str(refusal.value).endswith("or the robot tips over on its wheels")
    key, value = NAMED.search(str(refusal.value)).groups()
    return key, float(value)


def test_with_the_limits_that_are_named_it_stands():
    key, furthest = refused(REACHING)
    assert key == "workspace.l_max"
    # At the very edge it could not accelerate at all.
    nearer = [*REACHING, "start.l=0.5", f"workspace.l_max={furthest - 0.05}"]
    key, fastest = refused(nearer)
    assert key == "smoother.max_acceleration"
    assert 0.1 < fastest < 1.0
    gentle = [*nearer, f"smoother.max_acceleration={0.8 * fastest}"]
    key, turning = refused(gentle)
    assert key == "smoother.max_yaw_rate"
    scenario = load_scenario("kwon_franka", [*gentle, f"{key}={0.9 * turning}"])
    run = simulate(scenario)
    assert not run.died
    assert metrics(run)["tip_margin_min"] > 0.0


def test_a_start_at_which_it_does_not_stand_is_refused(bench):
    far = FrankaTiago(mount_ahead=0.5)
    with pytest.raises(ParameterError) as refusal:
        bench(robot=far)
    assert "the robot tips over" in str(refusal.value)
    assert str(refusal.value).endswith("must let the robot stand on its wheels")


def test_off_a_high_step_it_falls_and_dies_of_that_not_of_nan():
    step = "fidelity.floor.patches=[{x_min: 0.25, height: -0.15}]"
    run = simulate(load_scenario("kwon_franka", [ON_WHEELS, "duration=6", step]))
    assert "the robot tips over" in run.died
    assert all(np.isfinite(run[name]).all() for name in run.signals)


def test_limits_of_a_tall_robot_are_narrowed_until_it_stands_and_no_further():
    polygon = SupportPolygon.of([(x, y) for x in (0.2, -0.2) for y in (0.2, -0.2)])
    footing = Footing(polygon, [0.0, 0.0, -9.81], grip=8.8, margin=0.01)
    limits = BaseLimits(0.5, 4.0, 1.0, 4.0)
    centres = [(0.05, 0.0, 1.0)]
    narrow = upright_limits(centres, limits, footing)
    # The zero-moment point is h a / g from the centre; turning adds omega^2 x, x = d.
    share = narrow.max_acceleration / 4.0
    ahead = 0.05 + 1.0 / 9.81 * (4.0 * share + share**2 * 0.05)
    assert ahead == pytest.approx(0.19, abs=1e-3)
    assert narrow == BaseLimits(0.5, 4 * share, share, 4 * share)


@pytest.mark.parametrize("x", [0.0, 0.3])
def test_limits_by_which_it_stands_or_that_do_not_help_are_kept(x):
    polygon = SupportPolygon.of([(x, y) for x in (0.2, -0.2) for y in (0.2, -0.2)])
    footing = Footing(polygon, [0.0, 0.0, -9.81], grip=8.8, margin=0.01)
    limits = BaseLimits(0.5, 1.0, 1.0, 1.0)
    assert upright_limits([(x, 0.0, 0.2)], limits, footing) == limits
