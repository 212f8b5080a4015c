"""How a base with several driven wheels on a side turns: all of them scrub."""

import numpy as np

from drake_mobman.scalars import Matrix

_STEPS = 500
"""Of reweighting; each halves the error about, or better."""

_SLOW = 1e-9
"""Of a tyre on the floor, in place of zero [m/s]."""


def wheel_loads(places: Matrix, centre: Matrix) -> Matrix:
    """Returns the share of the weight that each wheel carries (N,).

    As springs of one stiffness do under a stiff base; no wheel pulls.

    Args:
        places: of the wheels on the floor in B (N, 2) [m].
        centre: of mass in B, from above (2,) [m].
    """
    A = np.vstack([np.ones(len(places)), places.T])
    shares: Matrix = np.linalg.pinv(A) @ np.append(1.0, centre)
    shares = np.maximum(shares, 0.0)
    return shares / shares.sum()


def skid_track(places: Matrix, loads: Matrix) -> float:
    """Returns the track t by which a base turns on the spot [m].

    At wheel speeds of -u on the left and u on the right, it turns at 2 u / t. Friction
    is that of Coulomb, the same on all wheels. The base moves so that forces and moment
    balance: the power that friction takes is then least, and it is convex. Where the
    loads are alike, t is T + 4 mean(x^2) / T for wheels T apart, x ahead of their
    middle; with all of the load on one axle, it is T.

    Args:
        places: of the wheels on the floor in B (N, 2) [m], to the left and right of it.
        loads: that they carry (N,).
    """
    x, y = places.T
    # How fast each tyre slides, by (v_x, v_y, omega) of B: J V + told, (N, 2).
    zero, one = 0 * x, 1 + 0 * x
    J = np.stack([np.stack([one, zero, -y], 1), np.stack([zero, one, x], 1)], 1)
    told = np.stack([np.sign(y), zero], 1)
    weights, V = loads, np.zeros(3)
    for _ in range(_STEPS):
        H = np.einsum("n,nij,nik->jk", weights, J, J)
        V = np.linalg.solve(H, -np.einsum("n,nij,ni->j", weights, J, told))
        slides = np.linalg.norm(J @ V + told, axis=1)
        weights = loads / np.maximum(slides, _SLOW)
    return float(2.0 / V[2])
