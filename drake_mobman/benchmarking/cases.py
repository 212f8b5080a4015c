"""Which cases `mobman bench` times: each decomposer at each level.

A decomposer is timed as

- a bare law, called with plain numbers;
- a block in a diagram: `base_command` and `arm_command` evaluated, all inputs new;
- the same with the block compiled, where its law can be.

The quadratic program is solved by OSQP through Drake, kept or built again each tick,
and by small dense solvers, where they are installed. The solution alone, with the
program's matrices given, is timed as well. So is a block that only passes its inputs
on: it shows what it costs to evaluate two ports from Python.
"""

import functools
from collections.abc import Callable
from typing import Any

from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import PassThrough

from drake_mobman import signals
from drake_mobman.analysis.compare import commanded, decomposers_by_name, with_each
from drake_mobman.benchmarking.case import BenchmarkCase, Block, Law
from drake_mobman.benchmarking.optimization_case import Solution, Solver
from drake_mobman.benchmarking.programs import (
    DENSE_SOLVERS,
    installed_solvers,
    programs_of,
)
from drake_mobman.benchmarking.ticks import Tick
from drake_mobman.compiled import compiled
from drake_mobman.decomposers.field import build_decomposer
from drake_mobman.decomposers.optimization import OptimizationDecomposer
from drake_mobman.decomposers.qp import QpDecomposer
from drake_mobman.scenario import AnyScenario, ScenarioError

LAW, BLOCK, COMPILED, SOLVER = LEVELS = ("law", "block", "compiled", "solver")
"""What is timed of a decomposer; `solver` is a program's solution by itself."""

REFERENCE = "blending"
"""The decomposer to which the others are compared, at each level."""

NOTHING = "nothing"
"""A block that passes its inputs on."""

Cases = dict[str, dict[str, BenchmarkCase]]
"""By level, then by name. A case that is the same at two levels is in both."""


def benchmark_cases(scenario: AnyScenario) -> tuple[Cases, list[str]]:
    """Returns the cases of a scenario, and a line on each that is left out.

    Args:
        scenario: checked, as `load_scenario` returns it.

    Raises:
        ScenarioError: where the end effector is not commanded.
    """
    scenario = commanded(scenario)
    cases: Cases = {level: {} for level in LEVELS}
    left_out = [
        f"{solver}, which pip install 'drake_mobman[bench]' brings"
        for solver in DENSE_SOLVERS
        if solver not in installed_solvers()
    ]
    for name, kind in decomposers_by_name().items():
        try:
            (variant,) = with_each(scenario, {name: kind}).values()
        except ScenarioError as error:
            left_out.append(str(error))
            continue
        setup = variant.setup()
        make = functools.partial(build_decomposer, variant.decomposer, setup)
        _add_decomposer(cases, name, make)
    nothing = Block(_idle_block(scenario.robot.arm().num_joints))
    cases[BLOCK][NOTHING] = cases[COMPILED][NOTHING] = nothing
    reference = {REFERENCE: cases[LAW][REFERENCE]}
    cases[SOLVER] = reference | cases[SOLVER] if cases[SOLVER] else {}
    return cases, left_out


def _add_decomposer(cases: Cases, name: str, make: Callable[[], Any]) -> None:
    """Adds the cases of a decomposer, given what makes its block."""
    for full_name, variant in _variants(name, make).items():
        levels = _at_each_level(variant)
        for level, case in levels.items():
            same = level == COMPILED and case is levels[BLOCK]
            cases[level][f"{full_name}, in Python" if same else full_name] = case
        if hasattr(block := variant(), "law_without_limits"):
            unlimited = Law(block.law_without_limits)
            cases[LAW][f"{full_name}, without limits"] = unlimited


def _variants(name: str, make: Callable[[], Any]) -> dict[str, Callable[[], Any]]:
    """Returns what makes a decomposer's block, for each way to solve its program."""
    first = make()
    if not isinstance(first, QpDecomposer):
        return {name: make}

    def made_with(program: str) -> Any:
        block = make()
        block.program = programs_of(block)[program]
        return block

    return {
        f"{name}, {program}": functools.partial(made_with, program)
        for program in programs_of(first)
    }


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
    same = without_python is whole
    levels[COMPILED] = levels[BLOCK] if same else Block(without_python)
    if isinstance(block, QpDecomposer):
        levels[SOLVER] = Solver(make())
    return levels


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
