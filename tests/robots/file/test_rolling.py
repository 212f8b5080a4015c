"""A robot from a file on its own wheels: they roll ahead, and turn the base."""

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant

from drake_mobman.frames import body
from drake_mobman.parameters import ParameterError
from drake_mobman.robots.file import File

from .conftest import WHEEL, joint, link


def rolling(folder):
    """Returns the plant of the robot on its wheels, finalized, and its base."""
    plant = MultibodyPlant(0.002)
    base = File(str(folder.path / "small.robot.yaml")).add_rolling_to(plant)
    base.check()
    plant.Finalize()
    return plant, base


def with_four_wheels(folder, ahead=0.25):
    """Gives the robot two wheels on each side, apart along x."""
    more = [
        link(f"{name}_wheel", 1.0, WHEEL)
        + joint(name, "continuous", "chassis", f"{name}_wheel", f"{x} {y} 0.1").replace(
            'xyz="0 0 1"', 'xyz="0 1 0"'
        )
        for name, x, y in (("rear_left", -ahead, 0.2), ("rear_right", -ahead, -0.2))
    ]
    for y in ("0.2", "-0.2"):
        folder.change("small.urdf", f'xyz="0 {y} 0.1"', f'xyz="{ahead} {y} 0.1"')
    folder.change("small.urdf", "</robot>", "".join([*more, "</robot>"]))
    wheels = "left: [left, rear_left], right: [right, rear_right]"
    folder.change("small.robot.yaml", "left: [left], right: [right]", wheels)


def test_base_is_free_and_only_wheels_and_arm_turn(folder):
    plant, base = rolling(folder)
    assert plant.num_velocities() == 6 + 2 + 6
    assert plant.num_actuators() == 2 + 6
    assert [x.name() for x in (*base.left, *base.right)] == ["left", "right"]
    assert base.wheel_radius == 0.1
    assert base.track == pytest.approx(0.4, abs=1e-12)


@pytest.mark.parametrize("axis", ["0 1 0", "0 -1 0"])
def test_wheels_that_turn_ahead_have_positive_rates(folder, axis):
    lines = (folder.path / "small.urdf").read_text().splitlines()
    turned = [
        x.replace('axis xyz="0 1 0"', f'axis xyz="{axis}"') if '"right"' in x else x
        for x in lines
    ]
    folder.write("small.urdf", "\n".join(turned))
    plant, base = rolling(folder)
    context = plant.CreateDefaultContext()
    v = np.zeros(plant.num_velocities())
    for wheel in (*base.left, *base.right):
        v[wheel.velocity_start()] = 1.0
    plant.SetVelocities(context, v)
    B = body(plant, "base").body_frame()
    for wheel in (*base.left, *base.right):
        turn = wheel.child_body().body_frame().CalcSpatialVelocity(context, B, B)
        np.testing.assert_allclose(turn.rotational(), [0, 1, 0], atol=1e-12)


def test_wheel_along_the_base_is_refused(folder):
    folder.change("small.urdf", 'xyz="0 1 0"/><limit', 'xyz="1 0 0"/><limit')
    with pytest.raises(ParameterError, match=r"base.wheels.left\[0\]: 'left' is not v"):
        rolling(folder)


def test_robot_without_wheels_is_refused(folder):
    wheels = "wheels: {left: [left], right: [right]}, wheel_radius: 0.1"
    folder.change("small.robot.yaml", wheels, "frame: chassis")
    with pytest.raises(ParameterError, match="fidelity: '!Wheels' is not valid"):
        rolling(folder)


@pytest.mark.parametrize("ahead", [0.1, 0.25])
def test_four_wheels_turn_the_base_slower_than_two(folder, ahead):
    with_four_wheels(folder, ahead)
    _, base = rolling(folder)
    alike = 0.4 + 4 * ahead**2 / 0.4
    assert 0.4 < base.track < alike
    known = File(str(folder.path / "small.robot.yaml")).resolved()
    assert known.track.value == base.track
    assert "scrub of 4 wheels 0.4 m apart" in known.track.source


def test_track_that_is_given_is_taken(folder):
    with_four_wheels(folder)
    folder.change("small.robot.yaml", "wheel_radius", "track: 0.9, wheel_radius")
    assert rolling(folder)[1].track == 0.9


def test_casters_are_what_touches_the_floor(folder):
    ball = '<collision><origin xyz="{} 0 0.02"/><geometry><sphere radius="0.02"/>'
    balls = "".join(ball.format(x) + "</geometry></collision>" for x in (0.15, -0.15))
    high = '<collision><origin xyz="0 0 0.3"/><geometry><box size="1 1 0.1"/>'
    at = '<link name="chassis">'
    folder.change("small.urdf", at, f"{at}{balls}{high}</geometry></collision>")
    found = [(c.x, c.y, c.radius) for c in rolling(folder)[1].casters]
    np.testing.assert_allclose(found, [(0.15, 0, 0.02), (-0.15, 0, 0.02)], atol=1e-9)


def test_casters_that_are_given_are_taken(folder):
    given = "casters: [{x: 0.1, y: 0.05, radius: 0.04}], wheel_radius"
    folder.change("small.robot.yaml", "wheel_radius", given)
    (caster,) = rolling(folder)[1].casters
    assert (caster.x, caster.y, caster.radius) == (0.1, 0.05, 0.04)


def test_base_without_any_stands_on_four_in_its_corners(folder):
    places = [(c.x, c.y) for c in rolling(folder)[1].casters]
    assert len(places) == 4
    np.testing.assert_allclose(np.mean(places, axis=0), [0, 0], atol=1e-12)
    radius = File(str(folder.path / "small.robot.yaml")).described().placement
    np.testing.assert_allclose(np.hypot(*np.transpose(places)), radius.body_radius[0])
