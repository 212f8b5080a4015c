"""The end effector's position and velocity, by forward kinematics of the plant.

Metrics and figures use this, and no code of a decomposer or a sensor.
"""

import dataclasses as dc

import numpy as np

from drake_mobman.arm.chain import chain_of
from drake_mobman.arm.shoulder import shoulder_of
from drake_mobman.frames import body, frame
from drake_mobman.robot_model import BASE_JOINTS, RobotModel
from drake_mobman.robots.screws import moved


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
    p_BS = shoulder_of(chain_of(plant), q[0, BASE_JOINTS:]).p_BS
    rows = np.ascontiguousarray(q.T)
    E = moved(plant, body(plant, "tool").body_frame(), rows)
    B = moved(plant, body(plant, "base").body_frame(), rows)
    v_WE = np.zeros_like(E.p_WF) if v is None else E.velocity(v.T)
    return EndEffectorStates(E.p_WF.T, B.point(p_BS).T, v_WE.T)


def manipulabilities(model: RobotModel, q: np.ndarray) -> np.ndarray:
    """Returns sqrt(det(J J^T)) of T's velocity in B by the arm's joints (N,).

    For an arm with fewer than three joints, sqrt(det(J^T J)).

    Args:
        model: of the robot.
        q: positions of base and arm (N, 3 + n).
    """
    plant = model.plant
    # In W's axes, which turn the rows of J and leave the determinant as it is.
    rows = np.ascontiguousarray(q.T)
    J = moved(plant, frame(plant, "tee"), rows).J[:, BASE_JOINTS:]
    pairs = "ijk,ljk->kil" if J.shape[1] >= 3 else "ijk,ilk->kjl"
    gram = np.einsum(pairs, J, J)
    found: np.ndarray = np.sqrt(np.maximum(np.linalg.det(gram), 0.0))
    return found
