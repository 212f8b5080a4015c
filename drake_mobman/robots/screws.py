"""Forward kinematics of many samples at once, by the plant's own screws.

Read once from a `MultibodyPlant`: where a body is at zero positions, and its Jacobian
there, which gives each joint's axis. A product of exponentials then moves the body.
No code of an arm's laws is used, so an error in those shows in what this measures.
"""

import dataclasses as dc
from typing import Any

import numpy as np
from pydrake.multibody.tree import JacobianWrtVariable

from drake_mobman.robot_model.model import moving_joints


@dc.dataclass(frozen=True)
class Moved:
    """A frame F in W at each of N samples, moved by n joints of one degree each."""

    p_WF: np.ndarray  # (N, 3) [m].
    R_WF: np.ndarray  # (N, 3, 3).
    J: np.ndarray  # Velocity of F's origin by each joint's rate, in W (N, 3, n).

    def velocity(self, v: np.ndarray) -> np.ndarray:
        """Returns the velocity of F's origin in W (N, 3) [m/s], for rates (N, n)."""
        found: np.ndarray = np.einsum("kij,kj->ki", self.J, v)
        return found

    def point(self, p_F: np.ndarray) -> np.ndarray:
        """Returns a point that is fixed in F at `p_F` (3,), in W (N, 3) [m]."""
        found: np.ndarray = self.p_WF + self.R_WF @ p_F
        return found


def moved(plant: Any, frame: Any, q: np.ndarray) -> Moved:
    """Returns a frame at N samples.

    Args:
        plant: finalized; each of its moving joints has one degree of freedom.
        frame: F, of the plant.
        q: positions (N, n).
    """
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, np.zeros(plant.num_positions()))
    W = plant.world_frame()
    X_WF = frame.CalcPoseInWorld(context)
    wrt = JacobianWrtVariable.kV
    axes = plant.CalcJacobianSpatialVelocity(context, wrt, frame, np.zeros(3), W, W)
    turns = axes[:3].T
    # Velocities of the point of F that is at W's origin.
    slides = axes[3:].T - np.cross(turns, X_WF.translation())
    samples, n = q.shape
    R, p = np.tile(np.eye(3), (samples, 1, 1)), np.zeros((samples, 3))
    turned, slid = np.zeros((2, samples, n, 3))
    # Positions are numbered from the base on: a joint comes before those it moves.
    for i in (joint.position_start() for joint in moving_joints(plant)):
        if not axes[:, i].any():
            continue  # It does not move F.
        turned[:, i] = R @ turns[i]
        slid[:, i] = R @ slides[i] + np.cross(p, turned[:, i])
        R_i, p_i = _exponential(turns[i], slides[i], q[:, i])
        p = p + np.einsum("kij,kj->ki", R, p_i)
        R = R @ R_i
    p_WF = p + R @ X_WF.translation()
    J = slid + np.cross(turned, p_WF[:, None])
    return Moved(p_WF, R @ X_WF.rotation().matrix(), J.transpose(0, 2, 1))


def _exponential(
    w: np.ndarray, m: np.ndarray, angle: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Returns rotations (N, 3, 3) and places (N, 3) that a joint moves W's origin to.

    Args:
        w: its axis of rotation (3,), or zero where it slides.
        m: velocity of W's origin where it moves by 1 (3,).
        angle: how far it moves (N,) [rad], or [m] where it slides.
    """
    x, y, z = w
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    s, c = np.sin(angle)[:, None, None], (1 - np.cos(angle))[:, None, None]
    R = np.eye(3) + s * K + c * (K @ K)
    along = np.outer(angle, w * (w @ m) if w.any() else m)
    return R, (np.eye(3) - R) @ np.cross(w, m) + along
