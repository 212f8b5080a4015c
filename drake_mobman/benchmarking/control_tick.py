"""What a control tick costs on a robot with a spatial arm: decomposer and arm inverse.

From the command and the robot's state to the commands for base and joints, by the
exact law and by Drake's differential inverse kinematics. All get what was recorded in
a run; the blocks are wired as in its diagram, without smoother, guard and robot.
"""

from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder

from drake_mobman import signals
from drake_mobman.analysis.compare import with_each
from drake_mobman.benchmarking.case import BenchmarkCase, Block
from drake_mobman.compiled import compiled
from drake_mobman.decomposers.diff_ik import DiffIk
from drake_mobman.decomposers.exact import Exact
from drake_mobman.decomposers.field import build_decomposer
from drake_mobman.diagrams.wiring import export_inputs
from drake_mobman.robot_model import RobotSetup
from drake_mobman.scenario import AnyScenario
from drake_mobman.simulation.run import Run

DIFF_IK = "diffik, its inverse compiled"
"""The one to which the others are compared: differential inverse kinematics as quick
as it can be had."""

_OUTPUTS = signals.BASE_COMMAND, signals.ARM_VELOCITY_COMMAND


def control_tick_cases(
    scenario: AnyScenario, run: Run
) -> tuple[dict[str, BenchmarkCase], list[tuple[np.ndarray, ...]]]:
    """Returns the cases by name, and the inputs of each control period of a run.

    Args:
        scenario: checked; its end effector is commanded.
        run: of it.

    Raises:
        ScenarioError: where a decomposer does not fit the scenario's robot.
    """
    variants = with_each(scenario, {"exact": Exact, "diffik": DiffIk})
    setup = variants["exact"].setup()
    diagrams = {
        name: _tick(variants[kind], setup, compile_decomposer, compile_inverse)
        for name, kind, compile_decomposer, compile_inverse in (
            ("exact, compiled", "exact", True, True),
            ("exact, in Python", "exact", False, False),
            (DIFF_IK, "diffik", False, True),
            ("diffik, in Python", "diffik", False, False),
        )
    }
    first = diagrams[DIFF_IK]  # All have the same inputs.
    ports = map(first.get_input_port, range(first.num_input_ports()))
    inputs = [port.get_name() for port in ports]
    cases: dict[str, BenchmarkCase] = {
        name: Block(diagram, inputs, _OUTPUTS) for name, diagram in diagrams.items()
    }
    return cases, [*zip(*(run[name] for name in inputs), strict=True)]


def _tick(
    scenario: Any, setup: RobotSetup, compile_decomposer: bool, compile_inverse: bool
) -> Diagram:
    """Returns a scenario's decomposer and arm inverse, each compiled or not."""
    builder = DiagramBuilder()
    decomposer = build_decomposer(scenario.decomposer, setup)
    inverse = scenario.robot.arm_inverse(setup)
    decomposer = builder.AddSystem(
        compiled(decomposer) if compile_decomposer else decomposer
    )
    inverse = builder.AddSystem(compiled(inverse) if compile_inverse else inverse)
    command = inverse.GetInputPort(signals.ARM_COMMAND)
    builder.Connect(decomposer.GetOutputPort(signals.ARM_COMMAND), command)
    export_inputs(builder, [decomposer, inverse], but=[signals.ARM_COMMAND])
    for system, name in zip((decomposer, inverse), _OUTPUTS, strict=True):
        builder.ExportOutput(system.GetOutputPort(name), name)
    return builder.Build()
