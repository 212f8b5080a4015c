"""A run and its folder: the log first, then the metrics, then the pictures.

After an error or an interrupt, all that was done before is kept, and one line says what
is missing.
"""

import textwrap
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, NamedTuple

from drake_mobman.analysis.metrics import metrics, of_no_sample
from drake_mobman.exit_status import DIED
from drake_mobman.parameters import ParameterError
from drake_mobman.report.pictures import figures, scenes, shown_of
from drake_mobman.scenario import AnyScenario
from drake_mobman.simulation.output_folder import FolderError, OutputFolder
from drake_mobman.simulation.run import Run
from drake_mobman.simulation.run_folder import (
    RUN,
    check_run_folder,
    write_log,
    write_metrics,
    write_pictures,
)
from drake_mobman.simulation.simulate import simulate
from drake_mobman.simulation.stop import Stop
from drake_mobman.simulation.tick_times import tick_times

PART = "log.part"
"""The log as it grows, in the folder's draft."""

_IMPATIENT = 2
"""Number of signals after which metrics and pictures are cut short."""


class Shown(NamedTuple):
    """How the user sees the progress and the errors of a run."""

    complain: Callable[[str], None]  # Prints one line about an error.
    # Shows progress, given a title, the total and its unit.
    progress: Callable[
        [str, float, str], AbstractContextManager[Callable[[float], None]]
    ]


class Wanted(NamedTuple):
    """What to write of a run."""

    figures: bool = True
    scene: bool = False
    every: int = 1  # Keeps each `every`-th sample in the log.


class Job:
    """A scenario, and the folder that its run goes to.

    Args:
        name: of the scenario, for messages.
        scenario: checked, as `load_scenario` returns it.
        folder: new, or of an earlier run.
        wanted: what to write.
        stop: returns whether the user wants to end it.
        shown: how progress and errors are shown.
    """

    def __init__(
        self,
        name: str,
        scenario: AnyScenario,
        folder: Path,
        wanted: Wanted,
        stop: Stop,
        shown: Shown,
    ) -> None:
        self.name = name
        self.scenario = scenario
        self.numbers: dict[str, Any] | None = None  # The metrics, once written.
        self.status = 0  # The exit status.
        self.folder = folder
        self._wanted = wanted
        self._stop = stop
        self._shown = shown

    def run(self) -> None:
        """Simulates, and writes the folder.

        Raises:
            ParameterError: where a block cannot work with its parameters; then the
                folder is unchanged.
        """
        try:
            check_run_folder(self.folder)
            with OutputFolder(self.folder, RUN) as folder:
                run = self._simulated(folder)
                if self._log_written(run, folder):
                    self._write_metrics(run, folder)
                    self._write_pictures(run, folder)
        except ParameterError:
            raise
        except OSError as error:
            self._failed(f"{self.folder}: not written: {_line(error)}", named=True)
        if self._stop():
            self.status = self._stop.status

    def _simulated(self, folder: OutputFolder) -> Run:
        with self._shown.progress(self.name, self.scenario.duration, " s") as progress:
            part = folder.file(PART)
            return simulate(
                self.scenario, progress=progress, stop=self._stop, part=part
            )

    def _log_written(self, run: Run, folder: OutputFolder) -> bool:
        """Writes the log; returns whether it is there."""
        kept = "the log until then is kept"
        try:
            with self._shown.progress(f"{self.name}: log", 100.0, " %") as progress:
                self._write_log(run, folder, progress)
        except Exception as error:
            folder.keeps_draft = True
            part = folder.draft / PART
            self._failed(f"{folder.path}: not written: {_line(error)}; kept in {part}")
            return False
        if run.died:
            self._failed(f"{run.died}; {kept}")
        return True

    def _write_log(
        self, run: Run, folder: OutputFolder, progress: Callable[[float], None]
    ) -> None:
        try:
            write_log(run, folder, self._wanted.every, progress)
        except FolderError as error:
            # A file was put there during the run.
            folder.move_aside()
            self.folder = folder.path
            self._failed(f"{error}; written to {folder.path}", named=True)
            write_log(run, folder, self._wanted.every, progress)

    def _write_metrics(self, run: Run, folder: OutputFolder) -> None:
        numbers = of_no_sample(run)
        total = float(run.time[-1]) if len(run.time) else 1.0
        try:
            title = f"{self.name}: metrics"
            with self._shown.progress(title, total, " s") as progress:
                numbers = self._stop.cut_short(
                    _IMPATIENT, lambda: self._measured(run, progress)
                )
        except KeyboardInterrupt:
            self._failed("interrupted, no metrics; the log is kept")
        except (Exception, SystemExit) as error:
            self._failed(f"metrics not computed: {_line(error)}")
        try:
            self.numbers = write_metrics(numbers, folder)
        except Exception as error:
            self._failed(f"metrics not written: {_line(error)}")

    def _measured(self, run: Run, progress: Callable[[float], None]) -> dict[str, Any]:
        if not (run.died or self._stop()):
            run.tick_times = tick_times(self.scenario)
        return metrics(run, progress)

    def _write_pictures(self, run: Run, folder: OutputFolder) -> None:
        if run.died or not (self._wanted.figures or self._wanted.scene):
            return
        try:
            wrong = self._pictures_made(run, folder)
        except KeyboardInterrupt:
            self._failed("interrupted while drawing; the log is kept")
            return
        except Exception as error:
            wrong = [error]
        if wrong:
            self._failed(f"pictures not written: {_line(wrong[0])}{_more(wrong)}")
        elif part := shown_of(run):
            self._shown.complain(f"{self.name}: pictures show {part}")

    def _pictures_made(self, run: Run, folder: OutputFolder) -> list[BaseException]:
        """Makes the pictures; returns the errors."""
        pictures = figures(run) if self._wanted.figures else {}
        pictures |= scenes(run) if self._wanted.scene else {}

        def drawn(draw: Callable[[], bytes]) -> bytes:
            if self._stop():
                raise KeyboardInterrupt
            return self._stop.cut_short(_IMPATIENT, draw)

        title = f"{self.name}: pictures"
        with self._shown.progress(title, len(pictures), "") as progress:
            return list(write_pictures(pictures, folder, progress, drawn))

    def _failed(self, line: str, *, named: bool = False) -> None:
        self.status = self.status or DIED
        self._shown.complain(line if named else f"{self.name}: {line}")


def _line(error: BaseException) -> str:
    reason = " ".join((str(error) or type(error).__name__).split())
    return textwrap.shorten(reason, 300, placeholder=" ...")


def _more(errors: Sequence[BaseException]) -> str:
    return f" (and {len(errors) - 1} more)" if errors[1:] else ""
