"""A session on disk as it goes on: killed at any time, it can be played back."""

import dataclasses as dc
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from drake_mobman import signals
from drake_mobman.analysis.metrics import metrics
from drake_mobman.scenario import AnyScenario
from drake_mobman.scenario.schema import dump_typed, load_typed, load_yaml
from drake_mobman.simulation.log import Log, StoredLog, append_log, finite_rows
from drake_mobman.simulation.npz import write_npz
from drake_mobman.simulation.output_folder import (
    FolderError,
    OutputFolder,
    refusal,
    resolved,
)
from drake_mobman.simulation.run_folder import (
    LOG,
    RUN,
    SCENARIO,
    check_run_folder,
    figures,
    write_metrics,
    write_pictures,
)
from drake_mobman.simulation.simulate import Run
from drake_mobman.teleop.recorded import COMMANDS, Recording, header, write_samples

PART = "log.part"
"""The log so far, as `append_log` writes it."""

LONGEST = 86400.0
"""What a recorded scenario says of its duration while nobody knows it [s]."""


def check_recordable(folder: Path) -> None:
    """Finds out whether a `Recorder` may write there; leaves nothing behind.

    Raises:
        FolderError: if `folder` cannot be made, or holds a recording or anything else
            that is not ours: a run can be done again, what a person did cannot.
    """
    if any((resolved(folder) / name).exists() for name in (COMMANDS, PART)):
        why = "it holds a recorded session, which would be lost"
        raise FolderError(refusal(folder, why))
    check_run_folder(folder)


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
        with OutputFolder(folder, RUN) as place:
            place.file(SCENARIO).write_text(dump_typed(played), "utf-8")
            place.file(COMMANDS).write_bytes(header(scenario.period))
            place.publish([SCENARIO, COMMANDS], anew=True)
            self._commands = (place.path / COMMANDS).open("ab")
            self._log = (place.path / PART).open("ab")

    def append(self, log: Log) -> None:
        """Appends what has been logged since the last call, and lets go of it.

        Raises:
            OSError: where it cannot be written.
        """
        write_samples(self._commands, log[signals.OPERATOR_INPUT])
        self._commands.flush()
        append_log(self._log, log)
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
        """Closes the files, and removes the folder, but for what is not ours in it."""
        self.close()
        with suppress(OSError), OutputFolder(self.folder, None) as place:
            for name in (COMMANDS, PART):
                (place.path / name).unlink()
            place.clear()


def finish(folder: Path, wall_time: float, died: str = "") -> dict[str, Any]:
    """Makes an ordinary run folder of a recorder's; returns the metrics.

    What was recorded stays as it is. Figures come last, unless it died, as `mobman run`
    has it.

    Args:
        folder: of a `Recorder` that is closed.
        wall_time: of the session [s].
        died: when and why it died, in one line; empty if it did not.

    Raises:
        OSError: where something cannot be written; then the folder is as it was, or
            lacks nothing but metrics or figures.
    """
    text = (folder / SCENARIO).read_text("utf-8")
    played = load_typed(AnyScenario, load_yaml(text))
    whole = StoredLog(folder / PART)
    log = StoredLog(folder / PART, finite_rows(whole))
    last = max(len(log["time"]) - 1, 1)
    scenario = dc.replace(played, duration=last * played.period)
    run = Run(scenario, log, wall_time, np.zeros(0), died)
    with OutputFolder(folder, None) as place:
        place.file(SCENARIO).write_text(dump_typed(scenario), "utf-8")
        write_npz(place.file(LOG), log)
        place.publish([SCENARIO, LOG])
        place.adopt(COMMANDS)
        (place.path / PART).unlink()
        numbers = write_metrics(metrics(run), place)
        for error in write_pictures({} if died else figures(run), place):
            raise error
    return numbers
