"""Models for tests, as text."""

from pydrake.geometry import SceneGraph
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant


class Model:
    """A finalized plant with geometry, of a URDF's links and joints."""

    def __init__(self, body):
        self.scene_graph, self.plant = SceneGraph(), MultibodyPlant(0.0)
        self.plant.RegisterAsSourceForSceneGraph(self.scene_graph)
        text = f'<robot name="tested">{body}</robot>'
        Parser(self.plant).AddModelsFromString(text, "urdf")
        self.plant.Finalize()
        self.inspector = self.scene_graph.model_inspector()
        self.context = self.plant.CreateDefaultContext()

    def joint(self, name):
        return self.plant.GetJointByName(name)

    def body(self, name):
        return self.plant.GetBodyByName(name)

    def frame(self, name):
        return self.plant.GetFrameByName(name)


def link(name, *shapes, kind="collision"):
    """Returns a link's XML; each shape is (xyz, rpy, geometry)."""
    geometry = "".join(
        f'<{kind}><origin xyz="{xyz}" rpy="{rpy}"/>'
        f"<geometry>{shape}</geometry></{kind}>"
        for xyz, rpy, shape in shapes
    )
    inertia = (
        '<mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    )
    return f'<link name="{name}"><inertial>{inertia}</inertial>{geometry}</link>'


def joint(name, parent, child, xyz="0 0 0", axis="0 0 1", kind="revolute", rpy="0 0 0"):
    """Returns a joint's XML."""
    limit = '<limit lower="-2" upper="2" velocity="1" effort="10"/>'
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{child}"/><origin xyz="{xyz}" rpy="{rpy}"/>'
        f'<axis xyz="{axis}"/>{limit}</joint>'
    )
