"""The floor: friction, slope, patches of other friction or height, and bumps."""

import dataclasses as dc
import itertools
import math
from collections.abc import Iterator
from typing import Any

from pydrake.geometry import (
    AddContactMaterial,
    Box,
    Cylinder,
    ProximityProperties,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import CoulombFriction

from drake_mobman.parameters import PLACE, ParameterError, Range, in_order, within

GRAVITY = 9.81
"""[m/s^2]."""

SLIPPERY = 0.0
"""Friction of what slides freely on any floor."""

_GRIPPY = 1e6
"""Friction of a tyre: so the floor alone decides, see `floor_friction`."""

_RIGID = 1e12
"""Stiffness of the floor [N/m]: so the tyres alone give way."""

_EDGE, _DEPTH = 2e4, 1.0
"""How far boxes of the floor go, out and down [m]."""

_MOST_PATCHES = 8
_FRICTION = Range(0.0, 2.0)
_SLOPE = Range(-0.5, 0.5, "rad")
_HEIGHT = Range(-0.2, 0.2, "m")


@dc.dataclass
class Patch:
    """A rectangle of the floor with a friction and a height of its own."""

    x_min: float = 0.5  # In W [m].
    x_max: float = 100.0  # [m].
    y_min: float = -100.0  # [m].
    y_max: float = 100.0  # [m].
    friction: float = 0.9  # Of tyres on it.
    height: float = 0.0  # Above the rest of the floor; below 0 it is a step down [m].

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, PLACE, "x_min", "x_max", "y_min", "y_max")
        in_order(self, "x_min", "x_max")
        in_order(self, "y_min", "y_max")
        within(self, _FRICTION, "friction")
        within(self, _HEIGHT, "height")

    def holds(self, x: float, y: float) -> bool:
        """Returns whether a point of W is in it."""
        return self.x_min <= x <= self.x_max and self.y_min <= y <= self.y_max


@dc.dataclass
class Bump:
    """A round cable cover across the floor, along y.

    Under one wheel, or wide enough for both.
    """

    x: float = 0.5  # Its middle in W [m].
    y: float = 0.3  # [m].
    width: float = 0.4  # Along y [m].
    length: float = 0.2  # Along x [m].
    height: float = 0.01  # [m].
    friction: float = 0.9  # Of tyres on it.

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, PLACE, "x", "y")
        within(self, Range(0.01, 100.0, "m"), "width")
        within(self, Range(0.01, 2.0, "m"), "length")
        within(self, Range(1e-4, 0.1, "m"), "height")
        within(self, _FRICTION, "friction")
        if self.height > self.length / 2:
            valid = f"must be at most half of length = {self.length!r}"
            raise ParameterError("height", self.height, valid)

    @property
    def radius(self) -> float:
        """Returns the radius of its round [m]: of chord `length`, rise `height`."""
        return ((self.length / 2) ** 2 + self.height**2) / (2 * self.height)

    def top(self, x: float, y: float) -> float:
        """Returns how high it is above a point of the floor [m]; 0 beside it."""
        ahead = abs(x - self.x)
        if ahead >= self.length / 2 or abs(y - self.y) > self.width / 2:
            return 0.0
        return math.sqrt(self.radius**2 - ahead**2) - (self.radius - self.height)


@dc.dataclass
class Floor:
    """A plane with faults. W lies on it: a slope turns gravity, not W."""

    friction: float = 0.9  # Coulomb's, of tyres on the floor.
    slope: float = 0.0  # How steeply the floor rises along W's x [rad].
    cross_slope: float = 0.0  # The same along W's y [rad].
    # Rectangles of other friction or height; where two overlap, the last counts.
    patches: list[Patch] = dc.field(default_factory=list)
    bumps: list[Bump] = dc.field(default_factory=list)  # Cable covers.

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, _FRICTION, "friction")
        within(self, _SLOPE, "slope", "cross_slope")
        for key in ("patches", "bumps"):
            if len(getattr(self, key)) > _MOST_PATCHES:
                valid = f"must hold {_MOST_PATCHES} at most"
                raise ParameterError(key, f"{len(getattr(self, key))} of them", valid)

    def gravity_W(self) -> list[float]:
        """Returns the acceleration of gravity (3,) in W [m/s^2]."""
        x, y = math.sin(self.slope), math.sin(self.cross_slope)
        down = math.sqrt(1.0 - x * x - y * y)
        return [-GRAVITY * part for part in (x, y, down)]

    def height(self, x: float, y: float) -> float:
        """Returns the height in W of the floor's surface at a point of W [m]."""
        patch = self._at(x, y)
        bumps = max((bump.top(x, y) for bump in self.bumps), default=0.0)
        return (patch.height if patch else 0.0) + bumps

    def add_to(self, plant: Any) -> None:
        """Adds the floor to a plant with a scene graph."""
        plant.mutable_gravity_field().set_gravity_vector(self.gravity_W())
        world = plant.world_body()
        for i, (shape, X_WG, friction) in enumerate(self._shapes()):
            properties = contact_properties(floor_friction(friction), _RIGID, 0.0)
            plant.RegisterCollisionGeometry(world, X_WG, shape, f"floor{i}", properties)

    def _shapes(self) -> Iterator[tuple[Any, RigidTransform, float]]:
        """Yields shapes, their poses in W, and friction."""
        yield from self._boxes()
        for bump in self.bumps:
            along_y = RotationMatrix.MakeXRotation(math.pi / 2)
            p_WG = [bump.x, bump.y, bump.height - bump.radius]
            shape = Cylinder(bump.radius, bump.width)
            yield shape, RigidTransform(along_y, p_WG), bump.friction

    def _boxes(self) -> Iterator[tuple[Box, RigidTransform, float]]:
        """Yields the floor cut along the edges of all patches."""
        xs, ys = (
            sorted(
                {-_EDGE, _EDGE, *(getattr(p, e) for p in self.patches for e in ends)}
            )
            for ends in (("x_min", "x_max"), ("y_min", "y_max"))
        )
        for (x, x_end), (y, y_end) in itertools.product(
            itertools.pairwise(xs), itertools.pairwise(ys)
        ):
            middle = (x + x_end) / 2, (y + y_end) / 2
            patch = self._at(*middle)
            top = patch.height if patch else 0.0
            box = Box(x_end - x, y_end - y, _DEPTH)
            X_WG = RigidTransform([*middle, top - _DEPTH / 2])
            yield box, X_WG, patch.friction if patch else self.friction

    def _at(self, x: float, y: float) -> Patch | None:
        """Returns the patch at a point of W, if there is one."""
        holding = (patch for patch in reversed(self.patches) if patch.holds(x, y))
        return next(holding, None)


def floor_friction(wanted: float) -> float:
    """Returns the floor's coefficient that gives a tyre on it the wanted one.

    Drake combines two as 2 a b / (a + b).
    """
    return wanted * _GRIPPY / (2.0 * _GRIPPY - wanted)


def contact_properties(
    friction: float, stiffness: float, dissipation: float
) -> ProximityProperties:
    """Returns the properties of a shape in point contact.

    Args:
        friction: Coulomb's, static and dynamic.
        stiffness: of the contact [N/m].
        dissipation: of Hunt and Crossley [s/m].
    """
    properties = ProximityProperties()
    coulomb = CoulombFriction(friction, friction)
    AddContactMaterial(dissipation, stiffness, coulomb, properties)
    return properties


def tyre_properties(stiffness: float, dissipation: float) -> ProximityProperties:
    """Returns the properties of a tyre, whose friction the floor decides."""
    return contact_properties(_GRIPPY, stiffness, dissipation)
