"""How much of the bare plant's speed is left with all blocks and loggers.

For each scenario at fidelity `Servo`: its simulated over wall time, with blocks in
Python and compiled as far as it goes, beside that of the same plant stepped without any
block of ours, in one process, turn by turn.

    python benchmarks/real_time_factor.py [SCENARIO ...]
"""

import dataclasses as dc
import platform
import statistics
import sys
import time

from drake_mobman.diagrams import make_diagram
from pydrake.systems.analysis import Simulator

from drake_mobman.robots.servo import ServoRobot
from drake_mobman.runs.scenario import AnyScenario, Guided, load_scenario

TURNS = 9
STRETCH = 2.0  # Simulated in one turn [s].


def bare_plant(scenario: AnyScenario) -> Simulator:
    """Returns a simulator of the scenario's plant alone."""
    guided = isinstance(scenario, Guided)
    return Simulator(
        ServoRobot(scenario.robot, scenario.fidelity, free_arm=guided).plant
    )


def follow(bare: Simulator, whole: Simulator) -> None:
    """Puts the bare plant where the whole diagram's is, its servos told to go on so."""
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


def factor(simulator: Simulator, stretch: float) -> float:
    """Returns the real-time factor of the next `stretch` [s] of a simulation."""
    end = simulator.get_context().get_time() + stretch
    start = time.perf_counter()
    simulator.AdvanceTo(end)
    return stretch / (time.perf_counter() - start)


def main(names: list[str]) -> None:
    """Prints the factors, and their ratio to the bare plant's, for each scenario."""
    print(f"Python {platform.python_version()}, {platform.machine()}")
    print(
        f"{'scenario':16} {'blocks':9} {'whole':>7} {'bare':>7} {'ratio':>6}   spread"
    )
    for name in names:
        _, scenario = load_scenario(name)
        wholes = {
            label: Simulator(make_diagram(dc.replace(scenario, compiled=compiled)))
            for label, compiled in (("python", False), ("compiled", True))
        }
        bare = bare_plant(scenario)
        factors: dict[str, list[float]] = {label: [] for label in (*wholes, "bare")}
        for turn in range(TURNS + 1):
            follow(bare, wholes["python"])
            for label, simulator in (wholes | {"bare": bare}).items():
                x = factor(simulator, STRETCH)
                if turn:  # The first warms up.
                    factors[label].append(x)
        for label in wholes:
            pairs = zip(factors[label], factors["bare"], strict=True)
            ratios = sorted(a / b for a, b in pairs)
            a, b = (statistics.median(factors[side]) for side in (label, "bare"))
            ratio = statistics.median(ratios)
            spread = f"{ratios[0]:.2f}..{ratios[-1]:.2f}"
            print(f"{name:16} {label:9} {a:7.1f} {b:7.1f} {ratio:6.2f}   {spread}")


if __name__ == "__main__":
    main(sys.argv[1:] or ["petric_guided", "petric_teleop", "kwon_franka"])
