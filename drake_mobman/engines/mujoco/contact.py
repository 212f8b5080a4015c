"""A plant's contacts in MuJoCo: its shapes, stiffness and friction, pair by pair."""

import dataclasses as dc
import itertools
import math
from typing import Any

import mujoco
from pydrake.geometry import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Sphere,
)
from pydrake.multibody.tree import BodyIndex

from drake_mobman.parameters import ParameterError

_GEOM = mujoco.mjtGeom

_QUICKEST = 0.3
"""Largest angle by which a contact may swing in a step [rad]: it is stable below 1."""

_LEAST_IMPEDANCE = 0.5
"""Least share of a contact's acceleration that MuJoCo lets its spring decide."""

_BRAKING = 200.0
"""Rate at which friction stops a slip where it can [1/s]. Faster, a slip lifts more.

MuJoCo leaves out how a contact's own axes turn: on an arc, a wheel slips aside by its
speed times its yaw rate over this.
"""


@dc.dataclass(frozen=True)
class Contact:
    """A geometry of the plant, and how it is in contact."""

    id: Any  # In the scene graph.
    body: int  # Index in the plant.
    name: str  # In MuJoCo.
    friction: float
    stiffness: float  # Infinite for a rigid one [N/m].


def add_contacts(
    spec: Any, plant: Any, scene_graph: Any, bodies: Any
) -> dict[str, float]:
    """Adds a plant's collision geometry to an `MjSpec`, and its pairs.

    Args:
        spec: of the plant's bodies.
        plant: registered with the scene graph.
        scene_graph: with its geometry.
        bodies: of the spec, by indices in the plant.

    Returns:
        The stiffness of each pair [N/m], by its name: MuJoCo sorts pairs by bodies.
    """
    inspector = scene_graph.model_inspector()
    contacts: list[Contact] = []
    for index, body in bodies.items():
        for id_ in plant.GetCollisionGeometriesForBody(
            plant.get_body(BodyIndex(index))
        ):
            name = f"geometry{len(contacts)}"
            _add_geom(
                body, name, inspector.GetShape(id_), inspector.GetPoseInFrame(id_)
            )
            properties = inspector.GetProximityProperties(id_)
            contacts.append(Contact(id_, index, name, **_material(properties)))
    stiffness = {}
    for a, b in itertools.combinations(contacts, 2):
        if a.body == b.body or inspector.CollisionFiltered(a.id, b.id):
            continue
        name = _add_pair(spec, a, b)
        stiffness[name] = 1.0 / (1.0 / a.stiffness + 1.0 / b.stiffness)
    return stiffness


def set_stiffness(model: Any, stiffness: dict[str, float]) -> None:
    """Sets how stiff a model's pairs are, by name [N/m], and damps them critically.

    A pair at rest bears `S r / ((1 - d) A)` at a depth of r, with S the stiffness of
    its `solref`, d the impedance, and A the inverse of its apparent mass. It swings at
    `sqrt(S)`: so the nearer to 1 d is, the slower it is, and the more it lifts off
    where it slips. d is as small as the step allows.
    """
    fastest = (_QUICKEST / model.opt.timestep) ** 2
    for name, k in stiffness.items():
        i = model.pair(name).id
        bodies = model.geom_bodyid[[model.pair_geom1[i], model.pair_geom2[i]]]
        A = model.body_invweight0[bodies, 0].sum()
        S = min((1.0 - _LEAST_IMPEDANCE) * k * A, fastest)
        d = 1.0 - S / (k * A)
        model.pair_solimp[i, :2] = d
        model.pair_solref[i] = [-S, -2.0 * math.sqrt(S)]
        model.pair_solreffriction[i] = [-S, -_BRAKING * d]


def _material(properties: Any) -> dict[str, float]:
    """Returns friction and stiffness of a geometry."""
    friction = properties.GetProperty("material", "coulomb_friction")
    stiffness = properties.GetProperty("material", "point_contact_stiffness")
    return {"friction": friction.dynamic_friction(), "stiffness": stiffness}


def _add_geom(body: Any, name: str, shape: Any, X_BG: Any) -> None:
    """Adds a shape to a body; it touches only what it has a pair with."""
    kind, size = _shape(shape)
    body.add_geom(
        name=name,
        type=kind,
        size=[*size, *[0.0] * (3 - len(size))],
        pos=X_BG.translation(),
        quat=X_BG.rotation().ToQuaternion().wxyz(),
        contype=0,
        conaffinity=0,
        mass=0.0,
    )


def _shape(shape: Any) -> tuple[Any, list[float]]:
    """Returns kind and size of a geometry in MuJoCo."""
    match shape:
        case Sphere():
            return _GEOM.mjGEOM_SPHERE, [shape.radius()]
        case Box():
            return _GEOM.mjGEOM_BOX, [x / 2 for x in shape.size()]
        case Cylinder():
            return _GEOM.mjGEOM_CYLINDER, [shape.radius(), shape.length() / 2]
        case Capsule():
            return _GEOM.mjGEOM_CAPSULE, [shape.radius(), shape.length() / 2]
        case Ellipsoid():
            return _GEOM.mjGEOM_ELLIPSOID, [shape.a(), shape.b(), shape.c()]
        case HalfSpace():
            return _GEOM.mjGEOM_PLANE, [0.0, 0.0, 1.0]
    name = type(shape).__name__
    raise ParameterError("engine", "!Mujoco", f"cannot have a {name} touch anything")


def _add_pair(spec: Any, a: Contact, b: Contact) -> str:
    """Adds two geometries that may touch, with Drake's friction; returns the name."""
    name = f"{a.name}, {b.name}"
    both = a.friction + b.friction
    mu = 2.0 * a.friction * b.friction / both if both else 0.0
    spec.add_pair(
        name=name,
        geomname1=a.name,
        geomname2=b.name,
        condim=3 if mu else 1,
        friction=[mu, mu, 0.0, 0.0, 0.0],
    )
    return name
