"""Who is timed by `mobman bench`, and what is timed of each.

A decomposer is timed as

- a bare law, called with plain numbers;
- a block in a diagram: `base_command` and `arm_command` evaluated, all inputs new;
- the same with the block compiled, where its law can be.

The quadratic program is solved by OSQP through Drake, kept or built anew each tick, and
by small dense solvers, where they are installed. What these take by themselves, the
program's matrices given, is timed as well; and so is a block that does nothing, for to
evaluate two ports from Python costs something too.
"""

import dataclasses as dc
import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import PassThrough

from drake_mobman import signals
from drake_mobman.analysis.compare import decomposers_by_name, with_each
from drake_mobman.compiled import compiled
from drake_mobman.decomposers.arm_compensation import LEAST_REACH
from drake_mobman.decomposers.field import build_decomposer
from drake_mobman.decomposers.optimization import OptimizationDecomposer
from drake_mobman.decomposers.qp import (
    BoxQp,
    Qp,
    QpDecomposer,
    QpProgram,
    decomposition_qp,
)
from drake_mobman.scenario import AnyScenario, ScenarioError
from drake_mobman.simulation.simulate import Run

LAW, BLOCK, COMPILED, SOLVER = LEVELS = ("law", "block", "compiled", "solver")
"""What is timed of a decomposer; `solver` is a program's solution by itself."""

DENSE_SOLVERS = ("daqp", "proxqp", "quadprog")
"""The fastest for a few unknowns, by the names that `qpsolvers` has for them."""

REFERENCE = "blending"
"""What the others are measured by, at each level."""

NOTHING = "nothing"
"""A block that passes its inputs on."""

_OSQP_EPS = 1e-3
"""OSQP's own tolerance, where a user does not ask for another."""


class Tick(NamedTuple):
    """What a decomposer is told in a control period, by the names of its ports."""

    ee_command: np.ndarray  # (3,)
    workspace: np.ndarray  # (3,)
    arm_position: np.ndarray  # (n,)
    base_command_smoothed: np.ndarray  # (2,)


def recorded_ticks(run: Run) -> list[Tick]:
    """Returns what the decomposer was told in each control period of a run."""
    return list(
        map(
            Tick,
            run.log[signals.EE_COMMAND],
            run.log[signals.EE_CYLINDRICAL],
            run.log[signals.ARM_POSITION],
            run.log[signals.BASE_COMMAND_SMOOTHED],
        )
    )


# How a contender is timed: `act` alone is, between `prepare` and `settle`.


class BenchmarkCase:
    """Something that is called once a tick."""

    def prepare(self, tick: Tick) -> None:
        """Takes in what the tick tells it."""
        raise NotImplementedError

    def act(self) -> Any:
        """Returns what comes of it."""
        raise NotImplementedError

    def settle(self) -> None:
        """Goes on to the next tick."""


class Law(BenchmarkCase):
    """A function of the four signals, told as lists of floats."""

    def __init__(self, law: Callable[..., Any]) -> None:
        self._law = law
        self._told: tuple[list[float], ...] = ()

    def prepare(self, tick: Tick) -> None:
        """Takes the numbers out of their arrays."""
        self._told = tuple(value.tolist() for value in tick)

    def act(self) -> tuple[float, ...]:
        """Returns `base_command` and `arm_command` (5,)."""
        return self._law(*self._told)


class Solution(BenchmarkCase):
    """The rates that a `OptimizationDecomposer` finds, without its block about it."""

    def __init__(self, block: OptimizationDecomposer) -> None:
        self._block = block
        self._last = np.zeros(len(block.largest))
        self._found: Any = None
        self._tick: Any = None

    def prepare(self, tick: Tick) -> None:
        """Takes the tick's arrays as they are."""
        self._tick = tick

    def act(self) -> tuple[float, ...] | None:
        """Returns `base_command` and `arm_command` (5,), or None if there is none."""
        command, workspace, q, _ = self._tick
        self._found = self._block.rates(command, workspace, q, self._last)
        if self._found is None:
            return None
        (v_b, omega_b, *_), (along, across, up) = self._found
        turning = across / max(workspace[0], LEAST_REACH)
        return v_b, omega_b, along, turning, up

    def settle(self) -> None:
        """Keeps the rates, where the next solution starts from; or none."""
        self._last = np.zeros_like(self._last)
        if self._found is not None:
            self._last = self._found[0]


class Block(BenchmarkCase):
    """A block in a diagram of its own."""

    def __init__(self, block: Any) -> None:
        builder = DiagramBuilder()
        builder.AddSystem(block)
        for name in Tick._fields:
            builder.ExportInput(block.GetInputPort(name), name)
        wanted = signals.BASE_COMMAND, signals.ARM_COMMAND
        for name in wanted:
            builder.ExportOutput(block.GetOutputPort(name), name)
        self._diagram = builder.Build()
        self._context = self._diagram.CreateDefaultContext()
        self._inputs = [self._diagram.GetInputPort(name) for name in Tick._fields]
        self._outputs = [self._diagram.GetOutputPort(name) for name in wanted]
        self._has_state = self._context.num_discrete_state_groups() > 0

    def prepare(self, tick: Tick) -> None:
        """Fixes all inputs to new values, so that nothing is known of the outputs."""
        for port, value in zip(self._inputs, tick, strict=True):
            port.FixValue(self._context, value)

    def act(self) -> tuple[float, ...]:
        """Returns `base_command` and `arm_command` (5,)."""
        base, arm = self._outputs
        return (*base.Eval(self._context), *arm.Eval(self._context))

    def settle(self) -> None:
        """Takes the block's state a period on."""
        if self._has_state:
            state = self._diagram.EvalUniquePeriodicDiscreteUpdate(self._context)
            self._context.SetDiscreteState(state.value().copy())


class Solver(BenchmarkCase):
    """The program of a `QpDecomposer` by itself, its matrices given."""

    def __init__(self, block: QpDecomposer) -> None:
        self._block = block
        self._last = np.zeros(len(block.largest))
        self._found: Any = None
        self._qp: Any = None

    def prepare(self, tick: Tick) -> None:
        """Works out the program's matrices."""
        block = self._block
        self._qp, _ = decomposition_qp(
            block.arm, block.limits, block.params, block.period, *tick[:3]
        )

    def act(self) -> Any:
        """Returns the solution (k,), or None if there is none."""
        self._found = self._block.program.solve(self._qp, self._last)
        return self._found

    def settle(self) -> None:
        """Keeps the solution, where the next one starts from."""
        if self._found is not None:
            self._last = self._found


# Programs that take a `QpProgram`'s place.


class RebuiltProgram:
    """A `QpProgram` that is built anew for each solution."""

    def __init__(self, size: int, params: Qp) -> None:
        self._size, self._params = size, params

    def solve(self, qp: BoxQp, guess: Any = None) -> Any:
        """Returns the solution (k,), or None if there is none."""
        return QpProgram(self._size, self._params).solve(qp, guess)


class DenseProgram:
    """A program solved by one of `qpsolvers`' solvers, at that solver's tolerances."""

    def __init__(self, solver: str) -> None:
        # An extra: it may not be there.
        from qpsolvers import solve_qp  # noqa: PLC0415

        self._solve, self._solver = solve_qp, solver

    def solve(self, qp: BoxQp, guess: Any = None) -> Any:  # noqa: ARG002
        """Returns the solution (k,), or None if there is none.

        None of these solvers gains by a guess for so few unknowns.
        """
        return self._solve(qp.P, qp.q, lb=qp.lb, ub=qp.ub, solver=self._solver)


def installed_solvers() -> list[str]:
    """Returns those of `DENSE_SOLVERS` that are installed."""
    try:
        from qpsolvers import available_solvers  # noqa: PLC0415
    except ImportError:
        return []
    return [name for name in DENSE_SOLVERS if name in available_solvers]


# Who competes.


def _programs(block: QpDecomposer) -> dict[str, Any]:
    """Returns what may solve a decomposer's program, by name."""
    size, params = len(block.largest), block.params
    coarse = dc.replace(params, tolerance=_OSQP_EPS / (2 * params.damping))
    return {
        "OSQP kept": block.program,
        f"OSQP kept, eps {_OSQP_EPS:g}": QpProgram(size, coarse),
        "OSQP rebuilt": RebuiltProgram(size, params),
        **{name: DenseProgram(name) for name in installed_solvers()},
    }


def _variants(name: str, make: Callable[[], Any]) -> dict[str, Callable[[], Any]]:
    """Returns what makes a decomposer's block, for each way to solve its program."""
    first = make()
    if not isinstance(first, QpDecomposer):
        return {name: make}

    def made_with(program: str) -> Any:
        block = make()
        block.program = _programs(block)[program]
        return block

    return {
        f"{name}, {program}": functools.partial(made_with, program)
        for program in _programs(first)
    }


Contenders = dict[str, dict[str, BenchmarkCase]]
"""By level, then by name. What is no different at another level stands there too."""


def benchmark_cases(scenario: AnyScenario) -> tuple[Contenders, list[str]]:
    """Returns who competes in a scenario, and a line on each who cannot.

    Args:
        scenario: checked, as `load_scenario` returns it.

    Raises:
        ScenarioError: where nobody commands the hand.
    """
    with_each(scenario, {})
    entered: Contenders = {level: {} for level in LEVELS}
    missing = [
        f"{solver}, which pip install 'drake_mobman[bench]' brings"
        for solver in DENSE_SOLVERS
        if solver not in installed_solvers()
    ]
    for name, kind in decomposers_by_name().items():
        try:
            (variant,) = with_each(scenario, {name: kind}).values()
        except ScenarioError as error:
            missing.append(str(error))
            continue
        makers = _variants(name, functools.partial(
            build_decomposer, variant.decomposer, variant.setup()
        ))
        for full_name, make in makers.items():
            at = _at_each_level(make)
            for level, contender in at.items():
                stays = level == COMPILED and contender is at[BLOCK]
                label = f"{full_name}, in Python" if stays else full_name
                entered[level][label] = contender
            if hasattr(block := make(), "law_without_limits"):
                unlimited = Law(block.law_without_limits)
                entered[LAW][f"{full_name}, without limits"] = unlimited
    nothing = Block(_idle_block(scenario.robot.arm().num_joints))
    entered[BLOCK][NOTHING] = entered[COMPILED][NOTHING] = nothing
    beside = {REFERENCE: entered[LAW][REFERENCE]}
    entered[SOLVER] = beside | entered[SOLVER] if entered[SOLVER] else {}
    return entered, missing


def _idle_block(joints: int) -> Any:
    """Returns a block of Drake's that passes inputs on, with a decomposer's ports."""
    builder = DiagramBuilder()
    sizes = dict.fromkeys(Tick._fields, 3)
    sizes |= {signals.ARM_POSITION: joints, signals.BASE_COMMAND_SMOOTHED: 2}
    passed = {signals.EE_COMMAND: signals.ARM_COMMAND}
    passed |= {signals.BASE_COMMAND_SMOOTHED: signals.BASE_COMMAND}
    for name, size in sizes.items():
        block = builder.AddSystem(PassThrough(size))
        builder.ExportInput(block.get_input_port(), name)
        builder.ExportOutput(block.get_output_port(), passed.get(name, name))
    return builder.Build()


def _at_each_level(make: Callable[[], Any]) -> dict[str, BenchmarkCase]:
    levels: dict[str, BenchmarkCase] = {}
    block = make()
    if hasattr(block, "law"):
        levels[LAW] = Law(block.law)
    elif isinstance(block, OptimizationDecomposer):
        levels[LAW] = Solution(block)
    levels[BLOCK] = Block(make())
    whole = make()
    without_python = compiled(whole)
    stays = without_python is whole
    levels[COMPILED] = levels[BLOCK] if stays else Block(without_python)
    if isinstance(block, QpDecomposer):
        levels[SOLVER] = Solver(make())
    return levels
