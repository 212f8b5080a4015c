"""Whether there is room for a scenario's log, before anything is simulated."""

import os
import shutil
from pathlib import Path

from drake_mobman.diagrams import make_diagram
from drake_mobman.parameters import ParameterError
from drake_mobman.scenario import AnyScenario

_NUMBER = 8
"""Bytes of a number."""

_TWICE = 2
"""A log is on disk, or in memory, twice for some time."""

_WIDE = 500
"""Upper bound of the numbers in a sample of the log."""

_MOST_STEPS = 10_000
"""Largest number of the plant's steps in a control period."""


def check_room(scenario: AnyScenario, folder: Path | None = None) -> None:
    """Checks that there is room for a scenario's log.

    Args:
        scenario: checked, as `load_scenario` returns it.
        folder: for the log, which need not exist; in memory unless given.

    Raises:
        ParameterError: where there is no room, or the run would take far too long.
    """
    _check_steps(scenario)
    samples = scenario.duration / scenario.period + 1
    room = _memory() // 2 if folder is None else _disk(folder)
    if samples * _NUMBER * _WIDE * _TWICE < room:
        return
    size = samples * _NUMBER * _numbers(scenario) * _TWICE
    if size > room:
        where = "memory" if folder is None else "disk"
        valid = (
            f"makes {samples:.4g} samples at a period of {scenario.period:g} s, "
            f"{_bytes(size)} of log; there are {_bytes(room)} of {where}"
        )
        raise ParameterError("duration", scenario.duration, valid)


def _check_steps(scenario: AnyScenario) -> None:
    """Raises `ParameterError` where a plant makes too many steps, if there is one."""
    step = getattr(scenario.fidelity, "step", scenario.period)
    steps = scenario.period / step
    if steps > _MOST_STEPS:
        valid = (
            f"makes {steps:.4g} steps of the plant in a control period of "
            f"{scenario.period:g} s; must make at most {_MOST_STEPS}"
        )
        raise ParameterError("fidelity.step", step, valid)


def _numbers(scenario: AnyScenario) -> int:
    """Returns how many numbers a sample of the log holds."""
    diagram = make_diagram(scenario, logged=False)
    ports = map(diagram.get_output_port, range(diagram.num_output_ports()))
    return 1 + sum(port.size() for port in ports)


def _memory() -> int:
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def _disk(folder: Path) -> int:
    there = next(at for at in (folder, *folder.parents) if at.exists())
    return shutil.disk_usage(there).free


def _bytes(size: float) -> str:
    for unit in ("B", "kB", "MB", "GB", "TB"):
        if size < 1000:
            return f"{size:.3g} {unit}"
        size /= 1000
    return f"{size:.3g} PB"
