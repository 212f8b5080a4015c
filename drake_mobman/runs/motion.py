"""What the hand and the base truly did, worked out from a log."""

import dataclasses as dc
from typing import cast

import numpy as np

from drake_mobman import signals
from drake_mobman.guidance.guiding_hand import holds
from drake_mobman.robots.kinematic import Kinematic
from drake_mobman.robots.model import RobotModel
from drake_mobman.runs.scenario import Guided
from drake_mobman.runs.simulate import Run

_INSTANT = 1e-5
"""Half a difference's step [s]: its error is some 1e-10 m/s, as is rounding's."""


@dc.dataclass(frozen=True)
class HandMotion:
    """The hand's motion in W at each of N samples, in the plane.

    Radial is along the reach S->E, tangential across it, to the left.
    """

    position: np.ndarray  # x, y of E in W (N, 2) [m].
    axes: np.ndarray  # Angle of the reach in W (N,) [rad].
    velocity: np.ndarray  # True velocity: radial, tangential (N, 2) [m/s].
    commanded: np.ndarray  # Commanded from then on: v_c, l omega_c (N, 2) [m/s].
    in_force: np.ndarray  # Commanded of the velocity that is there (N, 2) [m/s].

    @property
    def error(self) -> np.ndarray:
        """Returns the true velocity less the one commanded of it (N, 2) [m/s]."""
        return self.velocity - self.in_force

    def led(self, period: float) -> np.ndarray:
        """Returns x, y in W (N, 2) [m] of where the commanded velocity leads E.

        It is integrated from the start by Euler steps [s], as the robot is.
        """
        radial, tangential = self.commanded.T
        c, s = np.cos(self.axes), np.sin(self.axes)
        v_W = np.stack([radial * c - tangential * s, radial * s + tangential * c], 1)
        steps = np.vstack([self.position[:1], period * v_W[:-1]])
        return np.cumsum(steps, axis=0)

    def drift(self, period: float) -> np.ndarray:
        """Returns how far E is from where the commanded velocity leads (N,) [m]."""
        return np.linalg.norm(self.position - self.led(period), axis=1)


def holding(run: Run) -> np.ndarray:
    """Returns whether the force logged is that of a hand that holds the tool (N,).

    It is the force of the control tick before. An operator's hand holds the tool unless
    it drags another point.
    """
    if signals.DRAG in run.log:
        dragged = run.log[signals.DRAG][:, 0] != 0
        return ~np.append(False, dragged[:-1])
    ticks = run.log["time"] - run.scenario.period / 2
    releases = cast(Guided, run.scenario).hand.releases
    return np.array([holds(time, releases) for time in ticks])


def hand_motion(run: Run) -> HandMotion:
    """Returns the hand's motion in a run; not commanded, it is commanded to rest.

    At fidelity `Kinematic` the hand has at once the velocity that it is commanded. With
    masses, the one that it has at a tick is what the command of the tick before, held
    until then, has made of it.
    """
    log, arm = run.log, run.scenario.robot.arm()
    l, psi = log[signals.WORKSPACE][:, 0], log[signals.WORKSPACE][:, 1]
    x, y, theta = log[signals.BASE_POSE].T
    forward, sideways, omega = log[signals.BASE_VELOCITY].T
    d = arm.p_BS[0]
    rates = workspace_rates(run)
    c, s = np.cos(psi), np.sin(psi)
    # The shoulder's velocity, in B's axes, carries the arm.
    left = sideways + omega * d
    radial = rates[:, 0] + forward * c + left * s
    tangential = l * (rates[:, 1] + omega) - forward * s + left * c
    axes = theta + psi
    position = np.stack(
        [
            x + d * np.cos(theta) + l * np.cos(axes),
            y + d * np.sin(theta) + l * np.sin(axes),
        ],
        1,
    )
    command = log.get(signals.EE_COMMAND, np.zeros((len(l), 3)))[:, :2]
    held = command
    if not isinstance(run.scenario.fidelity, Kinematic):
        held = np.vstack([np.zeros(2), command[:-1]])
    lever = np.stack([np.ones_like(l), l], 1)
    return HandMotion(
        position=position,
        axes=axes,
        velocity=np.stack([radial, tangential], 1),
        commanded=lever * command,
        in_force=lever * held,
    )


def workspace_rates(run: Run) -> np.ndarray:
    """Returns the rates of `workspace` that the arm truly made (N, 3).

    At fidelity `Kinematic` the joints go straight for a whole Euler step, so these are
    mean rates over the step; else they are those of the instant.
    """
    log, arm = run.log, run.scenario.robot.arm()
    q, v = log[signals.ARM_POSITION], log[signals.ARM_VELOCITY]

    def workspace_after(time: float) -> np.ndarray:
        return np.array([arm.workspace(sample) for sample in q + time * v])

    if isinstance(run.scenario.fidelity, Kinematic):
        period = run.scenario.period
        return (workspace_after(period) - log[signals.WORKSPACE]) / period
    after, before = workspace_after(_INSTANT), workspace_after(-_INSTANT)
    return (after - before) / (2 * _INSTANT)


def manipulability(run: Run) -> np.ndarray:
    """Returns sqrt(det(J J^T)) of T at each sample (N,)."""
    log, model = run.log, RobotModel(run.scenario.robot)
    q = np.hstack([log[signals.BASE_POSE], log[signals.ARM_POSITION]])
    still = np.zeros(q.shape[1])
    values = []
    for sample in q:
        model.set_state(sample, still)
        values.append(model.manipulability())
    return np.array(values)
