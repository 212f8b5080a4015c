"""Some poses of the robot that show its way through a run."""

import numpy as np

from drake_mobman import signals
from drake_mobman.analysis.motion import holding
from drake_mobman.simulation.run import Run

BASE_RADIUS = 0.27
"""Of the base in the robots' URDFs [m]."""

_POSES = 8  # Drawn at most.
_STRETCH = 3.0  # Weight of the arm's pose against the base's.
_ALIKE = 0.01  # Poses nearer to each other than this count as one [m].


def positions(run: Run) -> np.ndarray:
    """Returns positions of base and arm (N, 3 + n)."""
    return np.hstack([run[signals.BASE_POSE], run[signals.ARM_POSITION]])


def moments(run: Run) -> np.ndarray:
    """Returns the samples of up to `_POSES` poses, the first and the last among them.

    Each further one is where the robot's pose differs most from those chosen before, by
    the position of its front in W and of T in B. So a robot at rest is drawn once.
    """
    x, y, theta = run[signals.BASE_POSE].T
    x, y = x + BASE_RADIUS * np.cos(theta), y + BASE_RADIUS * np.sin(theta)
    poses = np.column_stack([x, y, _STRETCH * run[signals.P_BT]])
    chosen = [0, len(poses) - 1]
    while len(chosen) < _POSES:
        unlike = np.linalg.norm(poses[:, None] - poses[chosen], axis=2).min(axis=1)
        if np.max(unlike) < _ALIKE:
            break
        chosen.append(int(np.argmax(unlike)))
    return np.unique(chosen)


def while_held(run: Run, x: np.ndarray) -> np.ndarray:
    """Returns `x` (N, size) with NaN where the hand has let go."""
    return np.where(holding(run)[:, None], x, np.nan)
