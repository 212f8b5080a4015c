"""A session on disk as it goes on: killed at any time, it can be played back."""

import dataclasses as dc
import json
import shutil
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from drake_mobman import signals
from drake_mobman.runs.log import Log, until_not_finite
from drake_mobman.runs.run_folder import (
    RUN,
    FolderError,
    check_writable,
    new_folder,
    write_figures,
    write_run,
)
from drake_mobman.runs.scenario import AnyScenario
from drake_mobman.runs.schema import dump_typed, load_typed, load_yaml
from drake_mobman.runs.simulate import Run
from drake_mobman.teleop.recorded import COMMANDS, HEADER, Recording, write_samples

PART = "log.part"
"""The log so far: a line of JSON with the signals' sizes, then samples row by row."""

FILES = (*RUN, PART)
"""What a folder of a session holds; one with anything else is not ours to replace."""

LONGEST = 86400.0
"""What a recorded scenario says of its duration while nobody knows it [s]."""


def check_recordable(folder: Path) -> None:
    """Finds out whether a `Recorder` may write there; leaves nothing behind.

    Raises:
        FolderError: if `folder` cannot be made, or holds a recording or anything else
            that is not ours: a run can be done again, what a person did cannot.
    """
    if any((folder / name).exists() for name in (COMMANDS, PART)):
        raise FolderError(
            f"{folder}: cannot be written, it holds a recorded session, which would be "
            "lost; must be new, or of an earlier run"
        )
    check_writable(folder, FILES)


class Recorder:
    """Writes a session to a run folder as it goes on.

    From the first moment the folder has a `scenario.yaml` that plays back whatever has
    been written of the commands. `finish` makes an ordinary run folder of it.

    Args:
        scenario: what is driven.
        folder: to be made, or replaced if it holds a run.

    Raises:
        OSError: where the folder cannot be written; `FolderError` if it is not ours,
            or holds a recording.
    """

    def __init__(self, scenario: AnyScenario, folder: Path) -> None:
        check_recordable(folder)
        self.folder = folder
        self._rows = 0
        played = dc.replace(scenario, source=Recording(), duration=LONGEST)
        with new_folder(folder, FILES) as draft:
            (draft / "scenario.yaml").write_text(dump_typed(played))
            (draft / COMMANDS).write_bytes(HEADER)
        self._commands = (folder / COMMANDS).open("ab")
        self._log = (folder / PART).open("ab")

    def append(self, log: Log) -> None:
        """Appends what has been logged since the last call, and lets go of it.

        Raises:
            OSError: where it cannot be written.
        """
        write_samples(self._commands, log[signals.OPERATOR_INPUT])
        self._commands.flush()
        if self._log.tell() == 0:
            sizes = {name: x[0].size for name, x in log.items()}
            self._log.write(json.dumps(sizes).encode() + b"\n")
        columns = [x.reshape(len(x), -1) for x in log.values()]
        self._log.write(np.hstack(columns).astype("<f8").tobytes())
        self._log.flush()
        self._rows += len(log["time"])

    @property
    def plays(self) -> bool:
        """Returns whether there is a period to play back, of two samples or more."""
        return self._rows > 1

    def close(self) -> None:
        """Closes the files; what the folder holds can be played back, or finished."""
        for file in (self._commands, self._log):
            # It tries again what `append` could not write, and has told of.
            with suppress(OSError):
                file.close()

    def drop(self) -> None:
        """Closes the files, and removes the folder."""
        self.close()
        shutil.rmtree(self.folder, ignore_errors=True)


def read_part(file: Path) -> Log:
    """Returns the log in a file `PART`; a row cut off at its end is left out."""
    data = file.read_bytes()
    header, _, rest = data.partition(b"\n")
    sizes = json.loads(header)
    width = sum(sizes.values())
    rows = len(rest) // (8 * width)
    table = np.frombuffer(rest, "<f8", rows * width).reshape(rows, width).astype(float)
    borders = np.cumsum(list(sizes.values()))[:-1]
    columns = [np.ascontiguousarray(x) for x in np.split(table, borders, axis=1)]
    log = dict(zip(sizes, columns, strict=True))
    return log | {"time": log["time"][:, 0]}


def finish(folder: Path, wall_time: float, died: str = "") -> dict[str, Any]:
    """Makes an ordinary run folder of a recorder's; returns the metrics.

    Its figures come last, unless it died, as `mobman run` has it.

    Args:
        folder: of a `Recorder` that is closed.
        wall_time: of the session [s].
        died: when and why it died, in one line; empty if it did not.

    Raises:
        OSError: where something cannot be written; then the folder is as it was, or
            lacks nothing but figures.
    """
    played = load_typed(AnyScenario, load_yaml((folder / "scenario.yaml").read_text()))
    log = until_not_finite(read_part(folder / PART))
    last = max(len(log["time"]) - 1, 1)
    scenario = dc.replace(played, duration=last * played.period)
    run = Run(scenario, log, wall_time, np.zeros(0), died)
    with new_folder(folder, FILES) as draft:
        numbers = write_run(run, draft)
    if not died:
        write_figures(run, folder)
    return numbers
