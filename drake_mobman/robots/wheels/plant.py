"""A robot in a plant on its own wheels, which nothing but the tyres holds.

Wheels touch the floor as spheres: in point contact, cylinders jump from rim to rim. The
tyres are stiff, else they roll short by what they are pressed in, and well damped.
"""

import dataclasses as dc
from typing import Any

import numpy as np
from pydrake.geometry import SceneGraph, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import (
    ContactModel,
    DiscreteContactApproximation,
    MultibodyPlant,
)
from pydrake.multibody.tree import PdControllerGains, RpyFloatingJoint

from drake_mobman.frames import body
from drake_mobman.parameters import checked
from drake_mobman.robot_model import RobotDescription
from drake_mobman.robot_model.model import moving_joints
from drake_mobman.robot_model.rolling import RollingBase
from drake_mobman.robots.wheels.floor import (
    SLIPPERY,
    contact_properties,
    tyre_properties,
)

_STICTION = 1e-4
"""Speed at which a tyre is taken to slip [m/s]."""

_CASTER_STIFFNESS = 1e6
"""[N/m]."""


@dc.dataclass(frozen=True)
class Contact:
    """A sphere that touches the floor."""

    body: Any  # That it is fixed to, a wheel or the base.
    p_BC: np.ndarray  # Its centre in that body (3,) [m].
    radius: float  # [m].


@dc.dataclass(frozen=True)
class RollingPlant:
    """A robot's finalized `MultibodyPlant` on its wheels, and where its parts are."""

    plant: Any
    scene_graph: Any
    base: RollingBase
    floating: Any  # Joint from W to B.
    arm: list[Any]  # Joints, in the order of their positions.
    contacts: list[Contact]
    stepped: Any  # What steps the plant in a diagram, and has its ports.

    @property
    def arm_q(self) -> list[int]:
        """Returns the arm's places among the plant's positions."""
        return [joint.position_start() for joint in self.arm]

    @property
    def arm_v(self) -> list[int]:
        """Returns the arm's places among the plant's velocities."""
        return [joint.velocity_start() for joint in self.arm]

    @property
    def wheel_q(self) -> list[int]:
        """Returns the driven wheels' places among the plant's positions."""
        wheels = (*self.base.left, *self.base.right)
        return [joint.position_start() for joint in wheels]

    def positions(self, start: Any, z: float = 0.0) -> np.ndarray:
        """Returns positions of the plant, the base upright.

        Args:
            start: positions (3 + n,) of base and arm.
            z: height of B in W [m].
        """
        x, y, theta, *arm = start
        q = np.zeros(self.plant.num_positions())
        at = self.floating.position_start()
        q[at : at + 6] = [0.0, 0.0, theta, x, y, z]
        q[self.arm_q] = arm
        return q


def rolling_plant(
    robot: RobotDescription, params: Any, *, free_arm: bool
) -> RollingPlant:
    """Returns the plant of a robot on its wheels.

    Args:
        robot: its parameters.
        params: of fidelity `Wheels`.
        free_arm: whether the arm is free to be pulled by hand, else driven.

    Raises:
        ParameterError: where the robot has no wheels.
    """
    plant = MultibodyPlant(params.step)
    # As at fidelity `servo`: the robot gets what is logged.
    plant.SetUseSampledOutputPorts(False)
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kLagged)
    plant.set_contact_model(ContactModel.kPoint)
    plant.set_stiction_tolerance(_STICTION)
    base = checked(robot.add_rolling_to(plant))
    B = body(plant, "base")
    floating = plant.AddJoint(
        RpyFloatingJoint("floating", plant.world_frame(), B.body_frame())
    )
    _set_servos(plant, base, params, free_arm=free_arm)
    # After the robot was added: its own shapes touch nothing.
    scene_graph = SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    params.floor.add_to(plant)
    contacts = _add_contacts(plant, base, params)
    plant.Finalize()
    wheels = {joint.index() for joint in (*base.left, *base.right)}
    arm = [
        joint
        for joint in moving_joints(plant)
        if joint.index() not in wheels and joint.index() != floating.index()
    ]
    return RollingPlant(plant, scene_graph, base, floating, arm, contacts, plant)


def _set_servos(plant: Any, base: RollingBase, params: Any, *, free_arm: bool) -> None:
    """Gives each actuator its gains, before the plant is finalized."""
    wheels = {joint.index() for joint in (*base.left, *base.right)}
    for actuator in map(plant.get_joint_actuator, plant.GetJointActuatorIndices()):
        joint = actuator.joint()
        if joint.index() in wheels:
            gains = PdControllerGains(p=0.0, d=params.drive.gain)
        elif free_arm:
            joint.set_default_damping(params.joint_damping)
            if not params.joint_stiffness:
                continue
            gains = PdControllerGains(p=params.joint_stiffness, d=0.0)
        else:
            gains = PdControllerGains(p=0.0, d=params.arm_gain)
        actuator.set_controller_gains(gains)


def _add_contacts(plant: Any, base: RollingBase, params: Any) -> list[Contact]:
    """Adds tyres, with their true radii, and casters."""
    contacts = []
    tyre = tyre_properties(params.stiffness, params.dissipation)
    for joints, ratio in (
        (base.left, params.drive.left_radius),
        (base.right, params.drive.right_radius),
    ):
        for joint in joints:
            child, radius = joint.child_body(), ratio * base.wheel_radius
            X_BC = joint.frame_on_child().GetFixedPoseInBodyFrame()
            contacts.append(Contact(child, X_BC.translation(), radius))
            _register(plant, contacts[-1], f"{joint.name()}_tyre", tyre)
    smooth = contact_properties(SLIPPERY, _CASTER_STIFFNESS, params.dissipation)
    for i, caster in enumerate(base.casters):
        p_BC = np.array([caster.x, caster.y, caster.radius])
        contacts.append(Contact(body(plant, "base"), p_BC, caster.radius))
        _register(plant, contacts[-1], f"caster{i}", smooth)
    return contacts


def _register(plant: Any, contact: Contact, name: str, properties: Any) -> None:
    shape, X_BC = Sphere(contact.radius), RigidTransform(contact.p_BC)
    plant.RegisterCollisionGeometry(contact.body, X_BC, shape, name, properties)
