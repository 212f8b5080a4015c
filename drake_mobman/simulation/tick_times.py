"""How long a control tick takes."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator

from drake_mobman import signals
from drake_mobman.diagrams import make_diagram
from drake_mobman.scenario import AnyScenario
from drake_mobman.ticks import last_tick

_INPUTS = (f"source.{signals.EE_COMMAND}", signals.EE_CYLINDRICAL, signals.P_BT)
"""Signals evaluated before the clock starts, where the diagram has them."""

_OUTPUTS = (signals.BASE_COMMAND_SMOOTHED, signals.ARM_VELOCITY_COMMAND)
"""Signals whose evaluation is timed, where the diagram has them."""


def tick_times(
    scenario: AnyScenario,
    decomposer: Callable[[], Any] | None = None,
    *,
    most: int = 1000,
) -> np.ndarray:
    """Returns how long each of the first control ticks takes (K,) [s].

    A tick starts with the command and the end effector's position, and ends with the
    commands to the base and the joints. It is timed in a run of its own, without
    loggers: they would evaluate all signals before the clock starts.

    Args:
        scenario: checked, as `load_scenario` returns it.
        decomposer: makes a block to use instead of the scenario's decomposer.
        most: how many ticks to time.
    """
    scenario = scenario.in_whole_steps()
    block = decomposer and decomposer()
    diagram = make_diagram(scenario, decomposer=block, logged=False)
    simulator = Simulator(diagram)
    simulator.Initialize()
    context = simulator.get_context()
    inputs, outputs = (
        [diagram.GetOutputPort(name) for name in names if diagram.HasOutputPort(name)]
        for names in (_INPUTS, _OUTPUTS)
    )
    times = []
    for k in range(min(most, last_tick(scenario.duration, scenario.period))):
        simulator.AdvanceTo(k * scenario.period)
        for port in inputs:
            port.Eval(context)
        start = time.perf_counter()
        for port in outputs:
            port.Eval(context)
        times.append(time.perf_counter() - start)
    return np.array(times)
