"""The recordings of a session, one after another, each in a folder of its own."""

import itertools
import time
from collections.abc import Callable
from pathlib import Path

from drake_mobman.console.post_processor import PostProcessor
from drake_mobman.console.recorder import Recorder, check_recordable
from drake_mobman.scenario import AnyScenario
from drake_mobman.simulation.log import Log
from drake_mobman.simulation.output_folder import FolderError

_POLL = 1 / 30
"""Time between two looks at whether folders are complete [s]."""


class Recordings:
    """Records a session to the folder that is wanted, and starts anew at each reset.

    `want` and `problem` may be used in any thread; all else in the session's.

    Args:
        scenario: that is driven.
    """

    def __init__(self, scenario: AnyScenario) -> None:
        self._scenario = scenario
        self._wanted: Path | None = None
        self._recorder: Recorder | None = None
        self._used: set[Path] = set()
        self._post_processor = PostProcessor()
        self._problem = ""  # Of the latest recording.

    @property
    def folder(self) -> Path | None:
        """Returns the folder that is written to, if any."""
        return self._recorder.folder if self._recorder else None

    @property
    def problem(self) -> str:
        """Returns what went wrong, in one line."""
        failed = self._post_processor.failed
        return "; ".join(filter(None, [self._problem, *failed]))

    def want(self, folder: Path | None) -> None:
        """Chooses the folder to record to at the next start, or none from now on.

        Raises:
            FolderError: where the folder cannot take a recording, or has one already.
        """
        if folder is None:
            self._wanted = None
            return
        try:
            folder = folder.resolve()
            check_recordable(self._unused(folder))
        except FolderError:
            raise
        except (OSError, RuntimeError) as error:  # The latter of links in a circle.
            why = getattr(error, "strerror", None) or error
            raise FolderError(f"{folder}: cannot be written, {why}") from None
        self._wanted = folder

    def begin(self) -> None:
        """Begins a recording, if one is wanted; the session is at its start."""
        if self._wanted is None:
            return
        try:
            folder = self._unused(self._wanted)
            self._recorder = Recorder(self._scenario, folder)
        except OSError as error:
            self._problem = f"not recorded: {error}"
            return
        self._used.add(folder)
        self._problem = ""

    def append(self, log: Log, wall_time: float) -> None:
        """Appends to the recording, if there is one, or ends it if it is not wanted.

        Args:
            log: signals since the last call.
            wall_time: since the start [s].
        """
        if self._recorder is None:
            return
        try:
            self._recorder.append(log)
        except OSError as error:
            self._problem = f"recording ended: {error}"
            self._wanted = None
        if self._wanted is None:
            self.end(wall_time)

    def end(self, wall_time: float, died: str = "") -> None:
        """Ends the recording; another process completes its folder.

        Args:
            wall_time: since the start [s].
            died: when and why the simulation died, in one line; empty if it did not.
        """
        recorder, self._recorder = self._recorder, None
        if recorder is None:
            return
        if not recorder.plays:  # Reset at once.
            recorder.drop()
            self._used.discard(recorder.folder)
            return
        recorder.close()
        self._post_processor.submit(recorder.folder, wall_time, died)

    def poll(self) -> None:
        """Notes which folders are complete by now."""
        self._post_processor.poll()

    def close(self, hurried: Callable[[], bool]) -> bool:
        """Waits until all folders are complete; returns whether they are.

        Args:
            hurried: whether to stop waiting; the folders are completed anyway.
        """
        while self._post_processor.busy and not hurried():
            time.sleep(_POLL)
            self.poll()
        complete = not self._post_processor.busy
        self._post_processor.detach()
        return complete

    def _unused(self, folder: Path) -> Path:
        """Returns `folder`, or the first of folder-2, -3 ... once it is recorded to."""
        if folder not in self._used:
            return folder
        numbered = (folder.with_name(f"{folder.name}-{n}") for n in itertools.count(2))
        # One that is being completed may not exist for a moment.
        return next(x for x in numbered if x not in self._used and not x.exists())
