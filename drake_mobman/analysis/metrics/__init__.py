"""The numbers by which runs are compared.

A new metric is a file beside this one with a `Metric`, and a line that imports it here.
"""

import inspect
import platform
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

from drake_mobman import __version__
from drake_mobman.analysis.metrics.metric import Metric
from drake_mobman.analysis.metrics.window import Window, run_windows
from drake_mobman.simulation.run import Run

# In the order in which metrics are listed.
# isort: off
from drake_mobman.analysis.metrics.ee_error import EndEffectorError
from drake_mobman.analysis.metrics.ee_drift import EndEffectorDrift
from drake_mobman.analysis.metrics.workspace_excess import WorkspaceExcess
from drake_mobman.analysis.metrics.authority_flips import AuthorityFlips
from drake_mobman.analysis.metrics.commands_refused import CommandsRefused
from drake_mobman.analysis.metrics.hand_force import HandForce
from drake_mobman.analysis.metrics.hand_error import HandError
from drake_mobman.analysis.metrics.base_speed import BaseSpeed
from drake_mobman.analysis.metrics.joint_speed import JointSpeed
from drake_mobman.analysis.metrics.base_jerk import BaseJerk
from drake_mobman.analysis.metrics.lateral_slip import LateralSlip
from drake_mobman.analysis.metrics.tip_margin import TipMargin
from drake_mobman.analysis.metrics.manipulability import Manipulability
from drake_mobman.analysis.metrics.joint_margin import JointMargin
from drake_mobman.analysis.metrics.step_time import StepTime
from drake_mobman.analysis.metrics.real_time_factor import RealTimeFactor

# isort: on

__all__ = ["METRICS", "Metric", "Window", "metrics", "of_no_sample"]

METRICS: list[type[Metric]] = [
    kind
    for kind in [*globals().values()]
    if inspect.isclass(kind)
    and issubclass(kind, Metric)
    and not inspect.isabstract(kind)
]
"""All metrics: the classes imported above, in their order."""


def metrics(
    run: Run, progress: Callable[[float], None] = lambda _: None
) -> dict[str, Any]:
    """Returns a run's metrics by name, in SI units; see the run folder's documentation.

    A number is None where the run is too short for it, and missing where the run died
    before its first sample. The log is read in windows, so that a log of any length
    fits into memory.

    Args:
        run: to measure.
        progress: called from time to time with the time measured so far [s].
    """
    numbers: dict[str, Any] = {}
    if len(run.time):
        applicable = [kind() for kind in METRICS if kind.applies(run.log)]
        for window in run_windows(run):
            for metric in applicable:
                metric.take(window)
            progress(float(window["time"][-1]))
        for metric in applicable:
            numbers |= metric.numbers()
    return numbers | of_no_sample(run)


def of_no_sample(run: Run) -> dict[str, Any]:
    """Returns what needs no log: why the run died, and versions."""
    stepped_by = run.scenario.engine.package
    versions = {
        **{
            package: version(package)
            for package in dict.fromkeys(("drake", stepped_by))
        },
        "python": platform.python_version(),
        "drake_mobman": __version__,
    }
    return {"died": run.died or None, "versions": versions}
