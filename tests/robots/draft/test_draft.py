"""A draft of a robot file tells wheels, lifts and grippers by the model's geometry."""

import pytest

from drake_mobman.parameters import ParameterError
from drake_mobman.robots.draft import Mount, drafted
from drake_mobman.robots.draft.guess import guessed
from drake_mobman.robots.file import File
from drake_mobman.robots.file.contents import Arm, RobotFile
from drake_mobman.robots.file.described import models_of
from drake_mobman.robots.file.loose import loose
from drake_mobman.schema import load_typed, load_yaml

MODELS = "package://example-robot-data/robots"
PANDA = f"{MODELS}/panda_description/urdf/panda.urdf"


@pytest.fixture(scope="module")
def panda(tmp_path_factory):
    """Returns a draft for the Panda on a base, in a file, and its contents."""
    text = drafted(PANDA, "panda_hand_tcp", mount=Mount("tiago_base", xyz=(0.05, 0, 0)))
    file = tmp_path_factory.mktemp("robots") / "panda.robot.yaml"
    file.write_text(text)
    return file, load_typed(RobotFile, load_yaml(text))


def guess(model, tool, folder):
    contents = RobotFile(model=model, arm=Arm(tool=tool))
    return guessed(contents, loose(models_of(contents, folder), {})).contents


@pytest.mark.parametrize(
    ("model", "tool", "left"),
    [
        ("tiago_description/robots/tiago_dual.urdf", "arm_left_tool_link", 1),
        ("tiago_pro_description/robots/tiago_pro.urdf", "arm_left_tool_link", 2),
    ],
)
def test_wheels_are_told_from_casters(model, tool, left, tmp_path):
    contents = guess(f"{MODELS}/{model}", tool, tmp_path)
    wheels = contents.base.wheels
    assert len(wheels.left) == len(wheels.right) == left
    assert all("wheel" in name and "left" in name for name in wheels.left)
    assert all("wheel" in name and "right" in name for name in wheels.right)
    assert contents.held == {"torso_lift_joint": 0.175}


@pytest.mark.parametrize(
    ("model", "tool", "held"),
    [
        (
            "talos_data/robots/talos_full_v2.urdf",
            "gripper_left_base_link",
            {"torso_1_joint": 0.0, "torso_2_joint": 0.0},
        ),
        # Fingers beyond the wrist are no limb, and an arm by itself has no trunk.
        ("baxter_description/urdf/baxter.urdf", "left_gripper", {}),
        ("panda_description/urdf/panda.urdf", "panda_hand_tcp", {}),
    ],
)
def test_a_trunk_that_carries_other_limbs_is_held(model, tool, held, tmp_path):
    assert guess(f"{MODELS}/{model}", tool, tmp_path).held == held


def test_robot_without_wheels_is_moved_by_its_root(tmp_path):
    contents = guess(
        f"{MODELS}/pr2_description/urdf/pr2.urdf", "r_gripper_tool_frame", tmp_path
    )
    assert contents.base.wheels is None
    assert contents.base.frame == "base_footprint"
    assert contents.gripper.joints == ["r_gripper_l_finger_joint"]


def test_arm_stands_on_a_base_that_comes_along(panda):
    _, contents = panda
    assert contents.model == "package://drake_mobman/tiago_base.urdf"
    (part,) = contents.parts
    assert (part.model, part.frame, part.xyz) == (PANDA, "deck", [0.05, 0.0, 0.0])
    assert contents.base.wheels.left == ["wheel_left_joint"]
    assert contents.gripper.joints == ["panda_finger_joint1"]


def test_draft_holds_all_that_is_derived_and_is_the_same_robot(panda, tmp_path):
    file, contents = panda
    text = file.read_text()
    for key in ("wheel_radius", "track", "body_radius", "orientation", "posture"):
        assert f"  {key}: " in text
    assert contents.base.wheel_radius == 0.0985
    assert contents.base.track == 0.4044
    bare = tmp_path / "bare.robot.yaml"
    lines = [
        line
        for line in text.splitlines()
        if not line.strip().startswith(("posture", "workspace", "track", "body_radius"))
    ]
    bare.write_text("\n".join(lines))
    given, derived = (File(str(x)).resolved() for x in (file, bare))
    assert given.posture.value == pytest.approx(derived.posture.value, abs=1e-3)
    for key in ("l_min", "l_max", "psi_min", "psi_max"):
        one, other = (getattr(x.workspace.value, key) for x in (given, derived))
        assert one == pytest.approx(other, abs=2e-3)


def test_every_line_that_is_derived_says_where_it_is_from(panda):
    lines = panda[0].read_text().splitlines()
    for key in ("wheels:", "track:", "posture:", "gripper:"):
        (i,) = (i for i, x in enumerate(lines) if x.strip().startswith(key))
        assert "  # " in lines[i] or lines[i - 1].strip().startswith("# ")
    assert max(map(len, lines)) < 120


@pytest.mark.parametrize(
    ("mount", "says"),
    [
        (Mount("", "deck"), "needs a base"),
        (Mount("base.urdf"), "must name a link or frame of base.urdf"),
        (Mount("husky", "top_plaet"), "near are top_plate"),
    ],
)
def test_wrong_mount_is_refused(mount, says):
    with pytest.raises(ParameterError, match=says):
        drafted(PANDA, "panda_hand_tcp", mount=mount)


def test_wrong_tool_is_refused_with_names_that_are_near():
    with pytest.raises(ParameterError, match=r"near are .*panda_hand_tcp"):
        drafted(PANDA, "panda_hand_tpc")
