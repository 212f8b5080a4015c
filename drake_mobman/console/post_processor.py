"""Post-processing of recordings: one folder at a time, in a process of low priority.

However many recordings end within a second, they take the memory of one.
"""

import contextlib
import json
import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

_NICE = 19
"""Lowest priority: the session goes first."""


class PostProcessor:
    """Completes folders in another process, in turn, and reports those that failed.

    The process ends when there is nothing left to do. If this one ends first, it goes
    on with all that was submitted.
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None
        self._pending: list[Path] = []  # Those that have no answer yet.
        self._answers: list[dict[str, str]] = []
        self._reader: threading.Thread | None = None
        self.failed: list[str] = []  # One line for each that was not completed.

    def submit(self, folder: Path, wall_time: float, died: str) -> None:
        """Has a folder completed; see `recorder.complete` for the arguments."""
        self.poll()
        self._pending.append(folder)
        job = json.dumps({"folder": str(folder), "time": wall_time, "died": died})
        try:
            process = self._process or self._start()
            assert process.stdin
            process.stdin.write(job + "\n")
            process.stdin.flush()
        except OSError as error:
            self._pending.remove(folder)
            self._fail(folder, error)

    def poll(self) -> None:
        """Notes which folders are complete, or have failed, by now."""
        process, reader = self._process, self._reader
        if process is None or reader is None:
            return
        ended = not reader.is_alive()
        while self._answers:
            answer = self._answers.pop(0)
            folder = Path(answer["folder"])
            self._pending.remove(folder)
            if error := answer["error"]:
                self._fail(folder, error)
        if ended:
            status = process.wait()
            for folder in self._pending:
                self._fail(folder, f"its process ended with status {status}")
            self._pending.clear()
        if not self._pending:
            self._close_input()

    @property
    def busy(self) -> bool:
        """Returns whether there are folders that have not been completed."""
        return bool(self._pending)

    def detach(self) -> None:
        """Leaves the process alone: it completes what was submitted, and ends."""
        self._pending.clear()
        self._close_input()

    def _start(self) -> subprocess.Popen[str]:
        # -P: the installed package, whatever the working folder is.
        self._process = process = subprocess.Popen(
            [sys.executable, "-P", "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            start_new_session=True,  # Ctrl-C ends the session, not its recordings.
        )
        self._answers = []
        self._reader = threading.Thread(
            target=_read, args=(process, self._answers), daemon=True
        )
        self._reader.start()
        return process

    def _close_input(self) -> None:
        """Lets the process end once it has done all."""
        process, self._process, self._reader = self._process, None, None
        if process and process.stdin:
            with contextlib.suppress(OSError):
                process.stdin.close()

    def _fail(self, folder: Path, error: object) -> None:
        self.failed.append(f"{folder}: recorded, but not completed: {error}")


def _read(process: Any, answers: list[dict[str, str]]) -> None:
    for line in process.stdout:
        answers.append(json.loads(line))  # noqa: PERF401 - each as soon as it comes.
    process.wait()


def main() -> None:
    """Completes the folders that are named on the standard input, and answers."""
    os.nice(_NICE)
    from drake_mobman.console.recorder import complete  # noqa: PLC0415 - here alone.

    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # What libraries print is not an answer.
    for line in sys.stdin:
        job = json.loads(line)
        error = ""
        try:
            complete(Path(job["folder"]), job["time"], job["died"])
        except (Exception, SystemExit) as raised:  # Drake's assertions are the latter.
            error = f"{type(raised).__name__}: {raised}"
        with contextlib.suppress(OSError):  # The session may have ended.
            answers.write(json.dumps({"folder": job["folder"], "error": error}) + "\n")
            answers.flush()


if __name__ == "__main__":
    main()
