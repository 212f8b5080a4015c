"""The floor under wheels: its friction, patches, bumps and slope."""

import math

import numpy as np
import pytest
from pydrake.geometry import Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_mobman.parameters import ParameterError, checked
from drake_mobman.robots.wheels.floor import Bump, Floor, Patch, tyre_properties

G = 9.81

STEP = 0.001

COULOMB = 0.02
"""Relative: by which a sled's deceleration may miss Coulomb's, as its feet give way."""


class Sled:
    """A body on three feet of a tyre's rubber, that slides on a floor."""

    def __init__(self, floor, v=(0.0, 0.0), at=(0.0, 0.0)):
        builder = DiagramBuilder()
        self.plant, _ = AddMultibodyPlantSceneGraph(builder, STEP)
        inertia = SpatialInertia(
            10.0, [0, 0, 0.02], UnitInertia.SolidBox(0.5, 0.5, 0.1)
        )
        self.sled = self.plant.AddRigidBody("sled", inertia)
        rubber = tyre_properties(1e6, 100.0)
        for i in range(3):
            turn = 2 * math.pi * i / 3
            foot = [0.3 * math.cos(turn), 0.3 * math.sin(turn), 0.05]
            self.plant.RegisterCollisionGeometry(
                self.sled, RigidTransform(foot), Sphere(0.05), f"foot{i}", rubber
            )
        checked(floor).add_to(self.plant)
        self.plant.Finalize()
        self.simulator = Simulator(builder.Build())
        self.context = self.plant.GetMyMutableContextFromRoot(
            self.simulator.get_mutable_context()
        )
        z = max(floor.height(at[0] + x, at[1]) for x in (-0.15, 0.3))
        self.plant.SetFreeBodyPose(self.context, self.sled, RigidTransform([*at, z]))
        q = self.plant.GetVelocities(self.context)
        q[3:5] = v
        self.plant.SetVelocities(self.context, q)

    def after(self, time):
        """Returns place and velocity (3,) at a time."""
        self.simulator.AdvanceTo(time)
        X = self.plant.EvalBodyPoseInWorld(self.context, self.sled)
        V = self.plant.EvalBodySpatialVelocityInWorld(self.context, self.sled)
        return X.translation(), V.translational()


@pytest.mark.parametrize("friction", [0.05, 0.3, 0.9])
def test_a_tyre_that_slides_is_slowed_by_the_floors_friction(friction):
    sled = Sled(Floor(friction=friction), v=(2.0, 0.0))
    _, before = sled.after(0.05)
    _, after = sled.after(0.15)
    assert before[0] - after[0] == pytest.approx(friction * G * 0.1, rel=COULOMB)


def test_a_patch_has_its_own_friction_and_the_floor_beside_it_keeps_its_own():
    floor = Floor(friction=0.8, patches=[Patch(x_min=1.0, x_max=3.0, friction=0.1)])
    for x, friction in ((2.0, 0.1), (0.0, 0.8), (4.0, 0.8)):
        sled = Sled(floor, v=(0.0, 2.0), at=(x, 0.0))
        _, before = sled.after(0.05)
        _, after = sled.after(0.15)
        assert before[1] - after[1] == pytest.approx(friction * G * 0.1, rel=COULOMB)


def test_of_two_patches_that_overlap_the_last_counts():
    wide, narrow = Patch(x_min=0.0, height=0.01), Patch(x_min=1.0, height=-0.02)
    assert Floor(patches=[wide, narrow]).height(2.0, 0.0) == -0.02
    assert Floor(patches=[narrow, wide]).height(2.0, 0.0) == 0.01
    assert Floor(patches=[wide, narrow]).height(-1.0, 0.0) == 0.0


def test_a_sled_stands_at_a_patchs_height():
    sled = Sled(Floor(patches=[Patch(x_min=1.0, height=-0.02)]), at=(2.0, 0.0))
    p, _ = sled.after(0.2)
    assert p[2] == pytest.approx(-0.02, abs=1e-4)


@pytest.mark.parametrize(("friction", "slides"), [(0.09, True), (0.11, False)])
def test_on_a_slope_of_a_tenth_a_sled_slides_where_friction_is_less(friction, slides):
    floor = Floor(friction=friction, slope=math.atan(0.1))
    p, v = Sled(floor).after(1.0)
    assert (v[0] < -0.05) == slides  # Down, which is along -x.
    if slides:
        fall = G * math.sin(floor.slope) - friction * G * math.cos(floor.slope)
        assert v[0] == pytest.approx(-fall, rel=0.05)
    assert p[1] == pytest.approx(0.0, abs=1e-6)


def test_slopes_turn_gravity_and_keep_its_size():
    g = Floor(slope=0.2, cross_slope=-0.1).gravity_W()
    assert np.linalg.norm(g) == pytest.approx(G)
    assert g[0] == pytest.approx(-G * math.sin(0.2))
    assert g[1] == pytest.approx(G * math.sin(0.1))


def test_a_bump_is_round_as_high_as_told_and_as_long():
    bump = Bump(x=1.0, y=0.5, width=0.4, length=0.2, height=0.01)
    assert bump.top(1.0, 0.5) == pytest.approx(0.01)
    assert bump.top(0.9001, 0.5) == pytest.approx(0.0, abs=1e-4)
    # On a circle: three points have one radius.
    r = bump.radius
    for x in (1.0, 1.03, 1.07):
        assert math.hypot(x - 1.0, bump.top(x, 0.5) + r - 0.01) == pytest.approx(r)
    assert bump.top(1.0, 0.71) == bump.top(1.11, 0.5) == 0.0


def test_a_sled_on_a_bump_stands_on_its_top():
    # Its foot ahead is at the middle of the bump; the others are on the floor.
    sled = Sled(Floor(bumps=[Bump(x=0.3, y=0.0, height=0.01)]))
    p, _ = sled.after(0.2)
    assert p[2] == pytest.approx(0.01 / 3, abs=1e-3)


@pytest.mark.parametrize(
    ("floor", "says"),
    [
        (Floor(friction=-0.1), "friction: -0.1 is not valid; must be within [0, 2]"),
        (Floor(slope=0.6), "slope: 0.6 is not valid; must be within [-0.5, 0.5] rad"),
        (
            Floor(patches=[Patch(x_min=2.0, x_max=1.0)]),
            "patches[0].x_min: 2.0 is not valid; must be below x_max = 1.0",
        ),
        (
            Floor(bumps=[Bump(height=0.08, length=0.1)]),
            "bumps[0].height: 0.08 is not valid; must be at most half of length",
        ),
        (
            Floor(patches=[Patch()] * 9),
            "patches: '9 of them' is not valid; must hold 8",
        ),
        (Floor(friction=math.nan), "friction: nan is not valid; must be a finite"),
    ],
)
def test_a_floor_that_is_none_is_refused(floor, says):
    with pytest.raises(ParameterError) as refusal:
        checked(floor)
    assert says in str(refusal.value)
