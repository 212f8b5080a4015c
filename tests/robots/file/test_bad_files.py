"""A bad robot file ends in one line: file, key, value, and what is valid."""

import pytest

from drake_mobman.cli.app import app
from drake_mobman.exit_status import BAD_INPUT
from drake_mobman.scenario import ScenarioError, load_scenario

ROBOT, URDF = "small.robot.yaml", "small.urdf"

WHEELS = "wheels: {left: [left], right: [right]}"

BAD = {
    # The file itself.
    "no file": (ROBOT, None, "", "path: ", "must be a robot file"),
    "not YAML": (ROBOT, "arm: {", "arm: [", "line ", "must be YAML"),
    "a list": (ROBOT, ..., "[1]\n", "the whole: [1]", "must be a mapping with keys"),
    "unknown key": (ROBOT, "held:", "hold:", "hold: {", "valid keys are: model, pack"),
    "unknown tag": (ROBOT, "arm: {", "arm: !Arm {", "arm._tag: ", "valid keys are: t"),
    "key twice": (ROBOT, "held:", "arm: {}\nheld:", "line 5", "given twice"),
    "a word for a number": (
        ROBOT,
        "wheel_radius: 0.1",
        "wheel_radius: big",
        "base.wheel_radius: 'big'",
        "must be a number",
    ),
    "not a number": (ROBOT, "0.2", ".nan", "held.lift: nan", "must be a finite number"),
    # Its model.
    "no model": (ROBOT, "model: small.urdf", "{}", "line", "must be YAML"),
    "model empty": (ROBOT, "small.urdf", "''", "model: ''", "must be given"),
    "model missing": (
        ROBOT,
        "small.urdf",
        "smal.urdf",
        "model: 'smal.urdf'",
        "near are small.urdf",
    ),
    "model in no folder": (
        ROBOT,
        "small.urdf",
        "no/small.urdf",
        "model: 'no/small.urdf'",
        "there is no folder",
    ),
    "model a folder": (ROBOT, "small.urdf", ".", "model: '.'", "Is a directory"),
    "package missing": (
        ROBOT,
        "small.urdf",
        "package://nosuch/small.urdf",
        "model: 'package://nosuch/small.urdf'",
        "package nosuch is not found; name its folder by packages: {nosuch: FOLDER}",
    ),
    "package no folder": (
        ROBOT,
        "held:",
        "packages: {robots: nowhere}\nheld:",
        "packages.robots: ",
        "must be a folder that is there",
    ),
    "empty file": (URDF, ..., " \n", "model: 'small.urdf'", "it is empty"),
    "not XML": (URDF, "</robot>", "<robot>", "model: 'small.urdf'", "must be XML"),
    "another XML": (URDF, ..., "<html/>", "<html>", "must begin with <robot>, <sdf>"),
    "xacro left in": (
        URDF,
        'mass value="20.0"',
        'mass value="${m}"',
        "model: 'small.urdf'",
        "expand it first: xacro small.urdf",
    ),
    "mesh missing": (
        URDF,
        '<cylinder radius="0.1" length="0.04"/>',
        '<mesh filename="meshes/wheel.stl"/>',
        "model: 'small.urdf'",
        "its mesh meshes/wheel.stl is missing: there is no ",
    ),
    "mesh in a missing package": (
        URDF,
        '<cylinder radius="0.1" length="0.04"/>',
        '<mesh filename="package://nosuch/wheel.stl"/>',
        "its mesh package://nosuch/wheel.stl is missing",
        "package nosuch is not found",
    ),
    "a loop": (
        URDF,
        "</robot>",
        '<joint name="k" type="fixed"><parent link="l6"/><child link="l1"/></joint>'
        "</robot>",
        "model: 'small.urdf'",
        "its links must not form a loop",
    ),
    "links apart": (
        URDF,
        "</robot>",
        '<link name="alone"/></robot>',
        "model: 'small.urdf'",
        "its links must all be joined; apart from each other are chassis, alone",
    ),
    "link twice": (
        URDF,
        "</robot>",
        '<link name="l1"/></robot>',
        "model: 'small.urdf'",
        "Drake says: Model instance 'small' already contains a body named 'l1'",
    ),
    "joint to nowhere": (
        URDF,
        '<child link="l3"/>',
        '<child link="l33"/>',
        "model: 'small.urdf'",
        "Could not find link named 'l33'",
    ),
    "without mass": (
        URDF,
        '<mass value="',
        '<mass value="0" was="',
        "model: 'small.urdf'",
        "what its joint j1 moves must have a mass",
    ),
    "less than no mass": (
        URDF,
        'mass value="20.0"',
        'mass value="-20.0"',
        "model: 'small.urdf'",
        "its link chassis has a mass of -20 kg",
    ),
    # Parts.
    "part missing": (
        ROBOT,
        "held:",
        "parts: [{model: hand.urdf, frame: flange}]\nheld:",
        "parts[0].model: 'hand.urdf'",
        "must be a file",
    ),
    "part nowhere": (
        ROBOT,
        "held:",
        "parts: [{model: small.urdf, frame: flansch}]\nheld:",
        "parts[0].frame: 'flansch'",
        "must be a link or frame; near are flange",
    ),
    "part placed by two numbers": (
        ROBOT,
        "held:",
        "parts: [{model: small.urdf, frame: l6, xyz: [0, 0]}]\nheld:",
        "parts[0].xyz: [0.0, 0.0]",
        "must be three numbers within [-10, 10] m",
    ),
    # The base.
    "no such base": (
        ROBOT,
        WHEELS,
        f"frame: chasis, {WHEELS}",
        "base.frame: 'chasis'",
        "near are chassis",
    ),
    "wheels that are no joints": (
        ROBOT,
        "left: [left]",
        "left: [left_whel]",
        "base.wheels.left[0]: 'left_whel'",
        "must be a joint that turns; near are left",
    ),
    "wheel twice": (
        ROBOT,
        "right: [right]",
        "right: [left]",
        "base.wheels.right: 'left'",
        "must name each wheel once",
    ),
    "wheels on one side": (
        ROBOT,
        "right: [right]",
        "right: []",
        "base.wheels.right: []",
        "must name one joint or more",
    ),
    "wheel that slides": (
        ROBOT,
        "left: [left]",
        "left: [lift]",
        "base.wheels.left[0]: 'lift'",
        "must be a joint that turns, and is prismatic",
    ),
    "wheel in the arm": (
        ROBOT,
        "left: [left]",
        "left: [j1]",
        "base.wheels.left[0]: 'j1'",
        "must not be on the way to the tool",
    ),
    "wheel held": (
        ROBOT,
        "{lift: 0.2}",
        "{lift: 0.2, left: 0.0}",
        "held.left: 0.0",
        "must not be held; it is a wheel that drives",
    ),
    "wheel without radius": (
        ROBOT,
        "wheel_radius: 0.1",
        "wheel_radius: 0",
        "base.wheel_radius: 0.0",
        "must be within [0.005, 2] m",
    ),
    "no track": (
        ROBOT,
        "wheel_radius: 0.1",
        "wheel_radius: 0.1, track: 0",
        "base.track: 0.0",
        "must be within [0.01, 10] m",
    ),
    "base too fast": (
        ROBOT,
        "wheel_radius: 0.1",
        "limits: {speed: 100}, wheel_radius: 0.1",
        "base.limits.speed: 100.0",
        "must be within [0.001, 10] m/s",
    ),
    # The arm.
    "no tool": (ROBOT, "tool: flange", "tool: ''", "arm.tool: ''", "must be given"),
    "tool no link": (
        ROBOT,
        "tool: flange",
        "tool: flanch",
        "arm.tool: 'flanch'",
        "must be a link or frame; near are flange",
    ),
    "tool on the base": (
        ROBOT,
        "tool: flange",
        "tool: column",
        "arm.tool: 'column'",
        "all of lift are held",
    ),
    "tool above no joint": (
        ROBOT,
        "tool: flange",
        "tool: chassis",
        "arm.tool: 'chassis'",
        "none is on the way",
    ),
    "held unknown": (
        ROBOT,
        "{lift: 0.2}",
        "{lit: 0.2}",
        "held.lit: 'lit'",
        "must be a joint that moves; near are lift",
    ),
    "held out of range": (
        ROBOT,
        "{lift: 0.2}",
        "{lift: 20}",
        "held.lift: 20.0",
        "must be within the joint's [-3, 3]",
    ),
    "posture too short": (
        ROBOT,
        "[0.0, -0.8, ",
        "[",
        "arm.posture: [1.6, 0.0, -0.8, 0.0]",
        "must be 6 positions, of j1, j2, j3, j4, j5, j6",
    ),
    "posture out of range": (
        ROBOT,
        "1.6",
        "4.6",
        "arm.posture[2]: 4.6",
        "must be within [-3, 3], the range of j3",
    ),
    "no such orientation": (
        ROBOT,
        "tool: flange",
        "tool: flange, orientation: up",
        "arm.orientation: 'up'",
        "must be one of reach, turning, held, free",
    ),
    "T on the base": (
        ROBOT,
        "tool: flange",
        "tool: flange, tee: chassis",
        "arm.tee: 'chassis'",
        "must be moved by the arm",
    ),
    "a ball in the arm": (
        URDF,
        'name="j4" type="revolute"',
        'name="j4" type="planar"',
        "arm.tool: 'flange'",
        "its joint j4 is planar; must be revolute or prismatic, or in `held`",
    ),
    "limit of an unknown joint": (
        ROBOT,
        "held:",
        "limits: {joint_velocity: {j7: 1.0}}\nheld:",
        "limits.joint_velocity.j7: 'j7'",
        "must be a joint of the arm; near are j6",
    ),
    "limit of zero": (
        ROBOT,
        "held:",
        "limits: {joint_acceleration: 0}\nheld:",
        "limits.joint_acceleration.*: 0.0",
        "must be within [0.001, 10000]",
    ),
    # The rest.
    "gripper unknown": (
        ROBOT,
        "held:",
        "gripper: {joints: [aa], open: 1, closed: 0}\nheld:",
        "gripper.joints[0]: 'aa'",
        "must be a joint that moves; near are a",
    ),
    "gripper too wide": (
        ROBOT,
        "held:",
        "gripper: {joints: [a], open: 10, closed: 0}\nheld:",
        "gripper.open: 10.0",
        "must be within [-3, 3], the range of a",
    ),
    "workspace upside down": (
        ROBOT,
        "held:",
        "workspace: {l_min: 0.7, l_max: 0.5}\nheld:",
        "workspace.l_min: 0.7",
        "must be below l_max = 0.5",
    ),
}


def spoil(folder, name, old, new):
    """Removes a file, writes another in its place, or replaces text in it."""
    if old is None:
        (folder.path / name).unlink()
    elif old is ...:
        folder.write(name, new)
    else:
        folder.change(name, old, new)


@pytest.mark.parametrize("kind", BAD)
def test_bad_robot_file_is_refused_in_one_line(folder, kind):
    name, old, new, where, valid = BAD[kind]
    spoil(folder, name, old, new)
    with pytest.raises(ScenarioError) as refusal:
        load_scenario(folder.path / "drive.yaml")
    line = str(refusal.value)
    assert line.startswith("drive.yaml: ")
    assert where in line
    assert valid in line
    assert line.isprintable()
    assert len(line) < 400


def test_there_are_many_kinds():
    assert len(BAD) >= 30


def test_scenario_without_a_path_says_so(folder):
    folder.write("drive.yaml", "robot: !File {}\n")
    with pytest.raises(ScenarioError, match=r"robot.path: '' is not valid; must be"):
        load_scenario(folder.path / "drive.yaml")


def test_wheel_without_shape_or_radius_is_refused(folder):
    folder.change(URDF, "<collision>", "<!-- ")
    folder.change(URDF, "</collision>", " -->")
    folder.change(ROBOT, ", wheel_radius: 0.1", "")
    with pytest.raises(ScenarioError, match=r"base.wheel_radius: None is not valid; m"):
        load_scenario(folder.path / "drive.yaml")


@pytest.mark.parametrize("kind", ["tool no link", "mesh missing", "a loop"])
def test_command_line_says_so_and_writes_nothing(folder, kind, capfd):
    name, old, new, where, valid = BAD[kind]
    spoil(folder, name, old, new)
    out = folder.path / "runs"
    with pytest.raises(SystemExit) as end:
        app(
            ["run", str(folder.path / "drive.yaml"), "--out", str(out)],
            standalone_mode=True,
        )
    assert end.value.code == BAD_INPUT
    told = capfd.readouterr()
    (line,) = told.err.splitlines()
    assert where in line
    assert valid in line
    assert told.out == ""
    assert not out.exists()


def load(folder):
    """Returns the line that the scenario is refused with."""
    with pytest.raises(ScenarioError) as refusal:
        load_scenario(folder.path / "drive.yaml")
    return str(refusal.value)


def test_directives_that_hold_themselves_are_refused(folder):
    text = "directives:\n- add_directives: {file: small.dmd.yaml}\n"
    folder.write("small.dmd.yaml", text)
    folder.change(ROBOT, "small.urdf", "small.dmd.yaml")
    assert "model: 'small.dmd.yaml' is not valid; must not be part of it" in load(
        folder
    )


def test_two_models_in_one_file_are_refused(folder):
    models = "".join(f'<model name="{x}"><link name="a"/></model>' for x in "ab")
    folder.write("small.sdf", f'<sdf version="1.9">{models}</sdf>')
    folder.change(ROBOT, "small.urdf", "small.sdf")
    assert "it holds 2 models, and must hold one" in load(folder)


def test_binary_file_is_refused(folder):
    (folder.path / URDF).write_bytes(bytes(range(256)))
    assert "model: 'small.urdf' is not valid; must be text; it is bina" in load(folder)


def test_robot_file_as_its_own_model_is_refused(folder):
    folder.change(ROBOT, "small.urdf", ROBOT)
    assert "model: 'small.robot.yaml' is not valid; Drake says: " in load(folder)


def test_included_file_that_is_missing_is_refused(folder):
    folder.write("small.xml", '<mujoco><include file="arm.xml"/></mujoco>')
    folder.change(ROBOT, "small.urdf", "small.xml")
    assert "it includes arm.xml; No such file or directory" in load(folder)
