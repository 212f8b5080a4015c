"""The run folder: the files of a run."""

import dataclasses as dc
import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from drake_mobman import signals
from drake_mobman.simulation.log import windows
from drake_mobman.simulation.npz import write_npz
from drake_mobman.simulation.output_folder import (
    FolderError,
    OutputFolder,
    check_folder,
    refusal,
    resolved,
)
from drake_mobman.simulation.run import Run
from drake_mobman.simulation.scenario_texts import SCENARIO_FILES, scenario_texts
from drake_mobman.teleop.recorded import COMMANDS, Recording, header, write_samples

LOG, METRICS, SCENE = "log.npz", "metrics.json", "scene.html"

RUN = (*SCENARIO_FILES, LOG, METRICS, "figures/*.png", SCENE)
"""Files that a run may replace. No recording is: a person cannot repeat it."""

Pictures = dict[str, Callable[[], bytes]]
"""Functions that make pictures, by the file's name."""


def check_run_folder(folder: Path, kind: tuple[str, ...] = RUN) -> None:
    """Checks, before a run, that it can be written to a folder.

    Args:
        folder: new, or of an earlier run.
        kind: patterns of the files that may be replaced.

    Raises:
        FolderError: if it cannot be made, or holds a recording or files of others.
    """
    if (resolved(folder) / COMMANDS).exists():
        why = "it holds a recorded session, which would be lost; choose another --out"
        raise FolderError(refusal(folder, why))
    check_folder(folder, kind)


def write_log(
    run: Run,
    folder: OutputFolder,
    every: int = 1,
    progress: Callable[[float], None] = lambda _: None,
) -> None:
    """Writes a run's scenario and log to its folder, in place of an earlier run.

    Where the operator's input was played back, the recording is written too.

    Args:
        run: to write.
        folder: of the run.
        every: keeps each `every`-th sample in `log.npz`.
        progress: called with how much is written [%].

    Raises:
        OSError: where something cannot be written; then the folder is unchanged.
    """
    names, scenario = [LOG], run.scenario
    if isinstance(scenario.source, Recording):
        names, scenario = [COMMANDS, *names], dc.replace(scenario, source=Recording())
        with folder.file(COMMANDS).open("wb") as file:
            file.write(header(run.scenario.period))
            for _, log in windows(run.log):
                write_samples(file, log[signals.OPERATOR_INPUT])
    for name, text in scenario_texts(scenario).items():
        folder.file(name).write_text(text, "utf-8")
        names.append(name)
    write_npz(folder.file(LOG), run.log, every, progress)
    folder.publish(names, anew=True)


def write_metrics(numbers: dict[str, Any], folder: OutputFolder) -> dict[str, Any]:
    """Writes metrics to a run's folder, and returns them as they were written.

    Raises:
        OSError: where they cannot be written.
    """
    numbers = finite(numbers)
    text = json.dumps(numbers, indent=2, allow_nan=False)
    folder.put(METRICS, f"{text}\n".encode())
    return numbers


def write_pictures(
    pictures: Pictures,
    folder: OutputFolder,
    progress: Callable[[float], None] = lambda _: None,
    drawn: Callable[[Callable[[], bytes]], bytes] = lambda draw: draw(),
) -> Iterator[BaseException]:
    """Makes pictures and writes them to a run's folder, one by one.

    Args:
        pictures: to make.
        folder: of the run.
        progress: called with how many have been made.
        drawn: calls a picture's function; it may raise `KeyboardInterrupt`.

    Yields:
        The error of each picture that failed; the others are still made.
    """
    for i, (name, draw) in enumerate(pictures.items(), 1):
        try:
            folder.put(name, drawn(draw))
        except (Exception, SystemExit) as error:  # Drake's assertions are the latter.
            yield error
        progress(i)


def finite(numbers: Any) -> Any:
    """Returns metrics with None for numbers that are not finite: JSON has no NaN."""
    if isinstance(numbers, dict):
        return {key: finite(value) for key, value in numbers.items()}
    if isinstance(numbers, float) and not math.isfinite(numbers):
        return None
    return numbers
