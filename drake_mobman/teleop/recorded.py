"""An operator's session, played back sample by sample."""

import dataclasses as dc
import math
import re
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO, ClassVar

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_mobman import signals
from drake_mobman.parameters import ParameterError, checked_period
from drake_mobman.scalars import Matrix
from drake_mobman.teleop.live import NOBODY, SIZE, OperatorSample

COMMANDS = "commands.bin"
"""The file's name in a run folder."""


def header(period: float) -> bytes:
    """Returns the first line of the file of a recording at this period [s].

    After it come samples (N, SIZE), row by row, one a period from time 0 on, as
    little-endian numbers of 8 bytes. The last row may be incomplete.
    """
    return _named(SIZE) + f"; period {period!r} s\n".encode()


def _named(size: int) -> bytes:
    names = ", ".join(OperatorSample._fields[:size])
    return f"{signals.OPERATOR_INPUT}: {names}; <f8".encode()


_SIZES = {_named(size): size for size in (SIZE, 7)}
"""Sizes of samples, by the header; the second is of version 0.1, without a drag."""

_HEADER = re.compile(rb"([^\n]*; <f8)(?:; period (\d+(?:\.\d+)?(?:e[+-]?\d+)?) s)?\n")
"""The components of a sample, and the period, which the first files do not have."""


@dc.dataclass
class Recording:
    """A recorded session, as it reached the gate; the run lasts as long."""

    fed: ClassVar[bool] = False
    finite: ClassVar[bool] = False

    file: str = COMMANDS  # Path, relative to the folder of the scenario.

    def check(self) -> None:
        """Raises `ParameterError` unless a file is named."""
        if not self.file:
            raise ParameterError("file", self.file, "must be the path of a recording")

    def in_folder(self, folder: Path) -> "Recording":
        """Returns the same with an absolute path, for a scenario in this folder."""
        return Recording(str((folder / self.file).resolve()))

    def samples(self, period: float) -> Matrix:
        """Returns `operator_input` at each period from time 0 on (N, SIZE), N >= 2.

        Args:
            period: control period of the run [s].

        Raises:
            ParameterError: where the file cannot be read, holds no recording, or holds
                one at another period, which would run too slow or too fast.
        """
        path = Path(self.file)
        samples = read_samples(path)
        recorded = recorded_period(path)
        if recorded is not None and not math.isclose(period, recorded):
            valid = f"must be played back at its own period of {recorded!r} s"
            raise ParameterError("file", self.file, f"{valid}, not at {period!r} s")
        return samples

    def build(self, period: float) -> "RecordedSource":
        """Returns the block, for a control period [s]."""
        return RecordedSource(self.samples(period), period)


def write_samples(file: BinaryIO, samples: Matrix) -> None:
    """Appends samples (N, SIZE) to an open file, which begins with the header."""
    file.write(np.ascontiguousarray(samples, dtype="<f8").tobytes())


def read_samples(path: Path) -> Matrix:
    """Returns the samples (N, SIZE) in a file, without an incomplete one at its end.

    Raises:
        ParameterError: where it cannot be read, or holds no recording.
    """
    valid = "must be a recorded session"
    if path.exists() and not path.is_file():
        # A pipe may never get data, and some devices never end.
        raise ParameterError("file", str(path), valid)
    try:
        data = path.read_bytes()
    except OSError as error:
        why = f"cannot be read, {error.strerror}; {valid}"
        raise ParameterError("file", str(path), why) from None
    first = _HEADER.match(data)
    if first is None or first[1] not in _SIZES:
        raise ParameterError("file", str(path), valid)
    size, start = _SIZES[first[1]], first.end()
    rows = (len(data) - start) // (8 * size)
    if rows < 2:
        raise ParameterError("file", str(path), f"{valid} of one period or more")
    samples = np.tile(NOBODY, (rows, 1))
    values = np.frombuffer(data, "<f8", rows * size, start)
    samples[:, :size] = values.reshape(rows, size)
    return samples


def recorded_period(path: Path) -> float | None:
    """Returns the period of the recording in a file [s], or None if it is not known.

    The first files have it only in the scenario of their run folder.
    """
    with suppress(OSError, ValueError):
        with path.open("rb") as file:
            first = _HEADER.match(file.readline())
        if first and first[2]:
            return float(first[2])
        scenario = path.with_name("scenario.yaml").read_text()
        if found := re.search(r"^period: *(\S+)", scenario, re.MULTILINE):
            return float(found[1])
    return None


class RecordedSource(LeafSystem):
    """Puts out a recording, sample by sample; after it, there is no operator.

    .. pydrake_system::

        name: RecordedSource
        output_ports:
        - operator_input

    The state is the sample, renewed at each tick, as in `LiveSource`: so the output is
    that of the session between the ticks, too.

    Args:
        samples: `operator_input` (N, SIZE), one a period from time 0 on.
        period: control period [s].

    Raises:
        ParameterError: where the period is not valid.
    """

    def __init__(self, samples: Matrix, period: float) -> None:
        super().__init__()
        self.period = checked_period(period)
        self._samples = np.array(samples, dtype=float)
        state = self.DeclareDiscreteState(self._at(0))
        self.DeclareStateOutputPort(signals.OPERATOR_INPUT, state)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._advance)

    def _at(self, k: int) -> Matrix:
        return self._samples[k] if k < len(self._samples) else np.array(NOBODY)

    def _advance(self, context: Any, state: Any) -> None:
        # The sample of one tick is put out, and logged, until the next.
        k = round(context.get_time() / self.period) + 1
        state.get_mutable_vector().SetFromVector(self._at(k))
