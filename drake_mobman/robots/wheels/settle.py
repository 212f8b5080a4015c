"""The start of a robot on wheels: standing, its tyres pressed into the floor."""

from collections.abc import Callable

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram

from drake_mobman import signals
from drake_mobman.engines.engine import EngineParams
from drake_mobman.parameters import ParameterError
from drake_mobman.robots.wheels.floor import Floor
from drake_mobman.robots.wheels.plant import RollingPlant
from drake_mobman.robots.wheels.support import TippedOverError

_TIME = 1.5
"""After which a robot that stands is at rest [s]."""

_KEPT = 32
"""How many starts are kept."""

_settled: dict[tuple[object, ...], np.ndarray] = {}
"""Starts of this process: a scenario is built several times before it runs."""


def standing(
    made: RollingPlant,
    start: list[float],
    floor: Floor,
    engine: EngineParams,
    make: Callable[..., Diagram],
) -> np.ndarray:
    """Returns the plant's positions where the robot stands at `start`, at rest.

    It is let down onto the floor in a simulation of its own, and put back to its place,
    heading and posture then.

    Args:
        made: the robot's plant.
        start: positions (3 + n,) of base and arm.
        floor: that it stands on.
        engine: that steps it: each presses the tyres in by a little more or less.
        make: returns a diagram of the robot, its arm and base driven, from positions.

    Raises:
        ParameterError: where it tips over.
    """
    q = made.positions(start, _drop(made, start, floor))
    key = (repr(floor), repr(engine), *_fingerprint(made, q))
    if key not in _settled:
        while len(_settled) >= _KEPT:
            del _settled[next(iter(_settled))]
        _settled[key] = _let_down(make(q))[: len(q)]
    stands = _settled[key].copy()
    at = made.floating.position_start()
    for place in (slice(at + 2, at + 5), made.arm_q, made.wheel_q):
        stands[place] = q[place]
    return stands


def _let_down(diagram: Diagram) -> np.ndarray:
    """Returns the state of the plant at rest."""
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    for name in (signals.BASE_COMMAND_SMOOTHED, signals.ARM_VELOCITY_COMMAND):
        port = diagram.GetInputPort(name)
        port.FixValue(context, np.zeros(port.size()))
    try:
        simulator.AdvanceTo(_TIME)
    except TippedOverError as error:
        valid = "must let the robot stand on its wheels"
        raise ParameterError("start", str(error), valid) from None
    return np.array(diagram.GetOutputPort(signals.ROBOT_STATE).Eval(context))


def _drop(made: RollingPlant, start: list[float], floor: Floor) -> float:
    """Returns the height of B [m] from which no tyre is in the floor, upright."""
    context = made.plant.CreateDefaultContext()
    made.plant.SetPositions(context, made.positions(start))
    heights = [0.0]
    for contact in made.contacts:
        X_WB = made.plant.EvalBodyPoseInWorld(context, contact.body)
        x, y, z = X_WB @ contact.p_BC
        heights.append(floor.height(x, y) - (z - contact.radius))
    return max(heights)


def _fingerprint(made: RollingPlant, q: np.ndarray) -> tuple[object, ...]:
    """Returns what decides how a robot at `q` settles, its floor aside."""
    plant, context = made.plant, made.plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    masses = plant.CalcMassMatrixViaInverseDynamics(context).tobytes()
    contacts = [(str(c.body.name()), *c.p_BC, c.radius) for c in made.contacts]
    return q.tobytes(), masses, plant.time_step(), repr(contacts)
