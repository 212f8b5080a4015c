"""Meshes of a model are drawn as they are, and outlined by primitives around them."""

import struct

import numpy as np
import pytest
from pydrake.geometry import Box, Cylinder, Mesh, Sphere

from drake_mobman.robot_model.model import drawn_plant
from drake_mobman.robots.file import File, drawn
from drake_mobman.robots.file.fitted import fitted
from drake_mobman.robots.file.points import points_of

CORNERS = np.array([[x, y, z] for x in (0, 0.2) for y in (0, 0.1) for z in (0, 0.4)])
FACES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)]
FACES += [(2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    """Keeps what is converted out of the user's cache."""
    monkeypatch.setattr(drawn, "cache_folder", lambda: tmp_path / "cache")
    drawn._pieces.cache_clear()


def stl(binary=True):
    """Returns a block as STL."""
    if not binary:
        lines = ["solid block"]
        for face in FACES:
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += ["vertex {} {} {}".format(*CORNERS[i]) for i in face]
            lines += ["endloop", "endfacet"]
        return "\n".join([*lines, "endsolid block", ""]).encode()
    data = b"solid, but binary".ljust(80) + struct.pack("<I", len(FACES))
    for face in FACES:
        data += struct.pack("<3f9fH", 0, 0, 0, *CORNERS[list(face)].ravel(), 0)
    return data


def collada():
    """Returns a block as Collada, in millimetres, moved by its node."""
    points = " ".join(map(str, (1000 * CORNERS).ravel()))
    faces = " ".join(str(i) for face in FACES for i in face)
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="millimeter" meter="0.001"/><up_axis>Z_UP</up_axis></asset>
<library_effects><effect id="red"><profile_COMMON><technique sid="t"><lambert>
<diffuse><color>1 0 0 1</color></diffuse></lambert></technique></profile_COMMON>
</effect></library_effects>
<library_materials><material id="m"><instance_effect url="#red"/></material>
</library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="24">{points}</float_array>
<technique_common><accessor source="#pa" count="8" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="12" material="m">
<input semantic="VERTEX" source="#v" offset="0"/><p>{faces}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node>
<translate>500 0 0</translate><instance_geometry url="#g"><bind_material>
<technique_common><instance_material symbol="m" target="#m"/></technique_common>
</bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>""".encode()


def with_mesh(folder, name, data, role="visual"):
    """Puts a mesh on the chassis, twice as large along z, and returns the robot."""
    (folder.path / name).write_bytes(data)
    mesh = (
        f'<{role}><origin xyz="0 0 0.1" rpy="0 0 1.5707963267948966"/><geometry>'
        f'<mesh filename="{name}" scale="1 1 2"/></geometry></{role}>'
    )
    at = '<link name="chassis">'
    folder.change("small.urdf", at, f"{at}{mesh}")
    return File(str(folder.path / "small.robot.yaml"))


@pytest.mark.parametrize("binary", [True, False])
def test_points_of_stl_are_its_corners(tmp_path, binary):
    file = tmp_path / "block.stl"
    file.write_bytes(stl(binary))
    found = np.unique(points_of(file).round(6), axis=0)
    np.testing.assert_allclose(found, np.unique(CORNERS, axis=0), atol=1e-6)


def test_points_of_collada_are_in_metres_and_moved(tmp_path):
    file = tmp_path / "block.dae"
    file.write_bytes(collada())
    moved = points_of(file) - [0.5, 0, 0]
    np.testing.assert_allclose(moved, CORNERS, atol=1e-12)


def test_file_that_is_no_mesh_has_no_points(tmp_path):
    for name, text in (("a.dae", "<x"), ("b.obj", "v 1 x 2\n"), ("c.xyz", "1 2 3")):
        (tmp_path / name).write_text(text)
        assert len(points_of(tmp_path / name)) == 0


@pytest.mark.parametrize(
    ("name", "data"), [("block.stl", stl()), ("block.dae", collada())]
)
def test_mesh_is_drawn_where_it_is(folder, name, data):
    pytest.importorskip("collada")
    plant, scene_graph = drawn_plant(with_mesh(folder, name, data))
    inspector = scene_graph.model_inspector()
    body = plant.GetBodyByName("chassis")
    (shape,) = plant.GetVisualGeometriesForBody(body)
    mesh = inspector.GetShape(shape)
    assert isinstance(mesh, Mesh)
    hull = np.array([mesh.GetConvexHull().vertex(i) for i in range(8)])
    ahead = 0.5 if name.endswith("dae") else 0.0
    size = np.ptp(hull, axis=0)
    np.testing.assert_allclose(size, [0.2, 0.1, 0.8], atol=1e-5)
    assert hull[:, 0].min() == pytest.approx(ahead, abs=1e-5)


def test_collada_keeps_its_colour(folder):
    pytest.importorskip("collada")
    plant, scene_graph = drawn_plant(with_mesh(folder, "block.dae", collada()))
    (shape,) = plant.GetVisualGeometriesForBody(plant.GetBodyByName("chassis"))
    looks = scene_graph.model_inspector().GetIllustrationProperties(shape)
    rgba = looks.GetProperty("phong", "diffuse")
    assert (rgba.r(), rgba.g(), rgba.b()) == (1.0, 0.0, 0.0)


def test_collada_is_a_box_without_the_extra(folder, monkeypatch):
    monkeypatch.setattr(drawn.importlib.util, "find_spec", lambda _: None)
    plant, scene_graph = drawn_plant(with_mesh(folder, "block.dae", collada()))
    (shape,) = plant.GetVisualGeometriesForBody(plant.GetBodyByName("chassis"))
    box = scene_graph.model_inspector().GetShape(shape)
    assert isinstance(box, Box)
    np.testing.assert_allclose(box.size(), [0.2, 0.1, 0.8], atol=1e-9)


def test_outline_of_a_mesh_is_a_box_around_it(folder):
    model = with_mesh(folder, "block.stl", stl(), "collision").described().loose
    (shape,) = model.plant.GetCollisionGeometriesForBody(
        model.plant.GetBodyByName("chassis")
    )
    assert isinstance(model.inspector.GetShape(shape), Box)
    X = model.inspector.GetPoseInFrame(shape)
    # Turned by a right angle about z, and its middle at half its size.
    np.testing.assert_allclose(X.translation(), [-0.05, 0.1, 0.5], atol=1e-6)
    np.testing.assert_allclose(X.rotation().matrix()[:, 0], [0, 1, 0], atol=1e-6)


def test_smallest_primitive_is_the_shape_that_the_points_are_of():
    rng = np.random.default_rng(0)
    on_ball = rng.normal(size=(2000, 3))
    on_ball *= 0.3 / np.linalg.norm(on_ball, axis=1, keepdims=True)
    assert fitted(on_ball).kind == "sphere"
    angle = rng.uniform(0, 2 * np.pi, 500)
    rim = 0.1 * np.column_stack([np.cos(angle), np.sin(angle)])
    along = rng.uniform(-0.5, 0.5, 500)
    rod = np.column_stack([along, rim])
    fit = fitted(rod)
    assert fit.kind == "cylinder"
    np.testing.assert_allclose(abs(fit.X_MG.rotation().matrix()[:, 2]), [1, 0, 0])
    assert fitted(CORNERS).kind == "box"
    assert fitted(CORNERS[:0]) is None


@pytest.mark.parametrize("shape", [Cylinder, Sphere])
def test_wheel_of_a_mesh_gives_its_radius(folder, shape):
    angle = np.linspace(0, 2 * np.pi, 100)
    rim = [
        (0.12 * np.cos(a), y, 0.12 * np.sin(a)) for a in angle for y in (-0.02, 0.02)
    ]
    if shape is Sphere:
        tilt = np.linspace(-np.pi / 2, np.pi / 2, 60)
        rim = [
            0.12 * np.array([np.cos(a) * np.cos(b), np.sin(b), np.sin(a) * np.cos(b)])
            for a in angle
            for b in tilt
        ]
    lines = ["v {} {} {}".format(*p) for p in rim]
    folder.write("wheel.obj", "\n".join([*lines, "f 1 2 3", ""]))
    folder.change("small.robot.yaml", ", wheel_radius: 0.1", "")
    cylinder = '<cylinder radius="0.1" length="0.04"/>'
    folder.change("small.urdf", cylinder, '<mesh filename="wheel.obj"/>')
    robot = File(str(folder.path / "small.robot.yaml")).described()
    assert robot.placement.wheel_radius.value == pytest.approx(0.12, rel=1e-3)
