"""Signals logged: an array over time for each, under its name."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from pydrake.systems.framework import Diagram

from drake_mobman import signals
from drake_mobman.diagrams.signal_log import LOG, signal_sizes

Log = Mapping[str, np.ndarray]
"""`time` (N,) [s], and an array (N, size) for each signal."""

WINDOW = 50_000
"""Samples processed at a time: a log may be larger than memory."""

STATE = (signals.BASE_POSE, signals.ARM_POSITION)
"""The robot's state, from which all other signals follow."""


def read_log(diagram: Diagram, context: Any) -> Log:
    """Returns what the diagram's `log_signals` has logged so far."""
    sizes = signal_sizes(diagram)
    log = diagram.GetSubsystemByName(LOG).FindLog(context)
    borders = np.cumsum(list(sizes.values()))[:-1]
    columns = np.split(log.data().T, borders, axis=1)
    values = map(np.ascontiguousarray, columns)
    return {"time": np.array(log.sample_times())} | dict(
        zip(sizes, values, strict=True)
    )


def drained_log(diagram: Diagram, context: Any) -> Log:
    """Returns what has been logged since the last call, and clears it."""
    log = {name: x.copy() for name, x in read_log(diagram, context).items()}
    diagram.GetSubsystemByName(LOG).FindMutableLog(context).Clear()
    return log


# A log on disk, which grows: a line of JSON with the signals' sizes, then the samples,
# row by row, as little-endian numbers of 8 bytes. A row cut off at the end is ignored.


def append_log(file: BinaryIO, log: Log) -> None:
    """Appends a log to an open file, and flushes it, so that a kill loses nothing."""
    if file.tell() == 0:
        sizes = {name: int(np.prod(x.shape[1:])) for name, x in log.items()}
        header = json.dumps(sizes).encode()
        # Aligned numbers are faster to read.
        file.write(header + b" " * (-(len(header) + 1) % 8) + b"\n")
    columns = [x.reshape(len(x), int(np.prod(x.shape[1:]))) for x in log.values()]
    file.write(np.hstack(columns).astype("<f8").tobytes())
    file.flush()


class StoredLog(Log):
    """A log in a file; a signal is in memory only while it is used.

    Args:
        file: as `append_log` writes it; it may be deleted while it is in use.
        rows: how many of its samples to read; all unless given.

    Raises:
        OSError: where it cannot be read.
    """

    def __init__(self, file: Path, rows: int | None = None) -> None:
        self._file = file.open("rb")
        header = self._file.readline()
        self._start = len(header)
        self._sizes: dict[str, int] = json.loads(header) if header else {"time": 1}
        self._width = sum(self._sizes.values())
        whole = (file.stat().st_size - self._start) // (8 * self._width)
        self._rows = whole if rows is None else min(rows, whole)

    def __getitem__(self, name: str) -> np.ndarray:
        size, at = self._sizes[name], 0
        for other in self._sizes:
            if other == name:
                break
            at += self._sizes[other]
        shape = (self._rows, self._width)
        if not self._rows:
            return np.zeros((0,) if name == "time" else (0, size))
        # Mapped anew each time, so that its memory is freed with the array.
        table = np.memmap(self._file, "<f8", "r", self._start, shape).view(np.ndarray)
        return table[:, at] if name == "time" else table[:, at : at + size]

    def __iter__(self) -> Iterator[str]:
        return iter(self._sizes)

    def __len__(self) -> int:
        return len(self._sizes)


def head(log: Log, rows: int) -> Log:
    """Returns the first samples of a log, in memory."""
    return {name: np.array(x[:rows]) for name, x in log.items()}


def windows(log: Log, before: int = 0) -> Iterator[tuple[int, Log]]:
    """Yields a log in windows, each small enough for memory.

    Args:
        log: of any length.
        before: how many samples of the window before each window repeats.

    Yields:
        How many samples the window repeats, and the window.
    """
    for start in range(0, len(log["time"]), WINDOW):
        shown = min(before, start)
        rows = slice(start - shown, start + WINDOW)
        yield shown, {name: np.array(x[rows]) for name, x in log.items()}


def finite_rows(log: Log) -> int:
    """Returns how many samples come before the first that is not finite."""
    rows = 0
    for _, window in windows(log):
        if found := first_not_finite(window):
            return rows + found[0]
        rows += len(window["time"])
    return rows


def first_not_finite(log: Log) -> tuple[int, str] | None:
    """Returns the first sample that holds a NaN or an infinity, and which signal does.

    Of several signals, the state comes first, as the others follow from it. None where
    all are finite. `operator_input` is not checked: an input device may send anything.
    """
    firsts = {}
    for name in names_in_order(log):
        x = log[name].reshape(len(log[name]), int(np.prod(log[name].shape[1:])))
        finite = np.isfinite(x).all(axis=1)
        if not finite.all():
            firsts[name] = int(np.argmin(finite))
    name = min(firsts, key=firsts.__getitem__, default="")
    return (firsts[name], name) if firsts else None


def names_in_order(named: Mapping[str, Any]) -> list[str]:
    """Returns the names of the signals that must be finite, the state first."""
    names = [name for name in named if name != signals.OPERATOR_INPUT]
    return sorted(names, key=lambda name: name not in STATE)
