"""How much faster than real time a scenario runs, and its bare plant."""

import dataclasses as dc
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

from pydrake.systems.analysis import Simulator

from drake_mobman.diagrams import make_diagram
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
    scenario: AnyScenario, turns: int, stretch: float, timed: Timed = wall_time
) -> Factors:
    """Returns the real-time factors of a scenario, taken by turns.

    Args:
        scenario: checked, as `load_scenario` returns it.
        turns: how often each is timed, after once to warm up.
        stretch: simulated in one turn [s]; less if the scenario is too short for it.
        timed: advances simulators and returns the wall time.
    """
    whole = Simulator(make_diagram(dc.replace(scenario, compiled=False)))
    simulators = {"python": whole, "compiled": compiled_simulator(scenario)}
    bare = bare_plant(scenario)
    if bare:
        simulators["bare"] = bare
    stretch = min(stretch, scenario.duration / (turns + 1))
    factors: Factors = {name: [] for name in simulators}
    for turn in range(turns + 1):
        if bare:
            follow(bare, whole)
        for name, simulator in simulators.items():
            taken = timed([simulator], stretch)
            if turn:
                factors[name].append(stretch / taken)
    return factors


def compiled_simulator(scenario: AnyScenario) -> Simulator:
    """Returns a simulator of the scenario with its blocks compiled, logging."""
    return Simulator(make_diagram(dc.replace(scenario, compiled=True)))


def bare_plant(scenario: AnyScenario) -> Simulator | None:
    """Returns a simulator of the scenario's plant alone, if it steps one."""
    plant = scenario.bare_plant()
    return plant and Simulator(plant)


def follow(bare: Simulator, whole: Simulator) -> None:
    """Gives the bare plant the state of the whole diagram's, also as desired state."""
    robot = whole.get_system().GetSubsystemByName("robot")
    plant = robot.GetSubsystemByName("plant")
    state = plant.get_state_output_port().Eval(
        plant.GetMyContextFromRoot(whole.get_context())
    )
    alone, context = bare.get_system(), bare.get_mutable_context()
    alone.SetPositionsAndVelocities(context, state)
    first = alone.GetJointActuatorIndices()[0]
    instance = alone.get_joint_actuator(first).model_instance()
    alone.get_desired_state_input_port(instance).FixValue(context, state)


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
