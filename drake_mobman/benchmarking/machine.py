"""The machine and the versions that a benchmark ran on."""

import os
import platform
from contextlib import suppress
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

_SOLVERS = ("qpsolvers", "daqp", "proxsuite", "quadprog")
"""The dense solvers by the names of their packages."""


def ran_on() -> dict[str, Any]:
    """Returns the date, the machine, and the versions of the packages that count."""
    numbers = {}
    for name in ("drake_mobman", "drake", "numpy", *_SOLVERS):
        with suppress(PackageNotFoundError):
            numbers[name] = version(name)
    return {
        "date": datetime.now(UTC).date().isoformat(),
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
        **numbers,
    }


def _processor() -> str:
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            name, _, value = line.partition(":")
            if name.strip() == "model name":
                return value.strip()
    return platform.processor() or platform.machine()
