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
    """A frame F in W at each of N samples, moved by n joints of one degree each.

    Samples come last: so numpy works on them in a row.
    """

    p_WF: np.ndarray  # (3, N) [m].
    R_WF: np.ndarray  # (3, 3, N).
    J: np.ndarray  # Velocity of F's origin by each joint's rate, in W (3, n, N).

    def velocity(self, v: np.ndarray) -> np.ndarray:
        """Returns the velocity of F's origin in W (3, N) [m/s], for rates (n, N)."""
        found: np.ndarray = np.einsum("ijk,jk->ik", self.J, v)
        return found

    def point(self, p_F: np.ndarray) -> np.ndarray:
        """Returns a point that is fixed in F at `p_F` (3,), in W (3, N) [m]."""
        return self.p_WF + _turned(self.R_WF, p_F)


def moved(plant: Any, frame: Any, q: np.ndarray) -> Moved:
    """Returns a frame at N samples.

    Args:
        plant: finalized; each of its moving joints has one degree of freedom.
        frame: F, of the plant.
        q: positions (n, N).
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
    n, samples = q.shape
    R = np.repeat(np.eye(3)[:, :, None], samples, axis=2)
    p = np.zeros((3, samples))
    turned, slid = np.zeros((2, 3, n, samples))
    # Positions are numbered from the base on: a joint comes before those it moves.
    for i in (joint.position_start() for joint in moving_joints(plant)):
        if not axes[:, i].any():
            continue  # It does not move F.
        turned[:, i] = _turned(R, turns[i])
        slid[:, i] = _turned(R, slides[i]) + _cross(p, turned[:, i])
        R_i, p_i = _exponential(turns[i], slides[i], q[i])
        p = p + np.einsum("ijk,jk->ik", R, p_i)
        R = R if R_i is None else np.einsum("ijn,jkn->ikn", R, R_i)
    p_WF = p + _turned(R, X_WF.translation())
    R_WF = np.einsum("ijn,jk->ikn", R, X_WF.rotation().matrix())
    return Moved(p_WF, R_WF, slid + _cross(turned, p_WF[:, None]))


def _exponential(
    w: np.ndarray, m: np.ndarray, angle: np.ndarray
) -> tuple[np.ndarray | None, np.ndarray]:
    """Returns rotations (3, 3, N) and places (3, N) that a joint moves W's origin to.

    Args:
        w: its axis of rotation (3,), or zero where it slides; then it turns nothing.
        m: velocity of W's origin where it moves by 1 (3,).
        angle: how far it moves (N,) [rad], or [m] where it slides.
    """
    if not w.any():
        return None, np.multiply.outer(m, angle)
    x, y, z = w
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    s, c = np.sin(angle), np.cos(angle)
    R = np.multiply.outer(K, s) + np.multiply.outer(K @ K, 1 - c)
    R += np.eye(3)[:, :, None]
    arm = np.cross(w, m)
    along = np.multiply.outer(w * (w @ m), angle)
    return R, arm[:, None] - _turned(R, arm) + along


def _turned(R: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Returns a vector (3,) turned by each of N rotations (3, N)."""
    return R[:, 0] * p[0] + R[:, 1] * p[1] + R[:, 2] * p[2]


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Returns cross products of vectors whose components come first."""
    return np.stack(
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    )
