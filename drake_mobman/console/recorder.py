"""A session on disk while it runs: killed at any time, it can be played back."""

import dataclasses as dc
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from drake_mobman import signals
from drake_mobman.analysis.metrics import metrics
from drake_mobman.report.pictures import figures
from drake_mobman.scenario import AnyScenario
from drake_mobman.scenario.robot_path import located
from drake_mobman.schema import load_typed, load_yaml
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
    check_run_folder,
    write_metrics,
    write_pictures,
)
from drake_mobman.simulation.scenario_texts import SCENARIO, scenario_texts
from drake_mobman.simulation.simulate import Run
from drake_mobman.teleop.recorded import COMMANDS, Recording, header, write_samples

PART = "log.part"
"""The log so far, as `append_log` writes it."""

MAX_DURATION = 86400.0
"""Duration in the scenario of a recording that has not ended [s]."""


def check_recordable(folder: Path) -> None:
    """Checks that a `Recorder` may write to a folder; leaves nothing behind.

    Raises:
        FolderError: if `folder` cannot be made, or holds a recording or files of
            others: a run can be repeated, what a person did cannot.
    """
    if any((resolved(folder) / name).exists() for name in (COMMANDS, PART)):
        why = "it holds a recorded session, which would be lost"
        raise FolderError(refusal(folder, why))
    check_run_folder(folder)


class Recorder:
    """Writes a session to a run folder while it runs.

    From the start the folder has a `scenario.yaml` that plays back the commands written
    so far. `complete` makes an ordinary run folder of it.

    Args:
        scenario: that is driven.
        folder: to be made, or replaced if it holds a run.

    Raises:
        OSError: where the folder cannot be written; `FolderError` if it holds files of
            others, or a recording.
    """

    def __init__(self, scenario: AnyScenario, folder: Path) -> None:
        check_recordable(folder)
        self.folder = folder
        self._rows = 0
        played = dc.replace(scenario, source=Recording(), duration=MAX_DURATION)
        with OutputFolder(folder, RUN) as place:
            texts = scenario_texts(played)
            for name, text in texts.items():
                place.file(name).write_text(text, "utf-8")
            place.file(COMMANDS).write_bytes(header(scenario.period))
            place.publish([*texts, COMMANDS], anew=True)
            self._commands = (place.path / COMMANDS).open("ab")
            self._log = (place.path / PART).open("ab")

    def append(self, log: Log) -> None:
        """Appends the log since the last call.

        Raises:
            OSError: where it cannot be written.
        """
        write_samples(self._commands, log[signals.OPERATOR_INPUT])
        self._commands.flush()
        append_log(self._log, log)
        self._rows += len(log["time"])

    @property
    def plays(self) -> bool:
        """Returns whether there are enough samples to play back: two or more."""
        return self._rows > 1

    def close(self) -> None:
        """Closes the files; the folder can be played back, or completed."""
        for file in (self._commands, self._log):
            # It tries again what `append` could not write, and has raised for.
            with suppress(OSError):
                file.close()

    def drop(self) -> None:
        """Closes the files, and removes the folder, except for files of others."""
        self.close()
        with suppress(OSError), OutputFolder(self.folder, None) as place:
            for name in (COMMANDS, PART):
                (place.path / name).unlink()
            place.clear()


def complete(folder: Path, wall_time: float, died: str = "") -> dict[str, Any]:
    """Makes an ordinary run folder of a recorder's; returns the metrics.

    The recorded commands stay as they are. Figures come last, unless the session died,
    as in `mobman run`.

    Args:
        folder: of a `Recorder` that is closed.
        wall_time: of the session [s].
        died: when and why it died, in one line; empty if it did not.

    Raises:
        OSError: where something cannot be written; then the folder is as it was, or
            lacks only metrics or figures.
    """
    text = (folder / SCENARIO).read_text("utf-8")
    played = load_typed(AnyScenario, located(load_yaml(text), folder.absolute()))
    whole = StoredLog(folder / PART)
    log = StoredLog(folder / PART, finite_rows(whole))
    last = max(len(log["time"]) - 1, 1)
    scenario = dc.replace(played, duration=last * played.period)
    run = Run(scenario, log, wall_time, np.zeros(0), died)
    with OutputFolder(folder, None) as place:
        texts = scenario_texts(scenario)
        for name, text in texts.items():
            place.file(name).write_text(text, "utf-8")
        write_npz(place.file(LOG), log)
        place.publish([*texts, LOG])
        place.adopt(COMMANDS)
        (place.path / PART).unlink()
        numbers = write_metrics(metrics(run), place)
        for error in write_pictures({} if died else figures(run), place):
            raise error
    return numbers
