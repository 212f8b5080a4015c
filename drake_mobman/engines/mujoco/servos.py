"""Servos with bounded torques, solved for together with the contacts.

MuJoCo's own actuators put out a torque by the last state: a stiff one chatters, and a
bounded one has no implicit derivative that would stop it. So a servo is a row of the
constraint solver here: dry friction, a bounded torque towards a velocity of zero, which
is made to aim at another velocity with a gain of its own. That is how Drake's discrete
plant solves for its servos, too.
"""

from typing import Any

import numpy as np

_UNBOUNDED = 1e12
"""Stands for an infinite limit of a torque [N m] or force [N]."""


class Servos:
    """The servos of a plant in its MuJoCo model.

    Args:
        actuators: of the plant (K,), each with a controller, of a joint that moves in
            one direction.
        model: of MuJoCo; its rows of dry friction become those of the servos.
        dofs: of their joints in the model (K,).
    """

    def __init__(self, actuators: list[Any], model: Any, dofs: np.ndarray) -> None:
        gains = [actuator.get_controller_gains() for actuator in actuators]
        self.stiffness = np.array([gain.p for gain in gains])  # [N m/rad] or [N/m].
        self.damping = np.array([gain.d for gain in gains])  # [N m s] or [N s/m].
        limits = [min(actuator.effort_limit(), _UNBOUNDED) for actuator in actuators]
        self.dofs = dofs
        self.step = float(model.opt.timestep)
        model.dof_frictionloss[:] = 0.0
        model.dof_frictionloss[dofs] = limits
        self._rows = np.argsort(np.argsort(dofs))  # They are in the order of the dofs.

    def aim(self, data: Any, q_d: Any, v_d: Any, torque: Any) -> None:
        """Sets what the servos are to reach, between `mj_step1` and `mj_step2`.

        With v the velocity at the end of a step of h, a servo's torque is
        `p (q_d - q - h v) + d (v_d - v) + torque = (d + h p) (aim - v)`, in its limits.

        Args:
            data: of MuJoCo.
            q_d: desired positions (K,).
            v_d: desired velocities (K,).
            torque: added to the servos' own (K,).
        """
        h, p, d = self.step, self.stiffness, self.damping
        gain = d + h * p
        aim = (p * (q_d - data.qpos[self.dofs]) + d * v_d + torque) / gain
        data.efc_aref[self._rows] = (aim - data.qvel[self.dofs]) / h
        data.efc_D[self._rows] = h * gain
        data.efc_R[self._rows] = 1.0 / (h * gain)

    def torques(self, data: Any) -> np.ndarray:
        """Returns the torques of the last step (K,)."""
        return np.array(data.efc_force[self._rows])
