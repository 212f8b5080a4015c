"""Ways to solve a quadratic program: OSQP through Drake, and small dense solvers."""

import dataclasses as dc
from typing import Any

from drake_mobman.decomposers.qp import BoxQp, Qp, QpDecomposer, QpProgram

DENSE_SOLVERS = ("daqp", "proxqp", "quadprog")
"""The fastest for a few unknowns, by their names in `qpsolvers`."""

_OSQP_EPS = 1e-3
"""OSQP's own default tolerance."""


class RebuiltProgram:
    """A `QpProgram` that is built again for each solution."""

    def __init__(self, size: int, params: Qp) -> None:
        self._size, self._params = size, params

    def solve(self, qp: BoxQp, guess: Any = None) -> Any:
        """Returns the solution (k,), or None if there is none."""
        return QpProgram(self._size, self._params).solve(qp, guess)


class DenseProgram:
    """A program solved by one of `qpsolvers`' solvers, at that solver's tolerances."""

    def __init__(self, solver: str) -> None:
        # An optional dependency.
        from qpsolvers import solve_qp  # noqa: PLC0415

        self._solve, self._solver = solve_qp, solver

    def solve(self, qp: BoxQp, guess: Any = None) -> Any:  # noqa: ARG002
        """Returns the solution (k,), or None if there is none.

        None of these solvers is faster with a guess for so few unknowns.
        """
        return self._solve(qp.P, qp.q, lb=qp.lb, ub=qp.ub, solver=self._solver)


def installed_solvers() -> list[str]:
    """Returns the `DENSE_SOLVERS` that are installed."""
    try:
        from qpsolvers import available_solvers  # noqa: PLC0415
    except ImportError:
        return []
    return [name for name in DENSE_SOLVERS if name in available_solvers]


def programs_of(block: QpDecomposer) -> dict[str, Any]:
    """Returns the ways to solve a decomposer's program, by name."""
    size, params = len(block.largest), block.params
    coarse = dc.replace(params, tolerance=_OSQP_EPS / (2 * params.damping))
    return {
        "OSQP kept": block.program,
        f"OSQP kept, eps {_OSQP_EPS:g}": QpProgram(size, coarse),
        "OSQP rebuilt": RebuiltProgram(size, params),
        **{name: DenseProgram(name) for name in installed_solvers()},
    }
