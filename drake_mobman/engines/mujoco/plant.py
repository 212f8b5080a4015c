"""A `MultibodyPlant`'s place in a diagram, taken by MuJoCo."""

from typing import Any

import mujoco
import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.framework import (
    DiscreteStateIndex,
    InputPort,
    LeafSystem,
    OutputPort,
)

from drake_mobman.engines.mujoco.model import Mapping
from drake_mobman.engines.mujoco.servos import Servos

_FIRST_CONTACT = int(mujoco.mjtConstraint.mjCNSTR_CONTACT_FRICTIONLESS)
"""Kind of the solver's rows from which on they are of contacts."""


class MujocoPlant(LeafSystem):
    """Steps a MuJoCo model of a plant; its ports are named and ordered as the plant's.

    .. pydrake_system::

        name: MujocoPlant
        input_ports:
        - <instance>_actuation (for each with actuators)
        - <instance>_desired_state (for each with servos)
        - actuation
        - applied_generalized_force
        - applied_spatial_force
        output_ports:
        - state
        - <instance>_generalized_contact_forces (for each that moves)

    The state is the plant's: positions, then velocities; the accelerations from which
    the solver starts in the next step; and the forces of all contacts. `MjData` is
    overwritten by them at each step, so it holds nothing of its own.

    Torques of `actuation` and of an instance's port add up. The contacts' forces are
    means over the last step, and zero before the first.

    Args:
        plant: discrete, finalized; its default positions become the default state.
        model: of MuJoCo, made from it.
        mapping: from one to the other.
        substeps: of MuJoCo in a step of the plant.
    """

    def __init__(
        self, plant: Any, model: Any, mapping: Mapping, substeps: int = 1
    ) -> None:
        super().__init__()
        # MuJoCo would write a file. A state that is not finite ends the run by itself.
        mujoco.set_mju_user_warning(lambda _message: None)
        self.plant, self.model, self.substeps = plant, model, substeps
        self._data = mujoco.MjData(model)
        self._context = plant.CreateDefaultContext()  # Overwritten at each use.
        self._dofs = mapping.dofs(model)
        self._bodies = {i: mapping.body(model, i) for i in mapping.bodies}
        self._plain = plant.IsVelocityEqualToQDot()
        self._actuators = [
            plant.get_joint_actuator(i) for i in plant.GetJointActuatorIndices()
        ]
        driven = [x.joint().position_start() for x in self._actuators]
        self._driven = self._dofs[np.array(driven, dtype=int)]
        self._limits = np.array([x.effort_limit() for x in self._actuators])
        self._served = np.array([x.has_controller() for x in self._actuators], bool)
        own = [x for x in self._actuators if x.has_controller()]
        self._servos = Servos(own, model, self._driven[self._served])
        self._declare_state()
        self._declare_inputs()

    def get_state_output_port(self) -> OutputPort:
        """Returns the output of positions, then velocities."""
        return self._state

    def get_generalized_contact_forces_output_port(self, instance: Any) -> OutputPort:
        """Returns the output of the contacts' forces, by an instance's velocities."""
        return self._contact_forces[int(instance)]

    def get_actuation_input_port(self, instance: Any = None) -> InputPort:
        """Returns the input of torques for an instance's actuators, or for all."""
        if instance is None:
            return self._all_actuation
        return self._actuation[instance][0]

    def get_desired_state_input_port(self, instance: Any) -> InputPort:
        """Returns the input of desired positions, then velocities, of its actuators."""
        return self._desired[instance][0]

    def get_applied_generalized_force_input_port(self) -> InputPort:
        """Returns the input of forces by the plant's velocities."""
        return self._generalized

    def get_applied_spatial_force_input_port(self) -> InputPort:
        """Returns the input of forces on bodies."""
        return self._spatial

    def _declare_state(self) -> None:
        plant = self.plant
        at_rest = np.zeros(plant.num_velocities())
        start = np.concatenate([plant.GetDefaultPositions(), at_rest])
        motion = self.DeclareDiscreteState(start)
        self.DeclareDiscreteState(self.model.nv)
        self.DeclareDiscreteState(plant.num_velocities())
        self._state = self.DeclareStateOutputPort("state", motion)
        self._contact_forces: dict[int, OutputPort] = {}
        everything = np.arange(plant.num_velocities())
        for i in range(plant.num_model_instances()):
            instance = ModelInstanceIndex(i)
            at = plant.GetVelocitiesFromArray(instance, everything).astype(int)
            if not len(at):
                continue
            name = plant.GetModelInstanceName(instance)
            self._contact_forces[i] = self.DeclareVectorOutputPort(
                f"{name}_generalized_contact_forces",
                len(at),
                lambda context, output, at=at: output.SetFromVector(
                    context.get_discrete_state(2).value()[at]
                ),
                {self.discrete_state_ticket(DiscreteStateIndex(2))},
            )
        self.DeclarePeriodicDiscreteUpdateEvent(plant.time_step(), 0.0, self._update)

    def _declare_inputs(self) -> None:
        plant = self.plant
        instances = np.array([int(x.model_instance()) for x in self._actuators])
        self._actuation: dict[Any, tuple[InputPort, np.ndarray]] = {}
        self._desired: dict[Any, tuple[InputPort, np.ndarray]] = {}
        for x in self._actuators:
            instance = x.model_instance()
            if instance in self._actuation:
                continue
            at = np.flatnonzero(instances == int(instance))
            name = plant.GetModelInstanceName(instance)
            port = self.DeclareVectorInputPort(f"{name}_actuation", len(at))
            self._actuation[instance] = port, at
            if self._served[at].any():
                size = 2 * len(at)
                port = self.DeclareVectorInputPort(f"{name}_desired_state", size)
                self._desired[instance] = port, at
        self._all_actuation = self.DeclareVectorInputPort(
            "actuation", len(self._actuators)
        )
        self._generalized = self.DeclareVectorInputPort(
            "applied_generalized_force", plant.num_velocities()
        )
        self._spatial = self.DeclareAbstractInputPort(
            "applied_spatial_force", Value([ExternallyAppliedSpatialForce()])
        )

    def _update(self, context: Any, state: Any) -> None:
        data = self._data
        self._load(context)
        self._apply_forces(context)
        torques = self._torques(context)
        loose = ~self._served
        data.qfrc_applied[self._driven[loose]] += torques[loose].clip(
            -self._limits[loose], self._limits[loose]
        )
        q_d, v_d = self._desired_state(context)[:, self._served]
        pressed = np.zeros(self.model.nv)
        for _ in range(self.substeps):
            mujoco.mj_step1(self.model, data)
            self._servos.aim(data, q_d, v_d, torques[self._served])
            mujoco.mj_step2(self.model, data)
            pressed += self._pressed() / self.substeps
        state.get_mutable_vector(0).SetFromVector(self._motion())
        state.get_mutable_vector(1).SetFromVector(data.qacc_warmstart)
        force = pressed[self._dofs]
        if not self._plain:
            force = self.plant.MakeVelocityToQDotMap(self._context).T @ force
        state.get_mutable_vector(2).SetFromVector(force)

    def _pressed(self) -> np.ndarray:
        """Returns the forces of contacts of the last step, by `qvel`."""
        data, forces = self._data, np.zeros(self.model.nv)
        touching = data.efc_type >= _FIRST_CONTACT
        if touching.any():
            of_contacts = np.where(touching, data.efc_force, 0.0)
            mujoco.mj_mulJacTVec(self.model, data, forces, of_contacts)
        return forces

    def _load(self, context: Any) -> None:
        """Puts the state of a context into `MjData`, without any forces."""
        plant, data = self.plant, self._data
        x = context.get_discrete_state(0).CopyToVector()
        q, v = x[: plant.num_positions()], x[plant.num_positions() :]
        if self._plain:
            rates = v
        else:
            plant.SetPositions(self._context, q)
            rates = plant.MapVelocityToQDot(self._context, v)
        data.time = context.get_time()
        data.qpos[self._dofs], data.qvel[self._dofs] = q, rates
        data.qacc_warmstart[:] = context.get_discrete_state(1).CopyToVector()
        data.qfrc_applied[:] = 0.0
        data.xfrc_applied[:] = 0.0

    def _motion(self) -> np.ndarray:
        """Returns the plant's positions, then velocities, from `MjData`."""
        q, v = self._data.qpos[self._dofs], self._data.qvel[self._dofs]
        if not self._plain:
            self.plant.SetPositions(self._context, q)
            v = self.plant.MapQDotToVelocity(self._context, v)
        return np.concatenate([q, v])

    def _apply_forces(self, context: Any) -> None:
        """Puts the forces from outside into `MjData`, for the whole step."""
        data = self._data
        if self._generalized.HasValue(context):
            force = self._generalized.Eval(context)
            if not self._plain:
                force = self.plant.MakeQDotToVelocityMap(self._context).T @ force
            data.qfrc_applied[self._dofs] = force
        if not self._spatial.HasValue(context):
            return
        applied = self._spatial.Eval(context)
        if applied:
            mujoco.mj_kinematics(self.model, data)
            mujoco.mj_comPos(self.model, data)
        for one in applied:
            body = self._bodies[int(one.body_index)]
            R_WB = data.xmat[body].reshape(3, 3)
            p_W = data.xpos[body] + R_WB @ one.p_BoBq_B - data.xipos[body]
            force = one.F_Bq_W.translational()
            torque = one.F_Bq_W.rotational() + np.cross(p_W, force)
            data.xfrc_applied[body] += [*force, *torque]

    def _torques(self, context: Any) -> np.ndarray:
        """Returns the actuators' torques that are given, zero where they are not."""
        torques = np.zeros(len(self._actuators))
        if self._all_actuation.HasValue(context):
            torques += self._all_actuation.Eval(context)
        for port, at in self._actuation.values():
            if port.HasValue(context):
                torques[at] += port.Eval(context)
        return torques

    def _desired_state(self, context: Any) -> np.ndarray:
        """Returns desired positions and velocities of the actuators (2, K)."""
        desired = np.zeros((2, len(self._actuators)))
        for port, at in self._desired.values():
            desired[:, at] = port.Eval(context).reshape(2, -1)
        return desired
