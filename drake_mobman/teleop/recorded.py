"""An operator's session, played back: what was said, sample by sample."""

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
from drake_mobman.teleop.live import NOBODY, SIZE, OperatorSample

COMMANDS = "commands.bin"
"""The file's name in a run folder."""


def header(period: float) -> bytes:
    """Returns the first line of the file of a recording at this period [s].

    After it, samples (N, SIZE) row by row, one a period from time 0 on, as numbers of 8
    bytes, little-endian: read whole up to wherever it ends.
    """
    return _named(SIZE) + f"; period {period!r} s\n".encode()


def _named(size: int) -> bytes:
    names = ", ".join(OperatorSample._fields[:size])
    return f"{signals.OPERATOR_INPUT}: {names}; <f8".encode()


_SIZES = {_named(size): size for size in (SIZE, 7)}
"""Of samples, by what the header says of them; the second is of before anything could
be dragged."""

_HEADER = re.compile(rb"([^\n]*; <f8)(?:; period (\d+(?:\.\d+)?(?:e[+-]?\d+)?) s)?\n")
"""What is in a sample, and the period, which was not told at first."""


@dc.dataclass
class Recording:
    """A recorded session, as it reached the gate; the run is as long as that is."""

    file: str = COMMANDS  # Path, from the folder that the scenario is in.

    def check(self) -> None:
        """Raises `ParameterError` unless a file is named."""
        if not self.file:
            raise ParameterError("file", self.file, "must be the path of a recording")

    def in_folder(self, folder: Path) -> "Recording":
        """Returns the same with its path from wherever the program runs."""
        return Recording(str((folder / self.file).resolve()))

    def samples(self, period: float) -> Any:
        """Returns `operator_input` at each period from time 0 on (N, SIZE), N >= 2.

        Args:
            period: to play it back at [s].

        Raises:
            ParameterError: where the file cannot be read, or holds no recording, or one
                at another period, which would be played back too slow or too fast.
        """
        path = Path(self.file)
        samples = read_samples(path)
        recorded = recorded_period(path)
        if recorded is not None and not math.isclose(period, recorded):
            valid = f"must be played back at its own period of {recorded!r} s"
            raise ParameterError("file", self.file, f"{valid}, not at {period!r} s")
        return samples

    fed: ClassVar[bool] = False
    finite: ClassVar[bool] = False

    def build(self, period: float) -> Any:
        """Returns the block, for a control period [s]."""
        return RecordedSource(self.samples(period), period)


def write_samples(file: BinaryIO, samples: Any) -> None:
    """Appends samples (N, SIZE) to an open file, which begins with the header."""
    file.write(np.ascontiguousarray(samples, dtype="<f8").tobytes())


def read_samples(path: Path) -> Any:
    """Returns the samples (N, SIZE) in a file; what is cut off at its end is left out.

    Raises:
        ParameterError: where it cannot be read, or holds no recording.
    """
    valid = "must be a recorded session"
    if path.exists() and not path.is_file():
        # Nobody may ever say a word in a pipe, and some devices never end.
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
    said = np.frombuffer(data, "<f8", rows * size, start)
    samples[:, :size] = said.reshape(rows, size)
    return samples


def recorded_period(path: Path) -> float | None:
    """Returns the period of the recording in a file [s]; None if nobody knows it.

    A file of before it told this has, in its run folder, a scenario that does.
    """
    with suppress(OSError, ValueError):
        with path.open("rb") as file:
            first = _HEADER.match(file.readline())
        if first and first[2]:
            return float(first[2])
        scenario = path.with_name("scenario.yaml").read_text()
        if said := re.search(r"^period: *(\S+)", scenario, re.MULTILINE):
            return float(said[1])
    return None


class RecordedSource(LeafSystem):
    """Says at each control tick what was said in the recording; then nobody is there.

    .. pydrake_system::

        name: RecordedSource
        output_ports:
        - operator_input

    The state is the sample, renewed at each tick, just as in `LiveSource`: between the
    ticks, too, everyone sees what was seen in the session.

    Args:
        samples: `operator_input` (N, SIZE), one a period from time 0 on.
        period: control period [s].

    Raises:
        ParameterError: where the period is not valid.
    """

    def __init__(self, samples: Any, period: float) -> None:
        super().__init__()
        self.period = checked_period(period)
        self._samples = np.array(samples, dtype=float)
        state = self.DeclareDiscreteState(self._at(0))
        self.DeclareStateOutputPort(signals.OPERATOR_INPUT, state)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._go_on)

    def _at(self, k: int) -> Any:
        return self._samples[k] if k < len(self._samples) else np.array(NOBODY)

    def _go_on(self, context: Any, state: Any) -> None:
        # What is said at one tick is seen until the next, and logged there.
        k = round(context.get_time() / self.period) + 1
        state.get_mutable_vector().SetFromVector(self._at(k))
