"""The run folder: what a run leaves behind, whole or not at all."""

import dataclasses as dc
import json
import math
import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from drake_mobman import signals
from drake_mobman.runs.figures import draw_figures
from drake_mobman.runs.metrics import metrics
from drake_mobman.runs.schema import dump_typed
from drake_mobman.runs.simulate import Run
from drake_mobman.teleop.recorded import COMMANDS, Recording, header, write_samples

RUN = (
    "scenario.yaml",
    COMMANDS,
    "log.npz",
    "metrics.json",
    "figures",
    "scene.html",
)
"""What a run folder holds; one with anything else is not ours to replace."""

FIELD = ("field_*.png",)
"""The same of a folder of a field's figures."""

COMPARISON = ("scenario.yaml", "comparison.md", "comparison.json", "comparison.png")
"""The same of a folder of a scenario's comparison."""


class FolderError(OSError):
    """A folder that cannot take a run; the message is one line."""


def check_writable(folder: Path, ours: Sequence[str] = RUN) -> None:
    """Finds out, before a run, whether `new_folder` will do; leaves nothing behind.

    Args:
        folder: to be made or replaced.
        ours: patterns of what may be in it and be replaced.

    Raises:
        FolderError: if `folder` cannot be made, or holds something else.
    """
    missing = [p for p in folder.parents if not p.exists()]
    try:
        shutil.rmtree(_draft(folder, ours))
    finally:
        for parent in missing:
            if parent.is_dir():
                parent.rmdir()


@contextmanager
def new_folder(folder: Path, ours: Sequence[str] = RUN) -> Iterator[Path]:
    """Gives a folder to write to, which takes the place of `folder` at the end.

    So `folder` is always whole: the old one, or the new one if nothing went wrong.

    Args:
        folder: to be made or replaced.
        ours: patterns of what may be in it and be replaced.

    Raises:
        FolderError: if `folder` cannot be made, or holds something else.
    """
    draft = _draft(folder, ours)
    try:
        yield draft
        if folder.exists():
            old = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
            folder.rename(old / folder.name)
            draft.rename(folder)
            shutil.rmtree(old)
        else:
            draft.rename(folder)
    except BaseException:
        shutil.rmtree(draft, ignore_errors=True)
        raise


@contextmanager
def new_file(file: Path) -> Iterator[Path]:
    """Gives a file to write to, which takes the place of `file` at the end.

    Raises:
        FolderError: if `file` cannot be made.
    """
    if file.is_dir():
        raise FolderError(f"{file}: cannot be written, it is a folder")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{file.name}.", dir=file.parent)
    except OSError as error:
        raise FolderError(f"{file}: cannot be written, {error.strerror}") from None
    os.close(handle)
    draft = Path(name)
    try:
        draft.chmod(0o644)
        yield draft
        draft.replace(file)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise


def write_run(run: Run, folder: Path) -> dict[str, Any]:
    """Writes a run's scenario, log and metrics to `folder`; returns the metrics.

    A recorded operator comes along: what he said is in the log.

    Raises:
        OSError: where something could not be written.
    """
    scenario = run.scenario
    if isinstance(getattr(scenario, "source", None), Recording):
        scenario = dc.replace(scenario, source=Recording())
        with (folder / COMMANDS).open("wb") as file:
            file.write(header(run.scenario.period))
            write_samples(file, run.log[signals.OPERATOR_INPUT])
    (folder / "scenario.yaml").write_text(dump_typed(scenario))
    np.savez_compressed(folder / "log.npz", **run.log)  # type: ignore[arg-type]
    numbers = finite(metrics(run))
    text = json.dumps(numbers, indent=2, allow_nan=False)
    (folder / "metrics.json").write_text(text + "\n")
    return numbers


def write_figures(run: Run, folder: Path) -> None:
    """Draws what the paper draws of such a run to `folder`/figures."""
    (folder / "figures").mkdir()
    for name, figure in draw_figures(run):
        figure.savefig(folder / "figures" / f"{name}.png")


def finite(numbers: Any) -> Any:
    """Returns metrics with None for what is not finite, which JSON has no word for."""
    if isinstance(numbers, dict):
        return {key: finite(value) for key, value in numbers.items()}
    if isinstance(numbers, float) and not math.isfinite(numbers):
        return None
    return numbers


def _draft(folder: Path, ours: Sequence[str]) -> Path:
    """Returns a new folder beside `folder`, once it is sure that it may replace it."""
    try:
        for parent in folder.parents:
            if parent.exists() and not parent.is_dir():
                raise FolderError(_refusal(folder, f"{parent} is a file"))
        folder.parent.mkdir(parents=True, exist_ok=True)
        if folder.exists():
            _check_is_ours(folder, ours)
        draft = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
        draft.chmod(0o755)
    except FolderError:
        raise
    except OSError as error:
        raise FolderError(_refusal(folder, error.strerror or str(error))) from None
    return draft


def _check_is_ours(folder: Path, ours: Sequence[str]) -> None:
    if not folder.is_dir():
        raise FolderError(_refusal(folder, "it is a file"))
    for path in sorted(folder.iterdir()):
        if not any(path.match(pattern) for pattern in ours):
            why = f"it holds {path.name}, which would be lost"
            raise FolderError(_refusal(folder, why))


def _refusal(folder: Path, why: str) -> str:
    return f"{folder}: cannot be written, {why}; must be new, or of an earlier run"
