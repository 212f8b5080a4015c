"""The true motion of the end effector, from a run's log.

It is computed by forward kinematics of the robot's `MultibodyPlant`, without any code
that a decomposer or a sensor uses: so an error in a law shows here.
"""

import dataclasses as dc
from typing import Any

import numpy as np

from drake_mobman import signals
from drake_mobman.guidance.guiding_hand import holds
from drake_mobman.robot_model import BASE_JOINTS, RobotModel
from drake_mobman.robots.end_effector import (
    EndEffectorStates,
    ee_states,
    manipulabilities,
)
from drake_mobman.simulation.log import Log
from drake_mobman.simulation.run import Run

_ON_AXIS = 1e-6
"""Reach below which its direction is lost in rounding [m]."""


@dc.dataclass(frozen=True)
class EndEffectorMotion:
    """The end effector's motion in W at each of N samples, in the plane.

    Radial is along the reach S->E, tangential across it, to the left.
    """

    position: np.ndarray  # x, y of E in W (N, 2) [m].
    axes: np.ndarray  # Angle of the reach in W (N,) [rad].
    reach: np.ndarray  # l (N,) [m].
    psi: np.ndarray  # Angle of the reach in B, counting whole turns (N,) [rad].
    velocity: np.ndarray  # True velocity: radial, tangential (N, 2) [m/s].
    rise: np.ndarray  # True velocity upwards (N,) [m/s].
    commanded: np.ndarray  # Command from this sample on: v_c, l omega_c (N, 2) [m/s].
    in_force: np.ndarray  # Command that `velocity` is to follow (N, 2) [m/s].

    @property
    def error(self) -> np.ndarray:
        """Returns the true velocity less the commanded one (N, 2) [m/s]."""
        return self.velocity - self.in_force

    def commanded_path(self, period: float) -> np.ndarray:
        """Returns x, y in W (N, 2) [m] of the path that the commands alone would make.

        They are integrated from the start by Euler steps of `period` [s], as the
        kinematic robot is.
        """
        radial, tangential = self.commanded.T
        c, s = np.cos(self.axes), np.sin(self.axes)
        v_W = np.stack([radial * c - tangential * s, radial * s + tangential * c], 1)
        steps = np.vstack([self.position[:1], period * v_W[:-1]])
        return np.cumsum(steps, axis=0)

    def drift(self, period: float) -> np.ndarray:
        """Returns the distance of E from `commanded_path` (N,) [m]."""
        return np.linalg.norm(self.position - self.commanded_path(period), axis=1)


def holding(run: Run) -> np.ndarray:
    """Returns whether the hand of a guided run holds the tool (N,).

    As the logged force does, this refers to the control tick before. An operator's hand
    holds the tool unless it drags another point of the arm.
    """
    if signals.DRAG in run.log:
        dragged = run.log[signals.DRAG][:, 0] != 0
        return ~np.append(False, dragged[:-1])
    ticks = run.log["time"] - run.scenario.period / 2
    scenario: Any = run.scenario  # Of a kind that has a hand.
    releases = scenario.hand.releases
    return np.array([holds(time, releases) for time in ticks])


def ee_motion(run: Run, model: RobotModel | None = None) -> EndEffectorMotion:
    """Returns the end effector's motion in a run; without commands, they count as zero.

    At fidelity `Kinematic` the end effector has the commanded velocity at once. With
    masses, its velocity at a tick comes from the command of the tick before, which was
    held until then.

    Args:
        run: with at least one sample in its log.
        model: of its robot; the run's own unless given.
    """
    log, model = run.log, model or run.model
    kinematic = not run.scenario.fidelity.has_masses
    if kinematic:
        states, velocity = _mean_motion(model, log, run.scenario.period)
    else:
        states, velocity = _instant_motion(model, log)
    reach, axes = _polar(states)
    command = log.get(signals.EE_COMMAND, np.zeros((len(reach), 3)))[:, :2]
    held = command if kinematic else np.vstack([np.zeros(2), command[:-1]])
    lever = np.stack([np.ones_like(reach), reach], 1)
    return EndEffectorMotion(
        position=states.p_WE[:, :2],
        axes=axes,
        reach=reach,
        psi=_psi(axes - log[signals.BASE_POSE][:, 2], log),
        velocity=velocity[:, :2],
        rise=velocity[:, 2],
        commanded=lever * command,
        in_force=lever * held,
    )


def _instant_motion(
    model: RobotModel, log: Log
) -> tuple[EndEffectorStates, np.ndarray]:
    """Returns the end effector's states, and its velocity at each instant.

    The velocity is radial, tangential and up (N, 3) [m/s]. A base on wheels leans, so
    there the simulated plant itself says where E is, and how fast. The reach is as the
    arm makes it, in the base's axes turned by its heading alone.
    """
    states = ee_states(model, _positions(log), _rates(log))
    _, axes = _polar(states)
    if signals.TOOL_VELOCITY in log:
        p_WE, v_WE = log[signals.TOOL_POSITION], log[signals.TOOL_VELOCITY]
        shift = p_WE - states.p_WE
        states = EndEffectorStates(p_WE, states.p_WS + shift, v_WE)
    return states, _along(states.v_WE, axes)


def _mean_motion(
    model: RobotModel, log: Log, period: float
) -> tuple[EndEffectorStates, np.ndarray]:
    """Returns the same for joints that move at a constant rate for an Euler step.

    A step gives the arm's end position, not its path. So the arm's part of the velocity
    is the mean over the step, in the coordinates of the command, with the base at rest.
    The base's part is the velocity at this instant, with the arm at rest on it.
    """
    q, v = _positions(log), _rates(log)
    by_arm, by_base = v.copy(), v.copy()
    by_arm[:, :BASE_JOINTS] = by_base[:, BASE_JOINTS:] = 0.0
    states = ee_states(model, q, by_base)
    after = ee_states(model, q + period * by_arm)
    reach, axes = _polar(states)
    reach_after, axes_after = _polar(after)
    # On the shoulder's axis the reach has no direction: the last one is kept.
    turn = np.where(reach_after < _ON_AXIS, 0.0, axes_after - axes)
    turn = np.arctan2(np.sin(turn), np.cos(turn))
    rise = after.p_WE[:, 2] - states.p_WE[:, 2]
    moved = np.stack([reach_after - reach, reach * turn, rise], 1)
    return states, moved / period + _along(states.v_WE, axes)


def _positions(log: Log) -> np.ndarray:
    """Returns positions of base and arm (N, 3 + n)."""
    return np.hstack([log[signals.BASE_POSE], log[signals.ARM_POSITION]])


def _rates(log: Log) -> np.ndarray:
    """Returns rates of base and arm in W (N, 3 + n)."""
    forward, sideways, omega = log[signals.BASE_VELOCITY].T
    theta = log[signals.BASE_POSE][:, 2]
    c, s = np.cos(theta), np.sin(theta)
    base = [forward * c - sideways * s, forward * s + sideways * c, omega]
    return np.hstack([np.stack(base, 1), log[signals.ARM_VELOCITY]])


def _polar(states: EndEffectorStates) -> tuple[np.ndarray, np.ndarray]:
    """Returns the reach S->E (N,) [m] and its angle in W (N,) [rad], seen from above.

    Where E is on the shoulder's axis, the angle is that of the next sample beside it.
    """
    x, y, _ = states.p_SE_W.T
    reach, axes = np.hypot(x, y), np.arctan2(y, x)
    beside = np.flatnonzero(reach >= _ON_AXIS)
    if not beside.size:
        return reach, np.zeros_like(axes)
    following = np.searchsorted(beside, np.arange(len(axes)))
    return reach, axes[beside[np.minimum(following, len(beside) - 1)]]


def _along(v_W: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Returns velocities in W (N, 3) as radial, tangential and up [m/s]."""
    x, y, up = v_W.T
    c, s = np.cos(axes), np.sin(axes)
    return np.stack([c * x + s * y, c * y - s * x, up], 1)


def _psi(angle: np.ndarray, log: Log) -> np.ndarray:
    """Returns angles (N,) [rad], counting whole turns.

    The number of turns at the start is only known from the joints, so from the log.
    """
    unwrapped = np.unwrap(angle)
    turns = np.round((log[signals.EE_CYLINDRICAL][0, 1] - unwrapped[0]) / (2 * np.pi))
    return unwrapped + 2 * np.pi * turns


def manipulability(run: Run) -> np.ndarray:
    """Returns sqrt(det(J J^T)) of T at each sample (N,)."""
    return manipulabilities(run.model, _positions(run.log))
