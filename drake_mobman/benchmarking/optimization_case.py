"""What is timed of a decomposer that solves an optimization problem each tick."""

from typing import Any

import numpy as np

from drake_mobman.benchmarking.case import BenchmarkCase
from drake_mobman.benchmarking.ticks import Tick
from drake_mobman.decomposers.arm_compensation import LEAST_REACH
from drake_mobman.decomposers.optimization import OptimizationDecomposer
from drake_mobman.decomposers.qp import QpDecomposer, decomposition_qp


class Solution(BenchmarkCase):
    """The rates that an `OptimizationDecomposer` finds, without its ports."""

    def __init__(self, block: OptimizationDecomposer) -> None:
        self._block = block
        self._last = np.zeros(len(block.largest))
        self._found: Any = None
        self._tick: Any = None

    def prepare(self, tick: Tick) -> None:
        """Keeps the tick's arrays."""
        self._tick = tick

    def act(self) -> tuple[float, ...] | None:
        """Returns `base_command` and `arm_command` (5,), or None if there is none."""
        command, at, q = self._tick[:3]
        self._found = self._block.rates(command, at, q, self._last)
        if self._found is None:
            return None
        (v_b, omega_b, *_), (along, across, up) = self._found
        turning = across / max(at[0], LEAST_REACH)
        return v_b, omega_b, along, turning, up

    def settle(self) -> None:
        """Keeps the rates, from which the next solution starts."""
        self._last = np.zeros_like(self._last)
        if self._found is not None:
            self._last = self._found[0]


class Solver(BenchmarkCase):
    """The solution of a `QpDecomposer`'s program, once its matrices are known."""

    def __init__(self, block: QpDecomposer) -> None:
        self._block = block
        self._last = np.zeros(len(block.largest))
        self._found: Any = None
        self._qp: Any = None

    def prepare(self, tick: Tick) -> None:
        """Computes the program's matrices."""
        block = self._block
        self._qp, _ = decomposition_qp(
            block.arm, block.limits, block.params, block.period, *tick[:3]
        )

    def act(self) -> Any:
        """Returns the solution (k,), or None if there is none."""
        self._found = self._block.program.solve(self._qp, self._last)
        return self._found

    def settle(self) -> None:
        """Keeps the solution, from which the next one starts."""
        if self._found is not None:
            self._last = self._found
