"""The base, derived from its wheels and its geometry."""

import math

import numpy as np
import pytest
from pydrake.geometry import Box, Capsule, Cylinder, Ellipsoid, HalfSpace, Sphere
from pydrake.math import RigidTransform, RollPitchYaw

from drake_mobman.parameters import ParameterError
from drake_mobman.robots.derive.body import body_radius
from drake_mobman.robots.derive.extent import Placed, extents
from drake_mobman.robots.derive.wheels import base_frame, track, wheel_radius

from .models import Model, joint, link

TYRE = '<cylinder radius="0.1" length="0.04"/>'
BOX = '<box size="0.5 0.3 0.2"/>'
LIES = "1.5707963267948966 0 0"

BASE = (
    link("root", ("0.1 0 0.2", "0 0 0", BOX))
    + link("left", ("0 0 0", LIES, TYRE))
    + link("right", ("0 0 0", LIES, TYRE))
    + joint("left_wheel", "root", "left", "0.05 0.25 0.12", "0 1 0", "continuous")
    + joint("right_wheel", "root", "right", "0.05 -0.25 0.12", "0 -1 0", "continuous")
)

LIMBS = (
    link("column", ("0 0 0", "0 0 0", '<box size="0.1 0.1 0.6"/>'))
    + link("upper", ("0.5 0 0", "0 0 0", '<box size="1 0.1 0.1"/>'))
    + link("tool")
    + link("other", ("0.8 0 0", "0 0 0", '<box size="1.6 0.1 0.1"/>'))
    + link("canopy", ("0 0 0.5", "0 0 0", '<box size="3 3 0.1"/>'))
    + joint("lift", "root", "column", "0 0 0.5", kind="prismatic")
    + joint("canopy_weld", "column", "canopy", kind="fixed")
    + joint("pan", "column", "upper")
    + joint("bend", "upper", "tool", "1 0 0", "0 1 0")
    + joint("other_pan", "column", "other")
)


def wheels(model):
    return [model.joint("left_wheel")], [model.joint("right_wheel")]


def test_B_is_on_the_floor_midway_between_the_wheels_with_the_left_one_on_its_left():
    model = Model(BASE)
    left, right = wheels(model)
    found = base_frame(model.context, left, right, 0.1, model.frame("root")).value
    np.testing.assert_allclose(found.translation(), [0.05, 0.0, 0.02], atol=1e-15)
    np.testing.assert_allclose(found.rotation().matrix(), np.eye(3), atol=1e-15)
    back = base_frame(model.context, right, left, 0.1, model.frame("root")).value
    np.testing.assert_allclose(
        back.rotation().matrix(), np.diag([-1, -1, 1]), atol=1e-15
    )
    apart = track(model.context, left, right, model.frame("root"))
    assert apart.value == pytest.approx(0.5)


def test_wheels_that_are_not_apart_are_refused():
    model = Model(BASE)
    left, _ = wheels(model)
    with pytest.raises(ParameterError, match=r"base\.wheels\.left"):
        base_frame(model.context, left, left, 0.1, model.frame("root"))


def test_a_wheels_radius_is_that_of_its_tyre():
    model = Model(BASE)
    found = wheel_radius(
        model.plant, model.inspector, model.context, model.joint("left_wheel")
    )
    assert found == (0.1, "radius of left, collision geometry")


def test_a_wheel_of_another_shape_is_half_as_high_as_wide(tmp_path):
    # A tyre whose mesh is an octagon; it turns about its y axis.
    ring = [(0.2 * math.cos(a), 0.2 * math.sin(a)) for a in np.arange(8) * math.pi / 4]
    corners = [(x, y, z) for y in (-0.02, 0.02) for x, z in ring]
    path = tmp_path / "tyre.obj"
    path.write_text(
        "".join(f"v {x} {y} {z}\n" for x, y, z in corners)
        + "".join(f"f 1 {i} {i + 1}\n" for i in range(2, len(corners)))
    )
    mesh = f'<mesh filename="file://{path}"/>'
    model = Model(
        link("root")
        + link("wheel", ("0 0 0", "0 0 0", mesh), kind="visual")
        + joint("drive", "root", "wheel", "0 0.2 0.2", "0 1 0", "continuous")
    )
    found = wheel_radius(
        model.plant, model.inspector, model.context, model.joint("drive")
    )
    assert found.value == pytest.approx(0.2)
    assert found.source == "half the width of wheel, visual geometry"


def test_a_wheel_without_shape_has_to_be_given_a_radius():
    model = Model(
        link("root")
        + link("wheel")
        + joint("drive", "root", "wheel", "0 0 0.2", "0 1 0", "continuous")
    )
    with pytest.raises(ParameterError, match=r"base\.wheel_radius.*wheel has no geom"):
        wheel_radius(model.plant, model.inspector, model.context, model.joint("drive"))


def radius_of(model, *bodies, height=0.7):
    return body_radius(
        model.plant,
        model.inspector,
        model.context,
        [model.body(name) for name in bodies],
        model.frame("root"),
        height,
    )


def test_the_base_reaches_as_far_as_its_furthest_corner():
    model = Model(BASE)
    found = radius_of(model, "root")
    assert found.value == pytest.approx(math.hypot(0.35, 0.15))
    assert found.source == "collision geometry, furthest at root"


def test_limbs_and_what_hangs_above_the_shoulder_are_not_the_base():
    model = Model(BASE + LIMBS)
    model.joint("lift").set_translation(model.context, 0.2)
    found = radius_of(model, "root", "left", "right", "column")
    assert found.value == pytest.approx(math.hypot(0.35, 0.15))
    raised = radius_of(model, "root", "column", height=1.3)
    assert raised.value == pytest.approx(1.5 * 2**0.5)
    assert raised.source.endswith("furthest at canopy")


def test_a_base_without_geometry_has_no_radius():
    assert radius_of(Model(link("root")), "root").value == 0.0


SHAPES = [
    Sphere(0.3),
    Capsule(0.2, 0.5),
    Cylinder(0.3, 0.4),
    Box(0.2, 0.4, 0.6),
    Ellipsoid(0.3, 0.2, 0.5),
]


@pytest.mark.parametrize("shape", SHAPES, ids=lambda x: type(x).__name__)
def test_shapes_reach_as_far_as_points_on_their_skin(shape):
    X = RigidTransform(RollPitchYaw(0.4, -0.7, 1.1), [0.5, -0.2, 0.9])
    (found,) = extents([Placed(shape, X)])
    points = skin(shape) @ X.rotation().matrix().T + X.translation()
    assert found.radius == pytest.approx(
        np.hypot(points[:, 0], points[:, 1]).max(), rel=2e-3
    )
    assert found.lowest == pytest.approx(points[:, 2].min(), abs=2e-3)


def skin(shape):
    """Returns many points (N, 3) on a shape, and all that stick out."""
    rng = np.random.default_rng(0)
    ball = rng.normal(size=(200_000, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    ends = np.sign(ball[:, 2:]) * [[0.0, 0.0, 0.5]]
    match shape:
        case Sphere():
            return ball * shape.radius()
        case Ellipsoid():
            return ball * [shape.a(), shape.b(), shape.c()]
        case Capsule():
            return ball * shape.radius() + ends * shape.length()
        case Cylinder():
            flat = ball[:, :2] / np.linalg.norm(ball[:, :2], axis=1)[:, None]
            return np.column_stack([flat * shape.radius(), ends[:, 2] * shape.length()])
        case Box():
            return np.sign(ball) * shape.size() / 2


def test_a_shape_without_end_is_left_out():
    assert extents([Placed(HalfSpace(), RigidTransform())]) == []
