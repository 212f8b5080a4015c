"""Tunes the sharpness alpha of blending by its gradient, taken through the simulation.

    python examples/tune_alpha.py

The end effector starts 0.4 m inside L_max and is pushed out at v_c = 0.3 m/s for T =
6 s. The sharper the transition, the less the arm creeps past its limit, and the harder
the base starts:

    J(alpha) = mean((l - L_max)_+^2) / EXCESS^2 + mean(v_b_dot^2) / ACCELERATION^2

alpha goes into its block as an AutoDiffXd, and J comes out as one with dJ/dalpha, which
takes SNOPT down. In continuous time, without smoothing, J can be worked out by hand:
mu_dot is 2 alpha mu (1 - mu)^2 v_c, so v_b_dot^2 adds up to alpha v_c^3 / 6 as mu goes
from 0 to 1; and with y = l - L_max, (1 + e^(2 alpha y)) dy = v_c dt.
"""

import numpy as np
from blended_loop import PERIOD, make_blended_loop
from pydrake.autodiffutils import AutoDiffXd
from pydrake.solvers import MathematicalProgram, SnoptSolver
from pydrake.systems.analysis import Simulator_
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput

import drake_mobman as mm
from drake_mobman import signals
from drake_mobman.scalars import Scalar, larger

V_C, T = 0.3, 6.0  # The push [m/s], and how long it lasts [s].
L_MAX = mm.WorkspaceLimits().l_max
START = L_MAX - 0.4  # Reach at the start [m].
EXCESS = 0.1  # Past L_max [m], as bad as
ACCELERATION = 0.1  # this of the base's command [m/s^2].


def cost(alpha: Scalar) -> Scalar:
    """Returns J, and with it dJ/dalpha where `alpha` is an `AutoDiffXd`."""
    builder = DiagramBuilder()
    blending = mm.Blending(alpha=1.0 * alpha)  # A copy: the solver lends its own.
    loop = builder.AddSystem(make_blended_loop(blending, mm.Unsmoothed(), START))
    push = builder.AddSystem(ConstantVectorSource([V_C, 0.0, 0.0]))
    builder.Connect(push.get_output_port(), loop.get_input_port())
    for name in (signals.EE_CYLINDRICAL, signals.BASE_COMMAND_SMOOTHED):
        log = LogVectorOutput(loop.GetOutputPort(name), builder, PERIOD)
        log.set_name(name)
    diagram = builder.Build()
    if isinstance(alpha, AutoDiffXd):
        diagram = diagram.ToAutoDiffXd()
    simulator = Simulator_[type(alpha)](diagram)
    simulator.AdvanceTo(T)
    l, v_b = (
        diagram.GetSubsystemByName(name).FindLog(simulator.get_context()).data()[0]
        for name in (signals.EE_CYLINDRICAL, signals.BASE_COMMAND_SMOOTHED)
    )
    excess = np.array([larger(x - L_MAX, 0.0) for x in l]) / EXCESS
    acceleration = np.diff(v_b) / PERIOD / ACCELERATION
    return np.mean(excess**2) + np.mean(acceleration**2)


def tuned(start: float) -> tuple[float, dict[float, tuple[float, float]]]:
    """Returns the best alpha, and J and dJ/dalpha at each step to it."""
    steps: dict[float, tuple[float, float]] = {}

    def evaluate(x: np.ndarray) -> Scalar:
        J = cost(x[0])
        if isinstance(J, AutoDiffXd):
            steps[x[0].value()] = J.value(), J.derivatives()[0]
        return J

    program = MathematicalProgram()
    alpha = program.NewContinuousVariables(1, "alpha")
    program.AddBoundingBoxConstraint(1.0, 100.0, alpha)
    program.AddCost(evaluate, vars=alpha)
    program.SetSolverOption(SnoptSolver.id(), "Verify level", -1)  # The gradient holds.
    result = SnoptSolver().Solve(program, np.array([start]))
    if not result.is_success():
        raise RuntimeError(f"SNOPT gives up: {result.get_solution_result()}")
    return result.GetSolution(alpha)[0], steps


def main() -> None:
    """Prints the gradient beside a finite difference, the steps and the optimum."""
    start, step = 5.0, 1e-3
    difference = (cost(start + step) - cost(start - step)) / (2 * step)
    slope = cost(AutoDiffXd(start, [1.0])).derivatives()[0]
    print(f"dJ/dalpha at {start}: {slope:.8f} by AutoDiffXd,")
    print(f"{difference:28.8f} by a central difference\n")
    best, steps = tuned(start)
    print(f"{'alpha':>10}{'J':>12}{'dJ/dalpha':>12}")
    for alpha, (J, slope) in steps.items():
        print(f"{alpha:10.4f}{J:12.6f}{slope:12.6f}")
    print()
    for alpha in (best - 1, best, best + 1):
        print(f"J({alpha:.4f}) = {cost(alpha):.6f}")


if __name__ == "__main__":
    main()
