"""A small robot in URDF, and its robot file, which tests change."""

import textwrap

import pytest


def link(name, mass=1.0, extra=""):
    inertia = " ".join(f'{axis}="0.01"' for axis in ("ixx", "iyy", "izz"))
    return (
        f'<link name="{name}"><inertial><mass value="{mass}"/>'
        f'<inertia {inertia} ixy="0" ixz="0" iyz="0"/></inertial>{extra}</link>\n'
    )


def joint(name, kind, parent, child, xyz="0 0 0", axis="0 0 1", extra=""):
    limit = '<limit lower="-3" upper="3" velocity="2" effort="50"/>'
    return (
        f'<joint name="{name}" type="{kind}"><origin xyz="{xyz}"/>'
        f'<parent link="{parent}"/><child link="{child}"/><axis xyz="{axis}"/>'
        f"{limit}{extra}</joint>\n"
    )


ARM = [
    ("j1", "0.1 0 0.5", "0 0 1"),
    ("j2", "0 0 0.1", "0 1 0"),
    ("j3", "0.4 0 0", "0 1 0"),
    ("j4", "0.1 0 0", "1 0 0"),
    ("j5", "0.3 0 0", "0 1 0"),
    ("j6", "0.05 0 0", "1 0 0"),
]
"""Names, origins and axes of the arm's joints."""

POSTURE = [0.0, -0.8, 1.6, 0.0, -0.8, 0.0]
"""With the end effector level."""

WHEEL = '<collision><geometry><cylinder radius="0.1" length="0.04"/></geometry>' + (
    "</collision>"
)


def small_urdf():
    """Returns a base of two wheels, a lift, an arm of six joints and a gripper."""
    parts = ['<robot name="small">\n', link("chassis", 20.0)]
    for side, y in (("left", 0.2), ("right", -0.2)):
        parts += [
            link(f"{side}_wheel", 1.0, WHEEL),
            joint(side, "continuous", "chassis", f"{side}_wheel", f"0 {y} 0.1").replace(
                'xyz="0 0 1"', 'xyz="0 1 0"'
            ),
        ]
    parts += [link("column"), joint("lift", "prismatic", "chassis", "column")]
    parent = "column"
    for i, (name, xyz, axis) in enumerate(ARM, 1):
        parts += [link(f"l{i}"), joint(name, "revolute", parent, f"l{i}", xyz, axis)]
        parent = f"l{i}"
    parts += [link("flange", 0.1), joint("f", "fixed", "l6", "flange", "0.1 0 0")]
    for side, mimic in (("a", ""), ("b", '<mimic joint="a" multiplier="-1"/>')):
        parts += [
            link(f"finger_{side}", 0.05),
            joint(side, "prismatic", "flange", f"finger_{side}", extra=mimic),
        ]
    return "".join([*parts, "</robot>\n"])


SMALL = """\
model: small.urdf
base: {wheels: {left: [left], right: [right]}, wheel_radius: 0.1}
held: {lift: 0.2}
arm: {tool: flange, posture: [0.0, -0.8, 1.6, 0.0, -0.8, 0.0]}
"""


class Folder:
    """A folder with a robot file and its model, and a scenario of this robot."""

    def __init__(self, path):
        self.path = path
        self.write("small.urdf", small_urdf())
        self.write("small.robot.yaml", SMALL)
        self.write("drive.yaml", "robot: !File {path: small.robot.yaml}\nduration: 1.0")

    def write(self, name, text):
        """Writes a file, and returns its path."""
        file = self.path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(textwrap.dedent(text))
        return file

    def change(self, name, old, new):
        """Replaces text in a file that holds it."""
        text = (self.path / name).read_text()
        assert old in text
        return self.write(name, text.replace(old, new))


@pytest.fixture
def folder(tmp_path):
    """A folder with a small robot."""
    return Folder(tmp_path)
