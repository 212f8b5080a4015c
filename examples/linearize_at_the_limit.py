"""Linearises the blended loop where base and arm share a push, and checks it by hand.

    python examples/linearize_at_the_limit.py

At l = L_max and psi = 0, with v_c held, the loop is in no equilibrium: the base drives.
But the step s -> s', from one period h to the next, has a Jacobian there, and
AutoDiffXd takes it through the whole diagram at once. The state s is the command last
sent to the base, v and omega; its pose x, y, theta; and l, psi for the joint angles.
With the base's shares mu and nu, and a smoother that takes the share a of what is new,

    v' = v + a (kappa(psi) mu(l) v_c / cos psi - v)      x' = x + h v' cos theta
    omega' = omega + a (nu omega_c - omega)              y' = y + h v' sin theta
    l' = l + h (1 - mu(l)) v_c                           theta' = theta + h omega'
    psi' = psi + h (1 - nu) omega_c

At L_max, mu is 1/2 and its slope alpha / 2, as tanh 0 = 0 and tanh' 0 = 1. kappa (eq.
11) has a slight ridge at psi = 0; its slope there is the one towards psi > 0.

Drake's `FirstOrderTaylorApproximation` takes one group of discrete state; here are two,
the smoother's and the robot's.
"""

import math

import numpy as np
from blended_loop import PERIOD, make_blended_loop
from pydrake.autodiffutils import ExtractGradient, InitializeAutoDiff

import drake_mobman as mm
from drake_mobman import signals

V_C = 0.3
"""The command held [m/s], along the reach."""

STATE = ["v", "omega", "x", "y", "theta", "l", "psi"]
INPUT = ["v_c", "omega_c"]


def linearized(
    blending: mm.Blending, smoother: mm.Smoother, s: list[float]
) -> np.ndarray:
    """Returns ds'/d(s, u) (7, 9) at `s`, by AutoDiffXd through the diagram."""
    arm = mm.RobotSetup.of(mm.Planar(), PERIOD).arm
    loop = make_blended_loop(blending, smoother, l=s[5]).ToAutoDiffXd()
    context = loop.CreateDefaultContext()
    z = InitializeAutoDiff(np.array([*s, V_C, 0.0])).ravel()
    context.SetDiscreteState(0, z[:2])
    context.SetDiscreteState(1, np.array([*z[2:5], *arm.inverse([z[5], z[6], 0.0])]))
    loop.GetInputPort(signals.EE_COMMAND).FixValue(context, np.array([*z[7:], 0.0]))
    after = loop.EvalUniquePeriodicDiscreteUpdate(context)
    l, psi, _ = arm.ee_cylindrical(after.value(1)[3:])
    return ExtractGradient(np.array([*after.value(0), *after.value(1)[:3], l, psi]))


def by_hand(
    blending: mm.Blending, smoother: mm.Smoother
) -> tuple[list[float], np.ndarray]:
    """Returns s at L_max, where the base drives its share, and the same matrix."""
    alpha, beta, a, h = blending.alpha, blending.beta, smoother.smoothing, PERIOD
    limits, sigma = mm.WorkspaceLimits(), blending.projection.sigma
    ridge = math.exp(-((math.pi / 2 / sigma) ** 2))
    kappa, slope = 1 - ridge, -ridge * math.pi / sigma**2
    nu = 1 / (1 + math.exp(2 * beta * limits.psi_max))  # 0.5 tanh(-beta psi_max) + 0.5.
    v = kappa / 2 * V_C
    M = np.eye(7, 9)
    M[0, [0, 5]] = 1 - a, a * kappa * alpha / 2 * V_C
    M[0, [6, 7]] = a * slope / 2 * V_C, a * kappa / 2
    M[1, [1, 8]] = 1 - a, a * nu
    M[2] += h * M[0]
    M[3, 4] = h * v
    M[4] += h * M[1]
    M[5, [5, 7]] = 1 - h * alpha / 2 * V_C, h / 2
    M[6, 8] = h * (1 - nu)
    return [v, 0, 0, 0, 0, limits.l_max, 0], M


def table(matrix: np.ndarray, heads: list[str]) -> list[str]:
    """Returns a matrix's lines under its heads; a point is exactly zero."""
    rows = [heads, *([f"{x:.3g}" if x else "." for x in row] for row in matrix)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(map(str.rjust, row, widths)) for row in rows]


def main() -> None:
    """Prints both, side by side, and their largest difference."""
    blending, smoother = mm.Blending(), mm.Smoother()
    s, worked_out = by_hand(blending, smoother)
    found = linearized(blending, smoother, s)
    print("By AutoDiffXd through the diagram | by hand; a point is exactly zero\n")
    for columns, heads in ((slice(7), STATE), (slice(7, 9), INPUT)):
        sides = (table(matrix[:, columns], heads) for matrix in (found, worked_out))
        for row in zip(["", *(f"{x}'" for x in STATE)], *sides, strict=True):
            print("{:8}{}  |  {}".format(*row))
        print()
    print(f"Largest difference: {np.abs(found - worked_out).max():.1e}")
    print(f"Eigenvalue of l, 1 - h alpha v_c / 2: {found[5, 5]:.4f}")


if __name__ == "__main__":
    main()
