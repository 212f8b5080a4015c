"""The same robot, whatever its model's format, and whatever its links are called."""

import textwrap

import numpy as np
import pytest
from pydrake.math import RigidTransform, RotationMatrix

from drake_mobman.frames import frame
from drake_mobman.robot_model import RobotModel
from drake_mobman.robot_model.model import drawn_plant
from drake_mobman.robots.file import File

from .conftest import ARM, POSTURE


def small_mjcf(mesh=""):
    """Returns the small robot, its fingers left out, in MJCF."""
    bodies, ends = [], ""
    for i, (name, xyz, axis) in enumerate(ARM, 1):
        bodies.append(
            f'<body name="l{i}" pos="{xyz}"><joint name="{name}" axis="{axis}" '
            f'range="-3 3"/><geom type="sphere" size="0.03" mass="1"/>'
        )
        ends += "</body>"
    wheels = "".join(
        f'<body name="{side}_wheel" pos="0 {y} 0.1"><joint name="{side}" axis="0 1 0"/>'
        f'<geom type="cylinder" size="0.1 0.02" quat="0.7071 0.7071 0 0"/></body>'
        for side, y in (("left", 0.2), ("right", -0.2))
    )
    return textwrap.dedent(
        f"""\
        <mujoco model="small"><compiler angle="radian"/>{mesh}<worldbody>
        <body name="chassis"><geom type="box" size="0.2 0.15 0.1" mass="20"/>{wheels}
        <body name="column"><joint name="lift" type="slide" range="-3 3"/>
        <geom type="sphere" size="0.05" mass="1"/>
        {"".join(bodies)}<body name="flange" pos="0.1 0 0">
        <geom type="sphere" size="0.02" mass="0.1"/></body>{ends}
        </body></body></worldbody></mujoco>
        """
    )


def small_sdf():
    """Returns the arm on a chassis, in SDFormat, each link's pose in the one before."""
    parts = ['<link name="chassis"/><link name="column"/>']
    parts.append(
        '<joint name="lift" type="fixed"><parent>chassis</parent>'
        '<child>column</child></joint><frame name="up" attached_to="column">'
        '<pose relative_to="column">0 0 0.2 0 0 0</pose></frame>'
    )
    before = "up"
    for i, (name, xyz, axis) in enumerate(ARM, 1):
        link = f"l{i}"
        parts.append(
            f'<link name="{link}"><pose relative_to="{before}">{xyz} 0 0 0</pose>'
            f"</link>"
            f'<joint name="{name}" type="revolute"><parent>{before}</parent>'
            f"<child>{link}</child><axis><xyz>{axis}</xyz>"
            f"<limit><lower>-3</lower><upper>3</upper></limit></axis></joint>"
        )
        before = link
    parts.append(
        '<frame name="flange" attached_to="l6">'
        '<pose relative_to="l6">0.1 0 0 0 0 0</pose></frame>'
    )
    model = "".join(parts)
    return f'<sdf version="1.9"><model name="small">{model}</model></sdf>'


def X_BE(file, q):
    """Returns the pose of E in B of a robot file."""
    model = RobotModel(File(str(file)))
    context = model.plant.CreateDefaultContext()
    model.plant.SetPositions(context, [0.0, 0.0, 0.0, *q])
    return frame(model.plant, "tool").CalcPose(context, frame(model.plant, "base"))


def test_mjcf_is_where_mujoco_has_it(folder):
    mujoco = pytest.importorskip("mujoco")
    folder.write("small.xml", small_mjcf())
    folder.change("small.robot.yaml", "small.urdf", "small.xml")
    model = mujoco.MjModel.from_xml_string(small_mjcf())
    data, q = mujoco.MjData(model), [0.3, -0.5, 1.1, 0.2, -0.7, 0.4]
    for name, angle in zip(["lift", *(x[0] for x in ARM)], [0.2, *q], strict=True):
        data.qpos[model.joint(name).qposadr[0]] = angle
    mujoco.mj_kinematics(model, data)
    there = data.body("flange")
    R = RotationMatrix(there.xmat.reshape(3, 3))
    expected = RigidTransform(R, there.xpos)
    found = X_BE(folder.path / "small.robot.yaml", q)
    assert found.IsNearlyEqualTo(expected, 1e-9)


def test_sdformat_is_where_the_same_urdf_is(folder):
    expected = X_BE(folder.path / "small.robot.yaml", POSTURE)
    folder.write("small.sdf", small_sdf())
    folder.change("small.robot.yaml", "small.urdf", "small.sdf")
    folder.change("small.robot.yaml", "held: {lift: 0.2}", "held: {}")
    wheels = "wheels: {left: [left], right: [right]}, wheel_radius: 0.1"
    folder.change("small.robot.yaml", wheels, "frame: chassis")
    found = X_BE(folder.path / "small.robot.yaml", POSTURE)
    assert found.IsNearlyEqualTo(expected, 1e-12)


def test_directives_add_models_beside_them(folder):
    expected = X_BE(folder.path / "small.robot.yaml", POSTURE)
    folder.write(
        "small.dmd.yaml",
        """\
        directives:
        - add_model: {name: me, file: small.urdf}
        """,
    )
    folder.change("small.robot.yaml", "small.urdf", "small.dmd.yaml")
    found = X_BE(folder.path / "small.robot.yaml", POSTURE)
    assert found.IsNearlyEqualTo(expected, 1e-12)


@pytest.mark.parametrize("name", ["base", "tool", "tee", "world_", "x_slide"])
def test_links_may_have_the_names_of_ours(folder, name):
    expected = X_BE(folder.path / "small.robot.yaml", POSTURE)
    for link in ("chassis", "l3"):
        text = (folder.path / "small.urdf").read_text()
        folder.write("small.urdf", text.replace(f'"{link}"', f'"{name}"'))
        found = X_BE(folder.path / "small.robot.yaml", POSTURE)
        assert found.IsNearlyEqualTo(expected, 1e-12)
        folder.write("small.urdf", text)


def test_model_that_is_fixed_to_the_world_is_taken_off(folder):
    expected = X_BE(folder.path / "small.robot.yaml", POSTURE)
    fixed = (
        '<link name="world"/><joint name="stand" type="fixed"><origin xyz="3 2 1"/>'
        '<parent link="world"/><child link="chassis"/></joint></robot>'
    )
    folder.change("small.urdf", "</robot>", fixed)
    found = X_BE(folder.path / "small.robot.yaml", POSTURE)
    assert found.IsNearlyEqualTo(expected, 1e-12)


def test_joints_may_be_declared_in_any_order(folder):
    expected = X_BE(folder.path / "small.robot.yaml", POSTURE)
    lines = (folder.path / "small.urdf").read_text().splitlines()
    folder.write("small.urdf", "\n".join([lines[0], *lines[-2:0:-1], lines[-1]]))
    model = RobotModel(File(str(folder.path / "small.robot.yaml")))
    assert model.arm_joints == [name for name, *_ in ARM]
    found = X_BE(folder.path / "small.robot.yaml", POSTURE)
    assert found.IsNearlyEqualTo(expected, 1e-12)


def test_follower_stands_where_what_it_follows_is_held(folder):
    folder.change("small.robot.yaml", "{lift: 0.2}", "{lift: 0.2, a: 0.03}")
    plant = RobotModel(File(str(folder.path / "small.robot.yaml"))).plant
    context, tool = plant.CreateDefaultContext(), frame(plant, "tool")
    z = [
        plant.GetFrameByName(f"finger_{side}").CalcPose(context, tool).translation()[2]
        for side in "ab"
    ]
    np.testing.assert_allclose(z, [0.03, -0.03], atol=1e-12)


def test_same_part_twice_is_told_apart_by_its_models_name(folder):
    folder.write(
        "pin.urdf",
        '<robot name="pin"><link name="foot"/><link name="tip"/>'
        '<joint name="up" type="fixed"><origin xyz="0.02 0 0"/><parent link="foot"/>'
        '<child link="tip"/></joint></robot>',
    )
    parts = "[{model: pin.urdf, frame: flange}, {model: pin.urdf, frame: flange}]"
    folder.change("small.robot.yaml", "held:", f"parts: {parts}\nheld:")
    folder.change("small.robot.yaml", "tool: flange", "tool: 'pin_1::tip'")
    robot = File(str(folder.path / "small.robot.yaml")).described()
    assert {"pin::tip", "pin_1::tip"} <= robot.loose.parsed.frames.keys()
    assert robot.layout.tool == "pin_1::tip"


@pytest.mark.parametrize("defined", ["later", "at the end", "nowhere"])
def test_material_that_is_named_before_it_is_defined_is_drawn(folder, defined):
    ball = '<visual><geometry><sphere radius="0.1"/></geometry>{}</visual>'
    whole = '<material name="grey"><color rgba="0.2 0.3 0.4 1"/></material>'
    other = whole.replace("0.2", "0.9") if defined == "at the end" else ""
    for body, material in (
        ("chassis", '<material name="grey"/>'),
        ("column", whole if defined == "later" else other),
    ):
        at = f'<link name="{body}">'
        folder.change("small.urdf", at, at + ball.format(material))
    if defined == "at the end":
        folder.change("small.urdf", "</robot>", f"{whole}</robot>")
    plant, scene_graph = drawn_plant(File(str(folder.path / "small.robot.yaml")))
    inspector = scene_graph.model_inspector()
    (shape,) = plant.GetVisualGeometriesForBody(plant.GetBodyByName("chassis"))
    drawn = inspector.GetIllustrationProperties(shape)
    assert drawn.HasProperty("phong", "diffuse") is (defined != "nowhere")
    if defined != "nowhere":
        rgba = drawn.GetProperty("phong", "diffuse")
        assert [rgba.r(), rgba.g(), rgba.b()] == pytest.approx([0.2, 0.3, 0.4])
