"""The numbers by which runs are compared."""

import dataclasses as dc
import math
import platform
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import numpy as np

from drake_mobman import __version__, signals
from drake_mobman.analysis.motion import (
    EndEffectorMotion,
    ee_motion,
    holding,
    manipulability,
)
from drake_mobman.robot_model import RobotModel, WorkspaceLimits
from drake_mobman.simulation.log import Log, windows
from drake_mobman.simulation.simulate import Run

_BEFORE = 2
"""Samples of the window before that a window has to show: jerk is of three."""


def metrics(
    run: Run, progress: Callable[[float], None] = lambda _: None
) -> dict[str, Any]:
    """Returns a run's metrics by name, SI units; see the run folder's documentation.

    A number that the run is too short to tell is None, or is left out where the run
    died before its first sample. The log is gone through by windows, which fit into
    memory however long it is.

    Args:
        run: to measure.
        progress: told the time gone through so far [s], now and then.
    """
    if not len(run.log["time"]):
        return of_no_sample(run)
    guided = signals.HAND_FORCE in run.log
    tallies = (_Guided() if guided else _Commanded(), _Robot())
    for shown, log in windows(run.log, _BEFORE):
        for tally in tallies:
            tally.take(dc.replace(run, log=log), shown)
        progress(float(log["time"][-1]))
    of_the_hand, of_the_robot = (tally.numbers() for tally in tallies)
    return of_the_hand | of_the_robot | _of_the_clock(run) | of_no_sample(run)


def of_no_sample(run: Run) -> dict[str, Any]:
    """Returns what there is to tell of a run without a look at its log."""
    versions = {
        "drake": version("drake"),
        "python": platform.python_version(),
        "drake_mobman": __version__,
    }
    return {"died": run.died or None, "versions": versions}


def _of_the_clock(run: Run) -> dict[str, Any]:
    return {
        "step_time_us": _spread(run.tick_times * 1e6),
        "real_time_factor": float(run.log["time"][-1] / run.wall_time),
    }


# A tally takes one window of the log after the other, with how many of its samples the
# window before has shown already.


class _Numbers:
    """Numbers that come by and by."""

    def __init__(self) -> None:
        self.largest: float | None = None  # As absolute values go.
        self._squares, self._count = 0.0, 0

    def take(self, x: np.ndarray) -> None:
        """Takes some more."""
        if x.size:
            self.largest = max(self.largest or 0.0, float(np.max(np.abs(x))))
            self._squares += float(np.sum(x * x))
            self._count += x.size

    @property
    def rms(self) -> float | None:
        """Returns their root mean square."""
        return math.sqrt(self._squares / self._count) if self._count else None


class _Robot:
    """Metrics of what base and arm do."""

    def __init__(self) -> None:
        self._speed, self._yaw_rate, self._joint_speed = (_Numbers() for _ in range(3))
        self._jerk, self._slip = _Numbers(), _Numbers()
        self._manipulability = self._margin = math.inf

    def take(self, run: Run, _: int) -> None:
        """Takes a window; samples shown twice make no difference."""
        log, period = run.log, run.scenario.period
        sent = log[signals.BASE_COMMAND_SMOOTHED]
        self._speed.take(sent[:, 0])
        self._yaw_rate.take(sent[:, 1])
        self._joint_speed.take(log[signals.ARM_VELOCITY])
        self._jerk.take(np.diff(sent[:, 0], 2) / period**2)
        self._slip.take(log[signals.BASE_VELOCITY][:, 1])
        least = float(np.min(manipulability(run)))
        self._manipulability = min(self._manipulability, least)
        self._margin = min(self._margin, joint_margin(run))

    def numbers(self) -> dict[str, Any]:
        """Returns the metrics."""
        return {
            "base_speed_max": self._speed.largest,
            "base_yaw_rate_max": self._yaw_rate.largest,
            "joint_speed_max": self._joint_speed.largest,
            "base_jerk_rms": self._jerk.rms,
            "lateral_slip_max": self._slip.largest,
            "manipulability_min": self._manipulability,
            "joint_margin_min": self._margin,
        }


class _Commanded:
    """Metrics of a hand that is commanded."""

    def __init__(self) -> None:
        self._error, self._drift = _Numbers(), _Numbers()
        self._led: Any = None  # Where the command has led E (2,) [m], so far.
        self._excess = {"l": 0.0, "psi": 0.0}
        self._linear, self._angular = _Flips(0), _Flips(1)
        self._refused = 0

    def take(self, run: Run, shown: int) -> None:
        """Takes a window."""
        motion = ee_motion(run)
        self._error.take(np.linalg.norm(motion.error[shown:], axis=1))
        led = motion.led(run.scenario.period)
        if self._led is not None:
            led += self._led - led[shown - 1]
        self._led = led[-1]
        self._drift.take(np.linalg.norm(motion.position - led, axis=1)[shown:])
        excess = workspace_excess(motion, run.scenario.workspace)
        self._excess = {key: max(self._excess[key], excess[key]) for key in excess}
        fresh = {name: x[shown:] for name, x in run.log.items()}
        self._linear.take(fresh)
        self._angular.take(fresh)
        self._refused += int(np.count_nonzero(fresh[signals.GUARD_STATUS]))

    def numbers(self) -> dict[str, Any]:
        """Returns the metrics."""
        return {
            "ee_error_rms": self._error.rms,
            "ee_error_max": self._error.largest,
            "ee_drift_max": self._drift.largest,
            "workspace_excess_max": self._excess,
            "authority_flips": {
                "linear": self._linear.count,
                "angular": self._angular.count,
            },
            "commands_refused": self._refused,
        }


class _Guided:
    """Metrics of a hand that pulls; its error, while it holds the tool."""

    def __init__(self) -> None:
        self._force, self._error = _Numbers(), _Numbers()

    def take(self, run: Run, shown: int) -> None:
        """Takes a window."""
        log = run.log
        gap = log[signals.HAND_POSITION] - log[signals.TOOL_POSITION]
        held = holding(run)[shown:]
        self._force.take(np.linalg.norm(log[signals.HAND_FORCE], axis=1))
        self._error.take(np.linalg.norm(gap, axis=1)[shown:][held])

    def numbers(self) -> dict[str, Any]:
        """Returns the metrics."""
        return {
            "hand_force_max": self._force.largest,
            "hand_error_max": self._error.largest,
        }


class _Flips:
    """How often authority passed between arm and base.

    That is, how often the base's share of the linear (0) or angular (1) command
    crossed one half while the command was not zero.
    """

    def __init__(self, component: int) -> None:
        self.count = 0
        self._component = component
        self._last: list[bool] = []  # Whether the base had it, as far as one knows.

    def take(self, log: Log) -> None:
        """Takes samples that were not shown before."""
        command = log[signals.EE_COMMAND][:, self._component]
        share = log[signals.BASE_CONTRIBUTION][:, self._component]
        given = command != 0
        with_base = [*self._last, *(share[given] / command[given] > 0.5)]
        self.count += int(np.count_nonzero(np.diff(with_base)))
        self._last = with_base[-1:]


def joint_margin(run: Run) -> float:
    """Returns how near a joint of the arm came to a limit [rad]; below 0, past it."""
    limits = RobotModel(run.scenario.robot).joint_limits
    q = run.log[signals.ARM_POSITION]
    return float(min(np.min(q - limits.lower), np.min(limits.upper - q)))


def workspace_excess(
    motion: EndEffectorMotion, limits: WorkspaceLimits
) -> dict[str, float]:
    """Returns how far l [m] and psi [rad] went past their limits."""
    l, psi = motion.reach, motion.psi
    return {
        "l": float(max(0.0, np.max(l) - limits.l_max, limits.l_min - np.min(l))),
        "psi": float(
            max(0.0, np.max(psi) - limits.psi_max, limits.psi_min - np.min(psi))
        ),
    }


def _spread(times: np.ndarray) -> dict[str, float] | None:
    if not times.size:
        return None
    return {
        "mean": float(np.mean(times)),
        "median": float(np.median(times)),
        "p99": float(np.percentile(times, 99)),
        "max": float(np.max(times)),
    }
