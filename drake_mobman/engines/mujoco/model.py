"""A finished `MultibodyPlant` written down as a MuJoCo model.

Nothing is parsed again: bodies, joints and limits are read from the plant, so whatever
robot it holds, MuJoCo has the same. Each joint becomes one MuJoCo joint for each of its
positions, which then have the same values as Drake's.
"""

import dataclasses as dc
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.tree import (
    PrismaticJoint,
    RevoluteJoint,
    RpyFloatingJoint,
    WeldJoint,
)

from drake_mobman.engines.mujoco.contact import add_contacts, set_stiffness
from drake_mobman.parameters import ParameterError

_SLIDE, _HINGE = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE

_LEAST = 1e-12
"""Mass [kg] and inertia [kg m^2] of bodies that have none, as MuJoCo needs some."""

_ROLL, _PITCH, _YAW = np.eye(3)


@dc.dataclass(frozen=True)
class Mapping:
    """Where a plant's bodies and positions are in a MuJoCo model."""

    bodies: dict[int, str]  # Names in the model by indices in the plant.
    joints: list[str]  # Names in the model, in the order of the plant's positions.

    def dofs(self, model: Any) -> np.ndarray:
        """Returns indices in `qpos` and `qvel`, one for each of the plant's q."""
        return np.array([model.joint(name).dofadr[0] for name in self.joints])

    def body(self, model: Any, index: int) -> int:
        """Returns the index in the model of a body of the plant."""
        return int(model.body(self.bodies[index]).id)


def make_model(
    plant: Any, scene_graph: Any = None, *, substeps: int = 1, impratio: float = 1.0
) -> tuple[Any, Mapping]:
    """Returns an `MjModel` of a finalized plant, and the mapping between them.

    Args:
        plant: discrete and finalized.
        scene_graph: that it is registered with, where it has contacts.
        substeps: of the model in a step of the plant.
        impratio: friction's impedance over that of the normal force.

    Raises:
        ParameterError: where the plant has what a tree of joints cannot show.
    """
    if plant.num_constraints():
        raise _not_translated("a constraint")
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.compiler.boundmass = spec.compiler.boundinertia = _LEAST
    _set_options(spec.option, plant.time_step() / substeps, impratio)
    spec.option.gravity = plant.gravity_field().gravity_vector()
    bodies, mapping = _add_tree(spec, plant)
    stiffness = {}
    if scene_graph is not None:
        stiffness = add_contacts(spec, plant, scene_graph, bodies)
    _add_rotors(spec, plant, mapping)
    model = spec.compile()
    set_stiffness(model, stiffness)
    _set_damping(model, plant, mapping)
    return model, mapping


def _set_options(option: Any, step: float, impratio: float) -> None:
    """Sets how MuJoCo solves a step [s]."""
    option.timestep = step
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = impratio
    option.iterations, option.tolerance = 100, 1e-12
    # Servos change rows of the solver, of which islands have copies; and a state that
    # is not finite must not be reset, but end the run.
    off = mujoco.mjtDisableBit
    option.disableflags |= int(off.mjDSBL_ISLAND) | int(off.mjDSBL_AUTORESET)


def _add_rotors(spec: Any, plant: Any, mapping: Mapping) -> None:
    """Adds what the rotors of actuators add to the inertia of their joints."""
    for i in plant.GetJointActuatorIndices():
        actuator = plant.get_joint_actuator(i)
        name = mapping.joints[actuator.joint().position_start()]
        spec.joint(name).armature = actuator.default_reflected_inertia()


def _set_damping(model: Any, plant: Any, mapping: Mapping) -> None:
    """Damps joints as in the plant.

    Raises:
        ParameterError: where a joint is damped that moves in several directions.
    """
    for joint in map(plant.get_joint, plant.GetJointIndices()):
        damping = joint.default_damping_vector()
        if joint.num_velocities() == 1:
            name = mapping.joints[joint.position_start()]
            model.dof_damping[model.joint(name).dofadr[0]] = damping[0]
        elif any(damping):
            raise _not_translated(f"the damping of {joint.name()!r}")


def _add_tree(spec: Any, plant: Any) -> tuple[dict[int, Any], Mapping]:
    """Adds the plant's bodies; returns them by their indices, and the mapping."""
    made = {int(plant.world_body().index()): spec.worldbody}
    names = plant.GetPositionNames(add_model_instance_prefix=True)
    for joint, inboard, outboard in outward(plant):
        body = _add_body(made[int(inboard.index())], plant, outboard)
        _add_joint(body, joint, names, reversed_=outboard == joint.parent_body())
        made[int(outboard.index())] = body
    mapping = Mapping({index: body.name for index, body in made.items()}, names)
    return made, mapping


def outward(plant: Any) -> Iterator[tuple[Any, Any, Any]]:
    """Yields each joint with the body nearer to the world, and the one beyond."""
    waiting = [plant.get_joint(i) for i in plant.GetJointIndices()]
    reached = {plant.world_body().index()}
    while waiting:
        for joint in waiting:
            ends = [joint.parent_body(), joint.child_body()]
            inside = [end for end in ends if end.index() in reached]
            if len(inside) == 1:
                break
        else:
            raise _not_translated(f"a loop of joints at {waiting[0].name()!r}")
        waiting.remove(joint)
        (inboard,) = inside
        (outboard,) = (end for end in ends if end.index() not in reached)
        reached.add(outboard.index())
        yield joint, inboard, outboard


def _add_body(parent: Any, plant: Any, body: Any) -> Any:
    """Adds a body with its mass; its place follows with its joint."""
    added = parent.add_body(name=body.scoped_name().get_full())
    added.explicitinertial = True
    inertia = body.default_spatial_inertia()
    com = inertia.get_com()
    added.mass, added.ipos = inertia.get_mass(), com
    about_com = inertia.Shift(com).CalcRotationalInertia().CopyToFullMatrix3()
    added.fullinertia = [*about_com.diagonal(), *about_com[np.triu_indices(3, 1)]]
    added.gravcomp = 0.0 if plant.is_gravity_enabled(body.model_instance()) else 1.0
    return added


def _add_joint(body: Any, joint: Any, names: list[str], *, reversed_: bool) -> None:
    """Places a body, and adds its joint under the names of the plant's positions.

    Drake's joint is between frame F on its parent and M on its child. Where the child
    is nearer to the world, the parent moves the other way.
    """
    X_PF = joint.frame_on_parent().GetFixedPoseInBodyFrame()
    X_CM = joint.frame_on_child().GetFixedPoseInBodyFrame()
    X_FM = joint.X_FM() if isinstance(joint, WeldJoint) else RigidTransform()
    inner, outer = (X_CM, X_PF) if reversed_ else (X_PF, X_CM)
    between = X_FM.inverse() if reversed_ else X_FM
    X_IO = inner @ between @ outer.inverse()
    body.pos, body.quat = X_IO.translation(), X_IO.rotation().ToQuaternion().wxyz()
    sign = -1.0 if reversed_ else 1.0
    for offset, kind, axis in _axes(joint, reversed_=reversed_):
        added = body.add_joint(
            name=names[joint.position_start() + offset],
            type=kind,
            pos=outer.translation(),
            axis=sign * (outer.rotation() @ axis),
        )
        low, high = joint.position_lower_limits(), joint.position_upper_limits()
        if np.isfinite([low[offset], high[offset]]).all():
            added.limited = mujoco.mjtLimited.mjLIMITED_TRUE
            added.range = [low[offset], high[offset]]


def _axes(joint: Any, *, reversed_: bool) -> list[tuple[int, Any, np.ndarray]]:
    """Returns a joint as moves one after another: its position, kind and axis in F."""
    if isinstance(joint, WeldJoint):
        return []
    if isinstance(joint, RevoluteJoint):
        return [(0, _HINGE, joint.revolute_axis())]
    if isinstance(joint, PrismaticJoint):
        return [(0, _SLIDE, joint.translation_axis())]
    if isinstance(joint, RpyFloatingJoint) and not reversed_:
        slides = [(3 + i, _SLIDE, axis) for i, axis in enumerate(np.eye(3))]
        turns = [(2, _HINGE, _YAW), (1, _HINGE, _PITCH), (0, _HINGE, _ROLL)]
        return [*slides, *turns]
    raise _not_translated(f"{type(joint).__name__} {joint.name()!r}")


def _not_translated(what: str) -> ParameterError:
    return ParameterError("engine", "!Mujoco", f"cannot simulate {what}")
