"""The end effector's position and velocity, by forward kinematics of the plant.

Metrics and figures use this, and no code of a decomposer or a sensor.
"""

import dataclasses as dc

import numpy as np

from drake_mobman.arm.chain import chain_of
from drake_mobman.arm.shoulder import shoulder_of
from drake_mobman.frames import body
from drake_mobman.robot_model import BASE_JOINTS, RobotModel


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

    S is fixed to the base, where the plant has the shoulder in the first sample.

    Args:
        model: of the robot.
        q: positions of base and arm (N, 3 + n).
        v: their rates (N, 3 + n); zero unless given.
    """
    plant = model.plant
    context = plant.CreateDefaultContext()
    E = body(plant, "tool")
    B = body(plant, "base")
    p_BS = shoulder_of(chain_of(plant), q[0, BASE_JOINTS:]).p_BS
    p_WE, p_WS, v_WE = np.zeros((3, len(q), 3))
    for k in range(len(q)):
        plant.SetPositions(context, q[k])
        p_WE[k] = plant.EvalBodyPoseInWorld(context, E).translation()
        p_WS[k] = plant.EvalBodyPoseInWorld(context, B).multiply(p_BS)
        if v is not None:
            plant.SetVelocities(context, v[k])
            V_WE = plant.EvalBodySpatialVelocityInWorld(context, E)
            v_WE[k] = V_WE.translational()
    return EndEffectorStates(p_WE, p_WS, v_WE)
