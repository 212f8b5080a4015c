"""Completes the folders of recordings: one at a time, in a process out of the way.

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
"""By how much it gives way to the session."""


class Finisher:
    """Has another process complete folders in turn, and hears what became of them.

    The process ends when there is nothing left to do. It goes on without us, with all
    that it was given, if we end before it.
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None
        self._given: list[Path] = []  # Those that it has not answered for.
        self._answers: list[dict[str, str]] = []
        self._listener: threading.Thread | None = None
        self.failed: list[str] = []  # One line for each that was not completed.

    def give(self, folder: Path, wall_time: float, died: str) -> None:
        """Has a folder completed; see `recorder.finish` for what is given."""
        self.hear()
        self._given.append(folder)
        job = json.dumps({"folder": str(folder), "time": wall_time, "died": died})
        try:
            process = self._process or self._begin()
            assert process.stdin
            process.stdin.write(job + "\n")
            process.stdin.flush()
        except OSError as error:
            self._given.remove(folder)
            self._fail(folder, error)

    def hear(self) -> None:
        """Notes which folders have been completed, or not."""
        process, listener = self._process, self._listener
        if process is None or listener is None:
            return
        ended = not listener.is_alive()
        while self._answers:
            answer = self._answers.pop(0)
            folder = Path(answer["folder"])
            self._given.remove(folder)
            if why := answer["error"]:
                self._fail(folder, why)
        if ended:
            status = process.wait()
            for folder in self._given:
                self._fail(folder, f"its process ended with status {status}")
            self._given.clear()
        if not self._given:
            self._let_go()

    @property
    def works(self) -> bool:
        """Returns whether there are folders that have not been completed."""
        return bool(self._given)

    def leave(self) -> None:
        """Leaves the process to itself: it completes what it was given, and ends."""
        self._given.clear()
        self._let_go()

    def _begin(self) -> subprocess.Popen[str]:
        # -P: what is installed, whatever folder one happens to be in.
        self._process = process = subprocess.Popen(
            [sys.executable, "-P", "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            start_new_session=True,  # Ctrl-C is for the session, not its records.
        )
        self._answers = []
        self._listener = threading.Thread(
            target=_listen, args=(process, self._answers), daemon=True
        )
        self._listener.start()
        return process

    def _let_go(self) -> None:
        process, self._process, self._listener = self._process, None, None
        if process and process.stdin:
            with contextlib.suppress(OSError):
                process.stdin.close()

    def _fail(self, folder: Path, why: object) -> None:
        self.failed.append(f"{folder}: recorded, but not completed: {why}")


def _listen(process: Any, answers: list[dict[str, str]]) -> None:
    for line in process.stdout:
        answers.append(json.loads(line))  # noqa: PERF401 - each as soon as it comes.
    process.wait()


def main() -> None:
    """Completes the folders that are named on the standard input, and answers."""
    os.nice(_NICE)
    from drake_mobman.console.recorder import finish  # noqa: PLC0415 - here alone.

    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # What libraries print is no answer.
    for line in sys.stdin:
        job = json.loads(line)
        why = ""
        try:
            finish(Path(job["folder"]), job["time"], job["died"])
        except (Exception, SystemExit) as error:  # Drake's assertions are the latter.
            why = f"{type(error).__name__}: {error}"
        with contextlib.suppress(OSError):  # Nobody may be there to hear it any more.
            answers.write(json.dumps({"folder": job["folder"], "error": why}) + "\n")
            answers.flush()


if __name__ == "__main__":
    main()
