"""The run folder: what a run leaves behind, file by file."""

import dataclasses as dc
import io
import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from drake_mobman import signals
from drake_mobman.figures import figures_of
from drake_mobman.figures.field import field_figures
from drake_mobman.figures.scene import scene
from drake_mobman.figures.style import SMALL
from drake_mobman.scenario import AnyScenario
from drake_mobman.scenario.schema import dump_typed
from drake_mobman.simulation.log import head, windows
from drake_mobman.simulation.npz import write_npz
from drake_mobman.simulation.output_folder import (
    FolderError,
    OutputFolder,
    check_folder,
    refusal,
    resolved,
)
from drake_mobman.simulation.simulate import Run
from drake_mobman.teleop.recorded import COMMANDS, Recording, header, write_samples

SCENARIO, LOG, METRICS, SCENE = (
    "scenario.yaml",
    "log.npz",
    "metrics.json",
    "scene.html",
)

RUN = (SCENARIO, LOG, METRICS, "figures/*.png", SCENE)
"""What a run may replace. But no recording: nobody does the same twice."""

FIELD = ("field_*.png",)
"""The same of a field's figures."""

COMPARISON = (SCENARIO, "comparison.md", "comparison.json", "comparison.png")
"""The same of a scenario's comparison."""

PICTURED = 360_001
"""How many samples of a run are shown in pictures: an hour at 0.01 s."""

Pictures = dict[str, Callable[[], bytes]]
"""What makes each picture, by its file's name."""


def check_run_folder(folder: Path, kind: tuple[str, ...] = RUN) -> None:
    """Finds out, before a run, whether a folder can take it; leaves nothing behind.

    Args:
        folder: its path.
        kind: patterns of what may be replaced there.

    Raises:
        FolderError: if it cannot be made, or holds a recording, or what is not ours.
    """
    if (resolved(folder) / COMMANDS).exists():
        why = "it holds a recorded session, which would be lost; say another --out"
        raise FolderError(refusal(folder, why))
    check_folder(folder, kind)


def write_log(
    run: Run,
    folder: OutputFolder,
    every: int = 1,
    progress: Callable[[float], None] = lambda _: None,
) -> None:
    """Writes a run's scenario and log to its folder; what was there before goes.

    A recorded operator comes along: what he said is in the log.

    Args:
        run: to write.
        folder: of a run.
        every: of how many samples one is kept in `log.npz`.
        progress: told how much of it is done [%].

    Raises:
        OSError: where something cannot be written; then all is as it was.
    """
    names, scenario = [SCENARIO, LOG], run.scenario
    if isinstance(scenario.source, Recording):
        names, scenario = [COMMANDS, *names], dc.replace(scenario, source=Recording())
        with folder.file(COMMANDS).open("wb") as file:
            file.write(header(run.scenario.period))
            for _, log in windows(run.log):
                write_samples(file, log[signals.OPERATOR_INPUT])
    folder.file(SCENARIO).write_text(dump_typed(scenario), "utf-8")
    write_npz(folder.file(LOG), run.log, every, progress)
    folder.publish(names, anew=True)


def write_metrics(numbers: dict[str, Any], folder: OutputFolder) -> dict[str, Any]:
    """Writes metrics to a run's folder, and returns them as they stand there.

    Raises:
        OSError: where they cannot be written.
    """
    numbers = finite(numbers)
    text = json.dumps(numbers, indent=2, allow_nan=False)
    folder.put(METRICS, f"{text}\n".encode())
    return numbers


def figures(run: Run) -> Pictures:
    """Returns what draws the figures that the paper draws of such a run."""
    if not len(run.log["time"]):
        return {}
    shown = _shown(run)
    return {
        f"figures/{name}.png": lambda draw=draw: _png(draw(shown), run)  # type: ignore
        for name, draw in figures_of(shown).items()
    }


def scenes(run: Run) -> Pictures:
    """Returns what makes the motion in 3D, where there is one."""
    if len(run.log["time"]) < 2:
        return {}
    return {SCENE: lambda: scene(_shown(run)).encode()}


def write_pictures(
    pictures: Pictures,
    folder: OutputFolder,
    progress: Callable[[float], None] = lambda _: None,
    drawn: Callable[[Callable[[], bytes]], bytes] = lambda draw: draw(),
) -> Iterator[BaseException]:
    """Makes pictures and writes them to a run's folder, each by itself.

    Args:
        pictures: to make; one of no bytes is left out.
        folder: of a run.
        progress: told how many have been made.
        drawn: has a picture made; it may raise `KeyboardInterrupt`.

    Yields:
        What went wrong with a picture; the others are made all the same.
    """
    for i, (name, draw) in enumerate(pictures.items(), 1):
        try:
            content = drawn(draw)
            if content:
                folder.put(name, content)
        except (Exception, SystemExit) as error:  # Drake's assertions are the latter.
            yield error
        progress(i)


def write_field(
    scenario: AnyScenario, path: Path, drawn: Callable[[Callable[[], bytes]], bytes]
) -> None:
    """Draws the velocity field of a scenario, if it has one, to a folder of its own.

    Args:
        scenario: whose field it is.
        path: of the folder, to be made, or replaced.
        drawn: has a figure made; it may raise `KeyboardInterrupt`.

    Raises:
        OSError: where it cannot be written; then all is as it was.
    """
    if (params := scenario.base_controller) is None:
        return
    reach, smoother, names = scenario.robot.reach(), scenario.smoother, []
    with OutputFolder(path, FIELD) as folder:
        for name, figure in field_figures(params, reach, smoother):
            content = drawn(lambda figure=figure: png(figure))  # type: ignore[misc]
            folder.file(f"{name}.png").write_bytes(content)
            names.append(f"{name}.png")
        folder.publish(names, anew=True)


def png(figure: Any) -> bytes:
    """Returns a figure as a file's content."""
    content = io.BytesIO()
    figure.savefig(content, format="png")
    return content.getvalue()


def finite(numbers: Any) -> Any:
    """Returns metrics with None for what is not finite, which JSON has no word for."""
    if isinstance(numbers, dict):
        return {key: finite(value) for key, value in numbers.items()}
    if isinstance(numbers, float) and not math.isfinite(numbers):
        return None
    return numbers


def shown_of(run: Run) -> str:
    """Returns what of a run its pictures show, in a few words; empty for all of it."""
    times = run.log["time"]
    if len(times) <= PICTURED:
        return ""
    return f"the first {times[PICTURED - 1]:g} of {times[-1]:g} s"


def _shown(run: Run) -> Run:
    return dc.replace(run, log=head(run.log, PICTURED))


def _png(figure: Any, run: Run) -> bytes:
    if figure is None:
        return b""
    if shown := shown_of(run):
        place = {"ha": "right", "va": "bottom", "fontsize": SMALL, "color": "0.45"}
        figure.text(0.998, 0.002, shown, **place)
    return png(figure)
