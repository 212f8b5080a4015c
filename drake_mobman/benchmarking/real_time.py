"""How much faster than real time a scenario runs, and its bare plant."""

import dataclasses as dc
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, PortDataType

from drake_mobman.diagrams import make_diagram
from drake_mobman.robots.wheels import Wheels
from drake_mobman.scenario import AnyScenario

Factors = dict[str, list[float]]
"""A real-time factor, simulated over wall time, for each turn: `python` with all blocks
and loggers; `compiled` with blocks compiled where they can be; and `bare`, where the
robot is a plant, with that plant stepped without any block."""

Timed = Callable[..., float]
"""What advances simulators and returns the wall time; see `wall_time`."""


def wall_time(
    simulators: Sequence[Simulator],
    stretch: float,
    pool: ThreadPoolExecutor | None = None,
) -> float:
    """Returns how long simulators take for their next `stretch` [s].

    One after the other, or at once in the threads of the pool.
    """
    ends = [s.get_context().get_time() + stretch for s in simulators]
    start = time.perf_counter()
    list((pool.map if pool else map)(Simulator.AdvanceTo, simulators, ends))
    return time.perf_counter() - start


def real_time_factors(
    scenarios: Mapping[str, AnyScenario],
    turns: int,
    stretch: float,
    timed: Timed = wall_time,
) -> dict[str, Factors]:
    """Returns the real-time factors of scenarios by their names, all taken by turns.

    Args:
        scenarios: checked, as `load_scenario` returns them.
        turns: how often each is timed, after once to warm up.
        stretch: simulated in one turn [s]; less if a scenario is too short for it.
        timed: advances simulators and returns the wall time.
    """
    simulators = {name: _simulators(one) for name, one in scenarios.items()}
    shortest = min(one.duration for one in scenarios.values())
    stretch = min(stretch, shortest / (turns + 1))
    factors: dict[str, Factors] = {
        name: {kind: [] for kind in kinds} for name, kinds in simulators.items()
    }
    for turn in range(turns + 1):
        for name, kinds in simulators.items():
            if "bare" in kinds:
                follow(kinds["bare"], kinds["python"])
            for kind, simulator in kinds.items():
                taken = timed([simulator], stretch)
                if turn:
                    factors[name][kind].append(stretch / taken)
    return factors


def _simulators(scenario: AnyScenario) -> dict[str, Simulator]:
    """Returns what is timed of a scenario."""
    whole = Simulator(make_diagram(dc.replace(scenario, compiled=False)))
    simulators = {"python": whole, "compiled": compiled_simulator(scenario)}
    bare = bare_plant(scenario)
    return simulators | ({"bare": bare} if bare else {})


def compiled_simulator(scenario: AnyScenario) -> Simulator:
    """Returns a simulator of the scenario with its blocks compiled, logging."""
    return Simulator(make_diagram(dc.replace(scenario, compiled=True)))


def bare_plant(scenario: AnyScenario) -> Simulator | None:
    """Returns a simulator of the scenario's plant alone, if it steps one.

    On wheels, with the floor: without its contacts it would fall.
    """
    if isinstance(scenario.fidelity, Wheels):
        free_arm = not hasattr(scenario, "decomposer")
        return Simulator(scenario.fidelity.alone(scenario.robot, free_arm=free_arm))
    plant = scenario.bare_plant()
    return plant and Simulator(plant)


def follow(bare: Simulator, whole: Simulator) -> None:
    """Gives the bare plant the state of the whole diagram's, and what drives it now."""
    robot = whole.get_system().GetSubsystemByName("robot")
    plant = robot.GetSubsystemByName("plant")
    there = plant.GetMyContextFromRoot(whole.get_context())
    alone = bare.get_system()
    if isinstance(alone, Diagram):
        alone = alone.GetSubsystemByName("plant")
    here = alone.GetMyMutableContextFromRoot(bare.get_mutable_context())
    alone.SetPositionsAndVelocities(here, plant.get_state_output_port().Eval(there))
    # Desired states and torques.
    for i in range(plant.num_input_ports()):
        port = plant.get_input_port(i)
        if port.get_data_type() == PortDataType.kVectorValued and port.HasValue(there):
            alone.get_input_port(i).FixValue(here, port.Eval(there))


def threading_ratios(
    scenario: AnyScenario, turns: int, stretch: float, timed: Timed = wall_time
) -> list[float]:
    """Returns the wall time of two compiled diagrams in two threads, over that of one.

    A ratio for each turn; it is 1 where neither waits for the other.

    Args:
        scenario: of both.
        turns: how often it is timed, after once to warm up.
        stretch: simulated at a time [s]; at rest, where the scenario ends before.
        timed: advances simulators and returns the wall time.
    """
    pair = [compiled_simulator(scenario) for _ in range(2)]
    ratios = []
    with ThreadPoolExecutor(2) as pool:
        for turn in range(turns + 1):
            alone = sum(timed([simulator], stretch) for simulator in pair) / 2
            together = timed(pair, stretch, pool)
            if turn:
                ratios.append(together / alone)
    return ratios
