"""A robot brings what fits it; a scenario says what it wants otherwise."""

import dataclasses as dc

import numpy as np
import pytest
import yaml

from drake_mobman.base.smoother import Smoother
from drake_mobman.decomposers.blending import Blending
from drake_mobman.decomposers.exact import Exact
from drake_mobman.parameters import ParameterError, checked
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.defaults import default_of
from drake_mobman.robots.franka_tiago import FrankaTiago
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.servo import Servo
from drake_mobman.robots.spatial import Spatial
from drake_mobman.scenario import (
    AnyScenario,
    Guided,
    ScenarioError,
    Teleop,
    load_scenario,
)
from drake_mobman.schema import dump_typed, load_typed, load_yaml
from drake_mobman.simulation.simulate import simulate
from drake_mobman.teleop.scripted import Held, Script

ROBOTS = {
    "planar": Planar(),
    "short planar": Planar(upper_link=0.5, lower_link=0.6),
    "planar of unequal links": Planar(upper_link=1.4, lower_link=0.6),
    "spatial": Spatial(),
    "turning spatial": Spatial(orientation="turning"),
    "franka_tiago": FrankaTiago(),
    "higher franka_tiago": FrankaTiago(mount=0.3),
}


@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
@pytest.mark.parametrize("kind", [Teleop, Guided])
def test_all_that_a_robot_brings_fits_it(robot, kind):
    scenario = checked(kind(robot=robot, period=0.01))
    assert load_typed(AnyScenario, load_yaml(dump_typed(scenario))) == scenario


@pytest.mark.parametrize(
    ("robot", "fidelity"),
    [*((name, "kinematic") for name in ROBOTS), ("franka_tiago", "servo")],
)
@pytest.mark.parametrize("v_c", [0.2, -0.2])
def test_hand_goes_on_beyond_the_arms_reach_as_the_base_comes_along(
    robot, v_c, fidelity
):
    robot = ROBOTS[robot]
    far = 2.5  # More than any of the arms reaches [m].
    script = Script([Held(far / abs(v_c), v_c=v_c)])
    scenario = checked(Teleop(robot=robot, source=script, duration=far / abs(v_c)))
    if fidelity == "servo":
        scenario = dc.replace(scenario, fidelity=Servo(step=0.005))
    run = simulate(scenario)
    assert run.died == ""
    model = RobotModel(robot)

    def hand(k):
        q = [*run.log["base_pose"][k], *run.log["arm_position"][k]]
        model.set_state(q, np.zeros(len(q)))
        return model.p_W("tool")

    way = hand(-1) - hand(0)
    assert way[0] == pytest.approx(np.sign(v_c) * far, abs=0.02)
    assert np.abs(way[1:]).max() < 0.01
    limits = scenario.workspace
    reach = run.log["ee_cylindrical"][:, 0]
    assert limits.l_min - 0.01 < reach.min() <= reach.max() < limits.l_max + 0.01


def mine(tmp_path, text):
    """A scenario of somebody's own, written by hand."""
    file = tmp_path / "mine.yaml"
    file.write_text(text)
    return str(file)


def test_from_yaml_by_override_and_from_python_it_is_the_same(tmp_path):
    by_python = Teleop(robot=FrankaTiago())
    by_file = load_scenario(mine(tmp_path, "robot: !FrankaTiago {}"))
    by_override = load_scenario(mine(tmp_path, ""), ["robot=frankatiago"])
    assert by_file == by_override == by_python
    assert by_python.workspace == default_of(FrankaTiago(), type(by_python.workspace))
    assert by_python.start.l < 0.8
    assert isinstance(by_python.smoother, Smoother)


def test_robot_of_another_size_is_fitted_by_override(tmp_path):
    overrides = ["robot.upper_link=0.5", "robot.lower_link=0.5"]
    scenario = load_scenario(mine(tmp_path, ""), overrides)
    assert scenario == Teleop(robot=Planar(upper_link=0.5, lower_link=0.5))
    assert (scenario.workspace.l_min, scenario.workspace.l_max) == (0.2, 0.8)
    assert scenario.start.l == 0.5


def test_what_is_said_lies_over_what_the_robot_brings(tmp_path):
    text = "{robot: !FrankaTiago {}, workspace: {l_max: 0.65}, decomposer: {alpha: 9}}"
    scenario = load_scenario(mine(tmp_path, text))
    plain = Teleop(robot=FrankaTiago())
    assert scenario.workspace == dc.replace(plain.workspace, l_max=0.65)
    assert scenario.decomposer == dc.replace(plain.decomposer, alpha=9.0)
    assert scenario == dc.replace(
        plain, workspace=scenario.workspace, decomposer=scenario.decomposer
    )


def test_members_of_unions_and_lists_are_the_robots_own_too(tmp_path):
    text = """
    robot: !FrankaTiago {}
    decomposer: !Blending {beta: 9}
    alternatives: [!Exact {phi_min: 0.1}, !VelocityField {b_d: 0.31}, !DiffIk {}]
    """
    scenario = load_scenario(mine(tmp_path, text))
    robot = FrankaTiago()
    exact, field, _ = scenario.alternatives
    assert scenario.decomposer == dc.replace(default_of(robot, Blending), beta=9.0)
    assert scenario.decomposer.alpha != Blending().alpha
    assert exact == dc.replace(default_of(robot, Exact), phi_min=0.1)
    assert exact.alpha != Exact().alpha
    assert field == dc.replace(default_of(robot, type(field)), b_d=0.31)


def test_dumped_scenario_says_all_of_it(tmp_path):
    scenario = load_scenario(mine(tmp_path, "robot: !FrankaTiago {}"))
    said = yaml.load(dump_typed(scenario).replace("!", "#"), yaml.SafeLoader)
    assert said["workspace"] == dc.asdict(scenario.workspace)
    assert said["start"] == dc.asdict(scenario.start)
    assert said["smoother"] == dc.asdict(scenario.smoother)
    assert said["guard"] == dc.asdict(scenario.guard)


@pytest.mark.parametrize(
    ("overrides", "says"),
    [
        (
            ["workspace.l_max=1.6"],
            "workspace.l_max: 1.6 is not valid; out of reach; th",
        ),
        (
            ["workspace.l_min=0.1"],
            "workspace.l_min: 0.1 is not valid; out of reach; th",
        ),
        (
            ["workspace.psi_max=5"],
            "workspace.psi_max: 5.0 is not valid; out of reach; ",
        ),
        (["start.l=1"], "start: "),
        (
            ["smoother.max_speed=1.5"],
            "smoother.max_speed: 1.5 is not valid; must be at",
        ),
        (
            ["smoother.max_yaw_acceleration=3"],
            "must be at most 2.0944, which is what t",
        ),
        (
            ["decomposer=!DiffIk {max_speed: 2}"],
            "decomposer.max_speed: 2.0 is not valid; must be at most 1, which is what",
        ),
        (
            [
                "alternatives=[!Switching {}, !DiffIk {max_speed: 2}]",
                "decomposer=exact",
            ],
            "alternatives[1].max_speed: 2.0 is not valid; must be at most 1, which is",
        ),
        (
            ["decomposer=!VelocityField {b_d: 0.6}"],
            "decomposer.b_d: 0.6 is not valid; ",
        ),
    ],
)
def test_what_cannot_fit_the_robot_is_refused_in_one_line(tmp_path, overrides, says):
    with pytest.raises(ScenarioError) as refusal:
        load_scenario(mine(tmp_path, "robot: !FrankaTiago {}"), overrides)
    assert says in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_workspace_that_takes_a_joint_too_far_is_refused(tmp_path):
    with pytest.raises(
        ScenarioError, match=r"workspace\.psi_max: .*joint shoulder with"
    ):
        load_scenario(mine(tmp_path, ""), ["workspace.psi_max=4.5"])


def test_parameters_of_another_robot_are_refused_from_python_too():
    planar = Teleop()
    with pytest.raises(ParameterError, match=r"^(start|workspace)"):
        checked(dc.replace(planar, robot=FrankaTiago()))
    start = default_of(FrankaTiago(), type(planar.start))
    with pytest.raises(ParameterError, match=r"^workspace\.l_max: 1\.6 is not valid"):
        checked(dc.replace(planar, robot=FrankaTiago(), start=start))


@pytest.mark.parametrize("robot", ["{upper_link: -1}", "{lower_link: 0}", "{x: 1}"])
def test_robot_that_is_none_is_refused_by_its_own_key(tmp_path, robot):
    with pytest.raises(ScenarioError, match=r"mine\.yaml: robot\.(upper|lower|x)"):
        load_scenario(mine(tmp_path, f"robot: !Planar {robot}"))
