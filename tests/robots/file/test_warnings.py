"""What a robot's model lacks is said in one line each."""

import pytest

from drake_mobman.robots.file import File
from drake_mobman.robots.file.warnings import warnings


@pytest.fixture
def lines(folder):
    """Returns the warnings on the small robot."""

    def found():
        robot = File(str(folder.path / "small.robot.yaml"))
        return warnings(robot.described(), robot.resolved())

    return found


LIMITS = "accelerat"


def test_a_model_has_no_accelerations_and_that_is_said_once(lines):
    told = [line for line in lines() if LIMITS in line]
    assert told == [
        "limits: the model's acceleration limit is missing for j1, j2, j3, j4, j5, j6; "
        "limits.joint_acceleration holds"
    ]


def test_a_velocity_limit_that_is_missing_or_zero_is_said(folder, lines):
    folder.change("small.urdf", 'upper="3" velocity="2"', 'upper="3" velocity="0"')
    assert any("velocity limit is 0 for j1, j2" in line for line in lines())


def test_limits_that_the_file_gives_are_not_missed(folder, lines):
    more = "limits: {joint_acceleration: {j1: 5, j2: 5, j3: 5, j4: 5, j5: 5, j6: 5}}\n"
    file = folder.path / "small.robot.yaml"
    folder.write("small.robot.yaml", file.read_text() + more)
    assert not [line for line in lines() if LIMITS in line]


def test_a_held_joint_in_the_chain_is_said(folder, lines):
    folder.change("small.robot.yaml", "held: {lift: 0.2}", "held: {lift: 0.2, j4: 0.1}")
    folder.change("small.robot.yaml", "posture: [0.0, -0.8, 1.6, 0.0, -0.8, 0.0]", "")
    assert "arm: j4 between its joints is held" in lines()


def test_a_body_without_geometry_is_said(folder, lines):
    assert not [line for line in lines() if "base.body_radius" in line]
    wheels = (folder.path / "small.urdf").read_text()
    shape = wheels[wheels.index("<collision>") : wheels.index("</collision>")]
    folder.change("small.urdf", shape + "</collision>", "")
    expected = "base.body_radius: unknown, as the base has no geometry"
    assert expected in lines()


def test_a_wrist_that_may_touch_the_body_is_said(folder, lines):
    folder.change(
        "small.robot.yaml", "wheel_radius: 0.1", "wheel_radius: 0.1, body_radius: 0.9"
    )
    (told,) = [line for line in lines() if line.startswith("field: ")]
    assert "is inside the body, whose edge is 0.8" in told


def test_a_posture_near_a_singularity_is_said(folder, lines):
    folder.change("small.robot.yaml", "[0.0, -0.8, 1.6,", "[0.0, -0.01, 0.02,")
    assert any("near a singularity" in line for line in lines())
