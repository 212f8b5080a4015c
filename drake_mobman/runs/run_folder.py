"""The run folder: what a run leaves behind, whole or not at all."""

import json
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from drake_mobman.runs.figures import draw_figures
from drake_mobman.runs.metrics import metrics
from drake_mobman.runs.schema import dump_typed
from drake_mobman.runs.simulate import Run

_OURS = {"scenario.yaml", "log.npz", "metrics.json", "figures", "scene.html"}
"""What a run folder holds."""

_FIELD = "field_"
"""How the figures of a field begin. A folder with anything else is not ours."""


class FolderError(OSError):
    """A folder that cannot take a run; the message is one line."""


def check_writable(folder: Path) -> None:
    """Finds out, before a run, whether `new_folder` will do; leaves nothing behind.

    Raises:
        FolderError: if `folder` cannot be made, or holds something other than a run.
    """
    missing = [p for p in folder.parents if not p.exists()]
    try:
        shutil.rmtree(_draft(folder))
    finally:
        for parent in missing:
            if parent.is_dir():
                parent.rmdir()


@contextmanager
def new_folder(folder: Path) -> Iterator[Path]:
    """Gives a folder to write to, which takes the place of `folder` at the end.

    So `folder` is always whole: the old run, or the new one if nothing went wrong.

    Raises:
        FolderError: if `folder` cannot be made, or holds something other than a run.
    """
    draft = _draft(folder)
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


def write_run(run: Run, folder: Path) -> dict[str, Any]:
    """Writes a run's scenario, log and metrics to `folder`; returns the metrics.

    Raises:
        OSError: where something could not be written.
    """
    (folder / "scenario.yaml").write_text(dump_typed(run.scenario))
    np.savez_compressed(folder / "log.npz", **run.log)  # type: ignore[arg-type]
    numbers = metrics(run)
    text = json.dumps(numbers, indent=2, allow_nan=False)
    (folder / "metrics.json").write_text(text + "\n")
    return numbers


def write_figures(run: Run, folder: Path) -> None:
    """Draws what the paper draws of such a run to `folder`/figures."""
    (folder / "figures").mkdir()
    for name, figure in draw_figures(run):
        figure.savefig(folder / "figures" / f"{name}.png")


def _draft(folder: Path) -> Path:
    """Returns a new folder beside `folder`, once it is sure that it may replace it."""
    try:
        for parent in folder.parents:
            if parent.exists() and not parent.is_dir():
                raise FolderError(_refusal(folder, f"{parent} is a file"))
        folder.parent.mkdir(parents=True, exist_ok=True)
        if folder.exists():
            _check_is_run(folder)
        draft = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
        draft.chmod(0o755)
    except FolderError:
        raise
    except OSError as error:
        raise FolderError(_refusal(folder, error.strerror or str(error))) from None
    return draft


def _check_is_run(folder: Path) -> None:
    if not folder.is_dir():
        raise FolderError(_refusal(folder, "it is a file"))
    others = sorted(p.name for p in folder.iterdir() if not _is_ours(p.name))
    if others:
        raise FolderError(_refusal(folder, f"it holds {others[0]}, which is no run's"))


def _is_ours(name: str) -> bool:
    return name in _OURS or name.startswith(_FIELD)


def _refusal(folder: Path, why: str) -> str:
    return f"{folder}: cannot be written, {why}; must be a folder of runs or a new one"
