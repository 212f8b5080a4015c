"""The numbers by which runs are compared."""

import platform
from importlib.metadata import version
from typing import Any

import numpy as np

from drake_mobman import __version__, signals
from drake_mobman.decomposers.share import Workspace
from drake_mobman.robots.model import RobotModel
from drake_mobman.runs.log import Log
from drake_mobman.runs.motion import HandMotion, hand_motion, holding, manipulability
from drake_mobman.runs.simulate import Run


def metrics(run: Run) -> dict[str, Any]:
    """Returns a run's metrics by name, SI units; see the run folder's documentation.

    A number that the run is too short to tell is None, or is left out where the run
    died before its first sample.
    """
    log, scenario = run.log, run.scenario
    versions = {
        "drake": version("drake"),
        "python": platform.python_version(),
        "drake_mobman": __version__,
    }
    if not len(log["time"]):
        return {"died": run.died, "versions": versions}
    sent = log[signals.BASE_SENT]
    of_the_hand = _guided(run) if signals.HAND_FORCE in log else _commanded(run)
    return of_the_hand | {
        "base_speed_max": _largest(sent[:, 0]),
        "base_yaw_rate_max": _largest(sent[:, 1]),
        "joint_speed_max": _largest(log[signals.ARM_VELOCITY]),
        "base_jerk_rms": _rms(np.diff(sent[:, 0], 2) / scenario.period**2),
        "lateral_slip_max": _largest(log[signals.BASE_VELOCITY][:, 1]),
        "manipulability_min": float(np.min(manipulability(run))),
        "joint_margin_min": joint_margin(run),
        "step_time_us": _spread(run.tick_times * 1e6),
        "real_time_factor": float(log["time"][-1] / run.wall_time),
        "died": run.died or None,
        "versions": versions,
    }


def _commanded(run: Run) -> dict[str, Any]:
    """Returns the metrics of a hand that is commanded."""
    log, motion = run.log, hand_motion(run)
    error = np.linalg.norm(motion.error, axis=1)
    return {
        "ee_error_rms": _rms(error),
        "ee_error_max": _largest(error),
        "ee_drift_max": _largest(motion.drift(run.scenario.period)),
        "workspace_excess_max": workspace_excess(motion, run.scenario.workspace),
        "authority_flips": {
            "linear": authority_flips(log, 0),
            "angular": authority_flips(log, 1),
        },
        "commands_refused": int(np.count_nonzero(log[signals.GUARD_STATUS])),
    }


def _guided(run: Run) -> dict[str, Any]:
    """Returns the metrics of a hand that pulls; its error, while it holds the tool."""
    log = run.log
    gap = np.linalg.norm(
        log[signals.HAND_POSITION] - log[signals.TOOL_POSITION], axis=1
    )
    force = np.linalg.norm(log[signals.HAND_FORCE], axis=1)
    return {
        "hand_force_max": _largest(force),
        "hand_error_max": _largest(gap[holding(run)]),
    }


def joint_margin(run: Run) -> float:
    """Returns how near a joint of the arm came to a limit [rad]; below 0, past it."""
    limits = RobotModel(run.scenario.robot).limits
    q = run.log[signals.ARM_POSITION]
    return float(min(np.min(q - limits.lower), np.min(limits.upper - q)))


def workspace_excess(motion: HandMotion, limits: Workspace) -> dict[str, float]:
    """Returns how far l [m] and psi [rad] went past their limits."""
    l, psi = motion.reach, motion.psi
    return {
        "l": float(max(0.0, np.max(l) - limits.l_max, limits.l_min - np.min(l))),
        "psi": float(
            max(0.0, np.max(psi) - limits.psi_max, limits.psi_min - np.min(psi))
        ),
    }


def authority_flips(log: Log, component: int) -> int:
    """Returns how often authority passed between arm and base.

    That is, how often the base's share of the linear (0) or angular (1) command
    crossed one half while the command was not zero.
    """
    command = log[signals.EE_COMMAND][:, component]
    share = log[signals.BASE_SHARE][:, component]
    given = command != 0
    with_base = share[given] / command[given] > 0.5
    return int(np.count_nonzero(with_base[1:] != with_base[:-1]))


def _spread(times: np.ndarray) -> dict[str, float] | None:
    if not times.size:
        return None
    return {
        "mean": float(np.mean(times)),
        "median": float(np.median(times)),
        "p99": float(np.percentile(times, 99)),
        "max": float(np.max(times)),
    }


def _rms(x: np.ndarray) -> float | None:
    return float(np.sqrt(np.mean(x * x))) if x.size else None


def _largest(x: np.ndarray) -> float | None:
    return float(np.max(np.abs(x))) if x.size else None
