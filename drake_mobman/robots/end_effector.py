"""The end effector's position and velocity, by forward kinematics of the plant.

Metrics and figures use this, and no code of a decomposer or a sensor.
"""

import dataclasses as dc

import numpy as np

from drake_mobman.frames import body
from drake_mobman.robot_model import BASE_JOINTS, RobotModel
from drake_mobman.robot_model.model import moving_joints


@dc.dataclass(frozen=True)
class EndEffectorStates:
    """The end effector E and the shoulder S in W, at each of N samples."""

    p_WE: np.ndarray  # (N, 3) [m].
    p_WS: np.ndarray  # (N, 3) [m].
    v_WE: np.ndarray  # (N, 3) [m/s].

    @property
    def p_SE_W(self) -> np.ndarray:
        """Returns the position of E from S, in W's axes (N, 3) [m]."""
        return self.p_WE - self.p_WS


def ee_states(
    model: RobotModel, q: np.ndarray, v: np.ndarray | None = None
) -> EndEffectorStates:
    """Returns the end effector's states, from the model's `MultibodyPlant`.

    S is the origin of the arm's first joint, fixed to the body that carries the arm.

    Args:
        model: of the robot.
        q: positions of base and arm (N, 3 + n).
        v: their rates (N, 3 + n); zero unless given.
    """
    plant = model.plant
    context = plant.CreateDefaultContext()
    E = body(plant, "tool")
    first = moving_joints(plant)[BASE_JOINTS].frame_on_parent()
    carrier, p_CS = first.body(), first.GetFixedPoseInBodyFrame().translation()
    p_WE, p_WS, v_WE = np.zeros((3, len(q), 3))
    for k in range(len(q)):
        plant.SetPositions(context, q[k])
        p_WE[k] = plant.EvalBodyPoseInWorld(context, E).translation()
        p_WS[k] = plant.EvalBodyPoseInWorld(context, carrier).multiply(p_CS)
        if v is not None:
            plant.SetVelocities(context, v[k])
            V_WE = plant.EvalBodySpatialVelocityInWorld(context, E)
            v_WE[k] = V_WE.translational()
    return EndEffectorStates(p_WE, p_WS, v_WE)
