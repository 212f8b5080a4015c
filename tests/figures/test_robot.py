"""A picture of a robot shows where its points, joints and limits are."""

import numpy as np
import pytest

from drake_mobman.figures.robot import draw_robot
from drake_mobman.robots import FrankaTiago, Spatial
from drake_mobman.robots.file import File
from drake_mobman.scenario_files import robot_paths


def legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def texts(axes):
    return {
        text.get_text(): np.array(text.xy) for text in axes.texts if hasattr(text, "xy")
    }


@pytest.mark.parametrize("robot", [FrankaTiago(mount_ahead=0.1), Spatial()])
def test_points_are_where_the_model_has_them(robot):
    side, top = draw_robot(robot, "name").axes
    d, e, l_0 = robot.arm().p_BS
    assert texts(side)["S"] == pytest.approx([d, l_0], abs=1e-9)
    assert texts(top)["S"] == pytest.approx([d, e], abs=1e-9)
    start = {type(x).__name__: x for x in robot.defaults()}["Start"]
    assert texts(side)["E"] == pytest.approx([d + start.l, l_0 + start.z], abs=1e-6)
    assert texts(top)["E"] == pytest.approx([d + start.l, e], abs=1e-6)


def test_every_joint_has_its_axis():
    side, _ = draw_robot(FrankaTiago(), "name").axes
    axes = [x for x in side.lines if x.get_label() == "joints' axes"]
    assert len(axes) == 7
    assert {"reach, $r_f$", "body, $b_d$"} <= set(legend(side.figure))


def test_wheels_and_casters_are_where_the_robot_rolls_on_them():
    _, top = draw_robot(File(str(robot_paths()["fetch"])), "fetch").axes
    wheels = [x.get_xydata() for x in top.lines if x.get_gid() == "wheel"]
    middles = np.array(sorted(tuple(x.mean(axis=0)) for x in wheels))
    assert middles == pytest.approx(np.array([[0, -0.18738], [0, 0.18738]]))
    assert [np.ptp(x[:, 0]) for x in wheels] == pytest.approx([2 * 0.0605] * 2)
    assert sum(x.get_gid() == "caster" for x in top.lines) == 4
